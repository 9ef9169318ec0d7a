// SPDX-License-Identifier: MIT
/// @file  Effectors: what a commanded actuator, or a part of the vehicle that moves, contributes to the equations of motion.
///
/// Over one smooth piece of time the drive of a channel (its command, with its faults) is a polynomial, so minus its integral,
/// the *impulse* P(t), is one too: known exactly, and continuous over commands and faults. One rule makes every kind fit:
/// the momentum of an effector is a smooth function of P, of states of its own and of the attitude, never of a rate. States
/// are conjugate momenta. Then
///
///     w = J^-1 (H - sum P_i g_i - sum momentum_B(P, y, q)),   J constant: the total inertia less all inertia_B
///
/// and nothing jumps at a command. Output limits and their kinks are the drive's and no effector knows them; momentum limits
/// and dry friction are a wheel's (wheel.hpp).
#pragma once
#include <algorithm>
#include <concepts>
#include <cstdint>
#include <tuple>
#include <vector>

#include "gyrostat/core/types.hpp"

namespace gyrostat::truth {

/// Where an impulse goes. `inner`: the vehicle keeps it (wheels); `outer`: it leaves (torquers).
enum class Storage : std::uint8_t { inner, outer };

/// What an effector sees of the vehicle. The rate is not known yet where momenta are asked for.
struct Scene {
  double t;
  Quat<double> q_NB;
  Vec3<double> omega_BN_B;
  Vec3<double> field_B = Vec3<double>::Zero();  ///< T, where magnetorquers fly
  Vec3<double> drift_B = Vec3<double>::Zero();  ///< T/s, how it changes in N, seen in body axes

  /// T/s, in the body.
  Vec3<double> field_rate_B() const noexcept { return drift_B - omega_BN_B.cross(field_B); }
};

namespace detail {
/// Part of the right-hand side itself, with its own states y. What leaves the vehicle also says which external torque is
/// left when its momentum is counted; what holds momentum beside its axis, how that changes (P' and y' at hand).
template <class E>
concept Coupled = requires(const E& e, const Scene& s, double P, const double* y, double* ydot) {
  { e.momentum_B(s, P, y) } noexcept -> std::same_as<Vec3<double>>;  // without the part along its axis
  { e.rates(s, P, y, ydot) } noexcept;
  requires E::states == 0 || requires {
    { e.start(s, ydot) } noexcept;  // its states at the start
  };
  requires E::storage == Storage::inner || requires {
    { e.torque_B(s, P, y) } noexcept -> std::same_as<Vec3<double>>;
  };
  requires E::along_axis || requires {
    { e.momentum_rate_B(s, P, P, y, y) } noexcept -> std::same_as<Vec3<double>>;
  };
};
}  // namespace detail

/// A kind with states, or whose impulse is not along a fixed axis, has to say what it does in the right-hand side.
template <class E>
concept Effector = requires(const E& e) {
  { E::name } -> std::convertible_to<const char*>;
  { e.channel } -> std::convertible_to<int>;              // of the command; -1: none
  requires std::same_as<decltype(E::states), const int>;  // of its own, integrated with the body
  requires std::same_as<decltype(E::along_axis),
                        const bool>;  // P goes along D_B.col(channel), into one polynomial for all
  requires std::same_as<decltype(E::storage), const Storage>;
  { e.inertia_B() } -> std::same_as<Mat3<double>>;  // of the total inertia, what its momentum already counts
  requires(E::states == 0 && E::along_axis) || detail::Coupled<E>;
};

/// The effectors of a vehicle, by kind: no virtual call and no heap in a step.
template <Effector... E>
class EffectorList {
 public:
  template <class T>
  static constexpr bool has = (std::same_as<E, T> || ...);
  static constexpr int most_states = std::max({0, E::states...});  ///< of one effector

  /// Whether some kind is so.
  static constexpr bool any(auto is) { return (is.template operator()<E>() || ...); }

  template <class T>
  void add(T effector) {
    std::get<std::vector<T>>(lists_).push_back(std::move(effector));
  }
  template <class F>
  void each(F&& f) const {
    (each_of<E>(std::get<std::vector<E>>(lists_), f), ...);
  }
  template <class F>
  void each(F&& f) {
    (each_of<E>(std::get<std::vector<E>>(lists_), f), ...);
  }
  /// Of those in the right-hand side. Their states follow each other in this order.
  template <class F>
  [[gnu::always_inline]] void each_coupled(F&& f) const {
    const auto of = [&]<class T>(const std::vector<T>& list) __attribute__((always_inline)) {
      if constexpr (detail::Coupled<T>) each_of<T>(list, f);
    };
    (of(std::get<std::vector<E>>(lists_)), ...);
  }
  bool coupled() const noexcept { return ((detail::Coupled<E> && !std::get<std::vector<E>>(lists_).empty()) || ...); }
  int states() const noexcept {
    return (0 + ... + (E::states * static_cast<int>(std::get<std::vector<E>>(lists_).size())));
  }

 private:
  template <class T, class F>
  [[gnu::always_inline]] static void each_of(auto& list, F& f) {
    for (auto& effector : list) f(effector);
  }
  std::tuple<std::vector<E>...> lists_;
};

}  // namespace gyrostat::truth
