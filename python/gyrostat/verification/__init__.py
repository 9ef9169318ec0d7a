# SPDX-License-Identifier: MIT
"""From a requirement to a verdict: sequential tests, failures too rare to sample, the smallest fault that loses.

The mathematics here knows no flights: it works on the numbers of failing runs and on functions
``margin(z: (n, d)) -> (n,)``. Page: docs/verification.md
"""
