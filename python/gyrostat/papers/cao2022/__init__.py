# SPDX-License-Identifier: MIT
"""Cao, Gong, Han 2022: learning observer of actuator effectiveness and predefined-time attitude control."""
