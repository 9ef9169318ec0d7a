// SPDX-License-Identifier: MIT
/// @file  The flight half of the loop: the one place where the order of things is written, and the guard.
///
/// Guard (guard.hpp says what is impossible): of an invalid measurement, attitude and rate are carried on by the model and
/// teach nothing, an invalid reference holds the last valid one; an impossible output restarts its component and the previous
/// command is issued again; the command is clipped to its box and its rate once more, and rounded to whole pulses where actuators
/// are on/off (pulses.hpp). Each but the rounding sets a Flag in the status.
///
///     typename Stack::Params p(setup);  // defaults for the vehicle
///     p.controller.K = 2;
///     Checked<Stack> stack(setup, p);   // a stack, or the refusal of `check`
///     if (!stack) return report(stack.status());
///
/// Page: docs/flight_software.md
#pragma once
#include <utility>

#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/axes.hpp"
#include "gyrostat/flight/desaturation.hpp"
#include "gyrostat/flight/estimator.hpp"
#include "gyrostat/flight/inputs.hpp"
#include "gyrostat/flight/navigation.hpp"
#include "gyrostat/flight/parts/effectiveness_floor.hpp"
#include "gyrostat/flight/pulses.hpp"

namespace gyrostat {

/// In front of the observer stands a navigator, which sees every sample, valid or not; `G` says where actuators point, `M` adds
/// to what the controller asks for.
template <Observer O, Detector D, Controller C, Allocator A, Navigator N = NoNavigator<typename O::Scalar>,
          class G = FixedAxes, class M = NoManagement>
  requires(std::same_as<G, FixedAxes> || Geometry<G, typename O::Scalar>) &&
          (std::same_as<M, NoManagement> || Management<M, typename O::Scalar>)
class FlightStack {
 public:
  using Scalar = typename O::Scalar;
  static constexpr bool cannot_throw =
      Estimator<O, D>::cannot_throw && Navigation<N>::cannot_throw &&
      noexcept(std::declval<C&>().step(std::declval<const Vehicle<Scalar>&>(), std::declval<const Estimate<Scalar>&>(),
                                       std::declval<const Detection<Scalar>&>(),
                                       std::declval<const Reference<Scalar>&>(),
                                       std::declval<const Allocation<Scalar>&>())) &&
      noexcept(std::declval<A&>().step(std::declval<const Vehicle<Scalar>&>(), std::declval<const Demand<Scalar>&>(),
                                       std::declval<const Estimate<Scalar>&>(),
                                       std::declval<const Detection<Scalar>&>()));

  /// Parameters of the components, with their defaults for the vehicle.
  struct Params {
    typename O::Params observer;
    typename D::Params detector;
    typename C::Params controller;
    typename A::Params allocator;
    typename N::Params navigator;
    [[no_unique_address]] G geometry{};                     ///< of moving axes
    [[no_unique_address]] typename M::Params desaturation;  ///< of momentum management

    explicit Params(const Setup<Scalar>& setup) noexcept
        : observer(setup),
          detector(setup),
          controller(setup),
          allocator(setup),
          navigator(setup),
          desaturation(setup) {}
  };

  /// What each component says of its parameters, and what observer and allocator must agree on.
  static Status<Scalar> check(const Setup<Scalar>& setup, const Params& p) noexcept {
    return component_check<O>(setup, p.observer) && component_check<D>(setup, p.detector) &&
           component_check<C>(setup, p.controller) && component_check<A>(setup, p.allocator) &&
           component_check<N>(setup, p.navigator) && component_check<M>(setup, p.desaturation) &&
           actuators_can_recover(effectiveness_floor_of<O>(p.observer), effectiveness_floor_of<A>(p.allocator));
  }

  /// `Checked<FlightStack<...>>` asks `check` before it comes here.
  FlightStack(Unchecked, const Setup<Scalar>& setup, const Params& p)
      : FlightStack(unchecked, setup, O(unchecked, setup, p.observer), D(unchecked, setup, p.detector),
                    C(unchecked, setup, p.controller), A(unchecked, setup, p.allocator),
                    N(unchecked, setup, p.navigator), p.geometry, M(unchecked, setup, p.desaturation)) {}

  /// Of components that are there already; whether they agree with each other nobody asks.
  FlightStack(Unchecked, const Setup<Scalar>& setup, O observer, D detector, C controller_, A allocator_, N navigator_,
              G geometry = {}, M management = {})
      : navigation(std::move(navigator_)),
        estimator(setup, std::move(observer), std::move(detector)),
        controller(std::move(controller_)),
        allocator(std::move(allocator_)),
        du_max_(setup.vehicle.u_rate * setup.dt),
        pulses_(any_pulses(setup.vehicle)),
        geometry_(std::move(geometry)),
        management_(std::move(management)),
        last_(idle()) {}

  FlightStack(Unchecked, const Setup<Scalar>& setup, O observer, D detector, C controller_, A allocator_)
    requires std::same_as<N, NoNavigator<Scalar>>
      : FlightStack(unchecked, setup, std::move(observer), std::move(detector), std::move(controller_),
                    std::move(allocator_), N(unchecked, setup, typename N::Params(setup))) {}

  /// One sample, whatever the inputs hold. The first call with valid ones starts the components; none before it has an effect.
  const Allocation<Scalar>& step(const Measurement<Scalar>& y_in,
                                 const Reference<Scalar>& ref_in) noexcept(cannot_throw) {
    const bool flies = inputs_.take(guard(), navigation.take(guard(), y_in), ref_in, estimator.estimate(), last_.u);
    if constexpr (!std::same_as<G, FixedAxes>) inputs_.point(geometry_(vehicle(), inputs_.measurement()));
    actions_ = inputs_.replaced();
    actions_.navigator = navigation.restarted();
    Flags status;
    if (actions_.navigator) status.set(Flag::component_reset);
    if (actions_.measurement() || actions_.reference) status.set(Flag::input_held);
    if (!flies) {
      last_.status = status;
      return last_;
    }
    if (started_) {
      estimator.step(inputs_.measurement(), last_);
      demand_ = controller.step(vehicle(), estimator.estimate(), estimator.detection(), inputs_.reference(), last_);
    } else {
      allocator.reset(vehicle());
      estimator.start(inputs_.measurement());
      demand_ = controller.start(vehicle(), estimator.estimate(), estimator.detection(), inputs_.reference());
      started_ = true;
    }
    const Estimate<Scalar>& x = estimator.estimate();
    const Detection<Scalar>& det = estimator.detection();
    actions_.observer = estimator.actions().observer;
    actions_.detector = estimator.actions().detector;
    bool hold = x.status.has(Flag::component_reset);
    if (!guard().possible(demand_)) {
      demand_ = controller.start(vehicle(), x, det, inputs_.reference());
      if (!guard().possible(demand_)) demand_ = {};
      hold = actions_.controller = true;
    }
    if (demand_.u_pref.size() == 0) demand_.u_pref.setZero(vehicle().actuators());
    if constexpr (!std::same_as<M, NoManagement>) management_(vehicle(), x, det, demand_);
    if (det.u_probe.size() != 0) demand_.u_pref += det.u_probe;
    Allocation<Scalar> next = allocator.step(vehicle(), demand_, x, det);
    if (!guard().possible(next)) {
      allocator.reset(vehicle());
      hold = actions_.allocator = true;
    }
    if (hold) {
      const VecN<Scalar> previous = guard().sane(last_.u) ? last_.u : idle().u;
      next = Allocation<Scalar>::idle(vehicle().actuators());
      next.u = previous;
      next.demand_B = demand_.tau_B;
      next.achieved_B = torque<Scalar>(x.axes.of(vehicle().D_B), x.effectiveness.cwiseProduct(previous));
      status.set(Flag::component_reset);
      status.set(Flag::command_held);
      actions_.command = true;
    }
    clip_once_more(next, x);
    next.status = next.status | x.status | demand_.status | status;
    last_ = next;
    return last_;
  }

  /// As constructed: the next step starts the components again.
  void reset() noexcept {
    started_ = false;
    navigation.reset();
    inputs_ = {};
    actions_ = {};
    last_ = idle();
  }

  const Estimate<Scalar>& estimate() const noexcept { return estimator.estimate(); }
  const Detection<Scalar>& detection() const noexcept { return estimator.detection(); }
  const Demand<Scalar>& demand() const noexcept { return demand_; }
  /// What was issued last.
  const Allocation<Scalar>& last() const noexcept { return last_; }
  /// The measurement as the components got it; its valid bits say what was truly measured.
  const Measurement<Scalar>& measurement() const noexcept { return inputs_.measurement(); }
  /// Whether the components have begun.
  bool started() const noexcept { return started_; }
  /// What the guard did at this sample.
  const GuardActions& actions() const noexcept { return actions_; }

  [[no_unique_address]] Navigation<N> navigation;
  Estimator<O, D> estimator;
  C controller;
  A allocator;

 private:
  const Guard<Scalar>& guard() const noexcept { return estimator.guard(); }
  const Vehicle<Scalar>& vehicle() const noexcept { return guard().vehicle(); }

  Allocation<Scalar> idle() const noexcept {
    Allocation<Scalar> a = Allocation<Scalar>::idle(vehicle().actuators());
    a.u = clip<Scalar>(a.u, vehicle().u_lo, vehicle().u_up);
    return a;
  }

  void clip_once_more(Allocation<Scalar>& a, const Estimate<Scalar>& x) const noexcept {
    const VecN<Scalar> lo = vehicle().u_lo.cwiseMax(last_.u - du_max_);
    const VecN<Scalar> up = vehicle().u_up.cwiseMin(last_.u + du_max_);
    VecN<Scalar> inside = clip<Scalar>(a.u, lo, up);
    if (pulses_) inside = as_pulses<Scalar>(vehicle(), inside);
    const bool outside = inside != a.u;
    a.u = inside;
    a.saturated = a.saturated | saturated<Scalar>(a.u, lo, up);
    if (outside) a.achieved_B = torque<Scalar>(x.axes.of(vehicle().D_B), x.effectiveness.cwiseProduct(a.u));
  }

  VecN<Scalar> du_max_;  ///< N m a sample
  bool pulses_;          ///< some actuators are on/off
  [[no_unique_address]] G geometry_;
  [[no_unique_address]] M management_;
  Inputs<Scalar> inputs_;
  Demand<Scalar> demand_;
  Allocation<Scalar> last_;
  GuardActions actions_;
  bool started_ = false;
};

}  // namespace gyrostat
