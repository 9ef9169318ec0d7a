// SPDX-License-Identifier: MIT
/// @file  What flight software in C, or a framework that schedules fixed-rate functions, needs around a FlightStack: memory
///        that the caller owns, and signals as plain structs.
///
/// A plain struct has members with the names of the signal, as numbers and arrays, quaternions scalar first: from
/// `struct { uint64_t tick; double q_NB[4], omega_BN_B[3], h_w[4]; uint8_t attitude_invalid, rate_invalid, momentum_invalid; }`
/// comes a Measurement of four actuators. Zero memory says that all was measured: what is not, is said. It may have a sun and a field
/// (`field_valid`, `sun_valid`, `field_B`, `field_N`, `sun_B`, `sun_N`); what was measured of these is said.
/// tests/consumer/wheels.cpp is one by hand, `gyrostat export --target c` writes one. Page: docs/export.md
#pragma once
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <new>
#include <type_traits>

#include "gyrostat/core/signals.hpp"

namespace gyrostat {

/// One stack in `bytes` bytes of any alignment. It stays where it was made: memory that was copied or moved has no stack.
template <class Stack>
class CallerMemory {
 public:
  /// What the caller has to set aside.
  static constexpr std::size_t bytes = sizeof(Stack) + sizeof(std::uint64_t) + 2 * alignof(Stack);

  /// Moves a stack in. Null memory: null.
  static Stack* make(void* memory, const Stack& stack) noexcept {
    if (memory == nullptr) return nullptr;
    Cell* cell = new (aligned(memory)) Cell{made_at(memory), stack};
    return &cell->stack;
  }

  /// The stack; null where none was made.
  static Stack* get(void* memory) noexcept {
    if (memory == nullptr) return nullptr;
    Cell* cell = std::launder(reinterpret_cast<Cell*>(aligned(memory)));
    return cell->mark == made_at(memory) ? &cell->stack : nullptr;
  }
  static const Stack* get(const void* memory) noexcept { return get(const_cast<void*>(memory)); }

 private:
  struct Cell {
    std::uint64_t mark;
    Stack stack;
  };
  static_assert(std::is_trivially_destructible_v<Stack>, "memory of the caller is given back without a call");

  static std::byte* aligned(void* memory) noexcept {
    const std::uintptr_t at = reinterpret_cast<std::uintptr_t>(memory);
    return static_cast<std::byte*>(memory) + (alignof(Cell) - at % alignof(Cell)) % alignof(Cell);
  }
  /// Says that a stack was made, and where.
  static std::uint64_t made_at(const void* memory) noexcept {
    return 0x6779726f73746174u ^ static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(memory));
  }
};

namespace detail {

template <class S, class T>
Vec3<S> vec3_from(const T (&x)[3]) noexcept {
  return {static_cast<S>(x[0]), static_cast<S>(x[1]), static_cast<S>(x[2])};
}
template <class S, class T>
Quat<S> quat_from(const T (&x)[4]) noexcept {
  return {static_cast<S>(x[0]), static_cast<S>(x[1]), static_cast<S>(x[2]), static_cast<S>(x[3])};
}
template <class V, class T, std::size_t N>
void put(const V& v, T (&out)[N]) noexcept {
  for (std::size_t i = 0; i < N; ++i) out[i] = static_cast<T>(v[static_cast<Eigen::Index>(i)]);
}

}  // namespace detail

template <class S, class Plain>
Measurement<S> measurement_from(const Plain& in) noexcept {
  static_assert(std::extent_v<decltype(in.h_w)> <= max_actuators);
  Measurement<S> y;
  y.tick = in.tick;
  y.q_NB = detail::quat_from<S>(in.q_NB);
  y.omega_BN_B = detail::vec3_from<S>(in.omega_BN_B);
  y.h_w.resize(static_cast<Eigen::Index>(std::size(in.h_w)));
  for (std::size_t i = 0; i < std::size(in.h_w); ++i) y.h_w[static_cast<Eigen::Index>(i)] = static_cast<S>(in.h_w[i]);
  if constexpr (requires { in.gimbal; }) {
    y.gimbal.resize(static_cast<Eigen::Index>(std::size(in.gimbal)));
    for (std::size_t i = 0; i < std::size(in.gimbal); ++i)
      y.gimbal[static_cast<Eigen::Index>(i)] = static_cast<S>(in.gimbal[i]);
  }
  y.attitude_valid = in.attitude_invalid == 0;
  y.rate_valid = in.rate_invalid == 0;
  y.momentum_valid = in.momentum_invalid == 0;
  if constexpr (requires { in.field_valid; }) {
    y.field_valid = in.field_valid != 0;
    y.sun_valid = in.sun_valid != 0;
    y.field_B = detail::vec3_from<S>(in.field_B);
    y.field_N = detail::vec3_from<S>(in.field_N);
    y.sun_B = detail::vec3_from<S>(in.sun_B);
    y.sun_N = detail::vec3_from<S>(in.sun_N);
  }
  return y;
}

template <class S, class Plain>
Reference<S> reference_from(const Plain& in) noexcept {
  Reference<S> ref;
  ref.q_NR = detail::quat_from<S>(in.q_NR);
  ref.omega_RN_R = detail::vec3_from<S>(in.omega_RN_R);
  ref.omegadot_RN_R = detail::vec3_from<S>(in.omegadot_RN_R);
  ref.event = in.event;
  return ref;
}

/// u, demand_B, achieved_B, saturated (bit mask), status (bits of Flag).
template <class S, class Plain>
void to_plain(const Allocation<S>& a, Plain& out) noexcept {
  detail::put(a.u, out.u);
  detail::put(a.demand_B, out.demand_B);
  detail::put(a.achieved_B, out.achieved_B);
  out.saturated = a.saturated.bits();
  out.status = a.status.bits();
}

/// q_NB, omega_BN_B, d_B, effectiveness, effectiveness_bound, changed, failed, enabled (bit masks), events; fault_class
/// (numbers of FaultClass), gain and bias where there is a fault_class. Before the first step: healthy actuators that nobody has
/// looked at.
template <class S, class Plain>
void to_plain(const Estimate<S>& x, const Detection<S>& det, Plain& out) noexcept {
  out.q_NB[0] = static_cast<std::remove_reference_t<decltype(out.q_NB[0])>>(x.q_NB.w());
  for (int i = 0; i < 3; ++i)
    out.q_NB[i + 1] = static_cast<std::remove_reference_t<decltype(out.q_NB[0])>>(x.q_NB.vec()[i]);
  detail::put(x.omega_BN_B, out.omega_BN_B);
  detail::put(x.d_B, out.d_B);
  constexpr int n = static_cast<int>(std::extent_v<decltype(out.effectiveness)>);
  const bool estimated = x.effectiveness.size() == n;
  detail::put(estimated ? x.effectiveness : VecN<S>(VecN<S>::Ones(n)), out.effectiveness);
  detail::put(estimated ? x.effectiveness_bound : VecN<S>(VecN<S>::Constant(n, std::numeric_limits<S>::infinity())),
              out.effectiveness_bound);
  out.changed = det.changed.bits();
  out.failed = det.failed.bits();
  out.enabled = det.enabled.bits();
  out.events = det.event;
  if constexpr (requires { out.fault_class; }) {
    const bool told = det.gain.size() == n && det.bias.size() == n;
    detail::put(told ? det.gain : VecN<S>(VecN<S>::Ones(n)), out.gain);
    detail::put(told ? det.bias : VecN<S>(VecN<S>::Zero(n)), out.bias);
    for (std::size_t i = 0; i < n; ++i) out.fault_class[i] = static_cast<std::uint8_t>(det.classes[i]);
  }
}

}  // namespace gyrostat
