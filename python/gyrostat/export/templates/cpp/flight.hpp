// SPDX-License-Identifier: MIT
// Written by gyrostat @version@ from the scenario '@title@':
//   @stack@
// Change the scenario and export again, or change Parameters where you make the stack.
#pragma once
#include <limits>

@includes @

    namespace @ namespace @{

        /// The flight stack for S = double or float. Header-only, no heap, no exceptions; needs Eigen.
        ///
        ///     auto stack = @namespace@::Flight<double>::make();
        ///     const gyrostat::Allocation<double>& command = stack.step(measurement, reference);  // once every @dt@ s
        template <class S>
        struct Flight{@aliases @ using Stack = gyrostat::FlightStack<Observer, Detector, Controller, Allocator>;

static constexpr int actuators = @actuators @;
static constexpr double dt = @dt @;  ///< s, period of the calls
static constexpr bool allow_unstable = @allow_unstable @;

struct Parameters {
  typename Observer::Params observer;
  typename Detector::Params detector;
  typename Controller::Params controller;
  typename Allocator::Params allocator;
  bool complete = true;  ///< false: this gyrostat does not take one of the values below
};

/// The nominal vehicle: all that flight knows of it.
static gyrostat::Setup<S> setup() noexcept {
  [[maybe_unused]] constexpr double infinite = std::numeric_limits<double>::infinity();
  gyrostat::Setup<S> setup;
  setup.dt = S(dt);
  gyrostat::Vehicle<S>& v = setup.vehicle;
  @vehicle @ return setup;
}

/// Every parameter of every component, by the name of the catalogue (`gyrostat describe`).
static Parameters parameters() noexcept {
  using gyrostat::set_parameter;
  [[maybe_unused]] constexpr double infinite = std::numeric_limits<double>::infinity();
  const gyrostat::Setup<S> s = setup();
  Parameters p{gyrostat::default_params<Observer>(s), gyrostat::default_params<Detector>(s),
               gyrostat::default_params<Controller>(s), gyrostat::default_params<Allocator>(s)};
  [[maybe_unused]] const auto take = [&p](bool taken) { p.complete = p.complete && taken; };
  @parameters @ return p;
}

/// Whether the components accept the parameters; if not, the first refusal with its number and limit.
static gyrostat::Status<S> check(const Parameters& p) noexcept {
  const gyrostat::Setup<S> s = setup();
  return gyrostat::Status<S>::require(p.complete, "parameters taken", S(0), S(1), "=") &&
         accepted(gyrostat::component_check<Observer>(s, p.observer)) &&
         accepted(gyrostat::component_check<Detector>(s, p.detector)) &&
         accepted(gyrostat::component_check<Controller>(s, p.controller)) &&
         accepted(gyrostat::component_check<Allocator>(s, p.allocator));
}

static Stack make(const Parameters& p = parameters()) noexcept {
  const gyrostat::Setup<S> s = setup();
  return Stack(s, Observer(s, p.observer), Detector(s, p.detector), Controller(s, p.controller),
               Allocator(s, p.allocator));
}

private:
static gyrostat::Status<S> accepted(const gyrostat::Status<S>& status) noexcept {
  return allow_unstable && status.code == gyrostat::Status<S>::Code::unstable ? gyrostat::Status<S>{} : status;
}
}
;

}  // namespace @namespace@
