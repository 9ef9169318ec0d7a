// SPDX-License-Identifier: MIT
/// @file  A component without a stack: it holds the vehicle that a stack would hand to every call.
#pragma once
#include "gyrostat/core/params.hpp"

namespace gyrostat::test {

template <class T>
class Alone : public T {
 public:
  using Component = T;
  using S = typename T::Scalar;
  Alone(Unchecked, const Setup<S>& setup, const typename T::Params& params)
      : T(unchecked, setup, params), vehicle_(setup.vehicle) {}

  auto start(const Measurement<S>& y) noexcept { return T::start(vehicle_, y); }
  auto step(const Measurement<S>& y) noexcept { return T::step(vehicle_, y); }
  auto step(const Measurement<S>& y, const Allocation<S>& last) noexcept { return T::step(vehicle_, y, last); }
  auto skip(const Measurement<S>& y, const Allocation<S>& last) noexcept { return T::skip(vehicle_, y, last); }

  auto start(const Estimate<S>& x) noexcept { return T::start(vehicle_, x); }
  auto step(const Estimate<S>& x, const Allocation<S>& last) noexcept { return T::step(vehicle_, x, last); }

  auto start(const Estimate<S>& x, const Detection<S>& det, const Reference<S>& ref) noexcept {
    return T::start(vehicle_, x, det, ref);
  }
  auto step(const Estimate<S>& x, const Detection<S>& det, const Reference<S>& ref,
            const Allocation<S>& last) noexcept {
    return T::step(vehicle_, x, det, ref, last);
  }

  auto step(const Demand<S>& demand, const Estimate<S>& x, const Detection<S>& det) noexcept {
    return T::step(vehicle_, demand, x, det);
  }
  void reset() noexcept { T::reset(vehicle_); }

 private:
  Vehicle<S> vehicle_;
};

/// With its default parameters, whatever its `check` says of them.
template <class T>
Alone<T> alone(const Setup<typename T::Scalar>& setup) {
  return {unchecked, setup, typename T::Params(setup)};
}

}  // namespace gyrostat::test
