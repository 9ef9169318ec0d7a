# SPDX-License-Identifier: MIT
"""Cao, Gong, Xue, Wen 2023: learning observer with memory and preassigned-time control in Euler angles."""
