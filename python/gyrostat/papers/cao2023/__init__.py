# SPDX-License-Identifier: MIT
"""Li, Hu, Yang, Postolache 2018: finite-time disturbance observer and integral sliding mode under wheel failures."""
