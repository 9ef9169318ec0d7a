# SPDX-License-Identifier: MIT
"""Yang, Yang, Ji, Ma 2023: learning observer, detection, prescribed performance and robust allocation under faults."""
