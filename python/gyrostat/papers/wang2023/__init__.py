# SPDX-License-Identifier: MIT
"""Wang, Jia, Yu 2023: mixed learning observer and mixed learning sliding mode under additive torque faults."""
