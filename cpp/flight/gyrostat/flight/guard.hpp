// SPDX-License-Identifier: MIT
/// @file  What the stack's guard asks of a signal: is it finite?
#pragma once
#include <cmath>

#include "gyrostat/core/signals.hpp"

namespace gyrostat {

namespace detail {
template <class S>
bool is_finite(const Quat<S>& q) noexcept {
  return q.coeffs().allFinite();
}
template <class S>
bool is_finite(const EulerState<S>& e) noexcept {
  return e.angles.allFinite() && e.rates.allFinite();
}
}  // namespace detail

template <class S>
bool is_finite(const Measurement<S>& y) noexcept {
  return detail::is_finite(y.q_NB) && y.omega_BN_B.allFinite() && y.h_w.allFinite() && detail::is_finite(y.euler);
}
template <class S>
bool is_finite(const Reference<S>& r) noexcept {
  return detail::is_finite(r.q_NR) && r.omega_RN_R.allFinite() && r.omegadot_RN_R.allFinite() &&
         detail::is_finite(r.euler) && r.euler_accelerations.allFinite();
}
/// An infinite effectiveness_bound means "never excited" and is allowed; NaN is not.
template <class S>
bool is_finite(const Estimate<S>& x) noexcept {
  return detail::is_finite(x.q_NB) && x.omega_BN_B.allFinite() && x.h_w.allFinite() && detail::is_finite(x.euler) &&
         x.effectiveness.allFinite() && !x.effectiveness_bound.hasNaN() && x.d_B.allFinite();
}
template <class S>
bool is_finite(const Detection<S>& det) noexcept {
  return det.u_probe.allFinite();
}
template <class S>
bool is_finite(const Demand<S>& demand) noexcept {
  return demand.tau_B.allFinite() && demand.u_pref.allFinite();
}
template <class S>
bool is_finite(const Allocation<S>& a) noexcept {
  return a.u.allFinite() && a.achieved_B.allFinite();
}

}  // namespace gyrostat
