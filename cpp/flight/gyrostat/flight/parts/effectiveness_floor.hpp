// SPDX-License-Identifier: MIT
/// @file  The effectiveness below which an actuator counts as dead, for observers and allocators alike.
///
/// What is not commanded cannot be seen: an observer whose estimate falls below the weakest actuator that the allocator still
/// commands never sees that actuator recover. Page: docs/components/learning_effectiveness.md
#pragma once
#include "gyrostat/core/params.hpp"

namespace gyrostat {

/// Default smallest estimate of every observer, and default weakest actuator of every allocator.
template <class S>
inline constexpr S default_effectiveness_floor = S(0.05);

/// Smallest estimate of an observer, or weakest actuator that an allocator commands, by their
/// `static constexpr S effectiveness_floor(const Params&)`; -1 of components that have none.
template <class Component>
constexpr typename Component::Scalar effectiveness_floor_of(const typename Component::Params& params) noexcept {
  if constexpr (requires { Component::effectiveness_floor(params); }) {
    return Component::effectiveness_floor(params);
  } else {
    return typename Component::Scalar(-1);
  }
}

/// What an observer and an allocator must agree on. An observer without a floor estimates nothing that could be lost.
template <class S>
Status<S> actuators_can_recover(S observer_floor, S allocator_floor) noexcept {
  return Status<S>::require(observer_floor < S(0) || observer_floor >= allocator_floor,
                            "e_min of the observer, whose actuator would never be commanded again,", observer_floor,
                            allocator_floor, ">=", Status<S>::Code::unstable);
}

}  // namespace gyrostat
