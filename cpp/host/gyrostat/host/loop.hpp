// SPDX-License-Identifier: MIT
/// @file  The closed loop: sense, step the flight stack, hold the command, integrate truth to the next sample.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gyrostat/flight/stack.hpp"
#include "gyrostat/host/reference.hpp"
#include "gyrostat/host/telemetry.hpp"
#include "gyrostat/truth/plant.hpp"

namespace gyrostat::host {

/// How a run ended. Only a flight among many ends as `refused`: before it began, for values that fit no vehicle.
struct RunEnd {
  enum class Code { completed, singular, non_finite, integration_failed, no_command, refused };
  Code code = Code::completed;
  std::string cause;
  double time = 0;  ///< s, last sample reached
  Tick samples = 0, held = 0,
       issued = 0;  ///< in all; where the guard replaced something; with a command of the stack's own

  /// Share of the samples at which an input was replaced or the previous command issued again.
  double held_fraction() const { return samples == 0 ? 0 : static_cast<double>(held) / static_cast<double>(samples); }
};

/// What the guard did, in words: "attitude and rate not measured, controller started again".
std::string text_of(const GuardActions& did);

/// What an actuator from outside gives over the interval that begins.
struct Drive {
  int actuator = 0;
  /// Puts into `steps` what it gives from t on, of a command u that arrives (N m, A m^2 of a magnetorquer), with h_w (N m s) in it.
  std::function<void(double t, double u, double h_w, const Vec3<double>& omega_BN_B,
                     std::vector<truth::DriveStep>& steps)>
      deliver;
};

/// What takes part in a run from outside the catalogue, between two integrations. An empty function: nothing.
struct Outside {
  ReferencePath::Function reference;
  std::function<void(Measurement<double>&)> sensor;      ///< changes what the sensors show
  std::function<void(double t, VecN<double>& u)> fault;  ///< changes the command on its way to the actuators
  std::function<Vec3<double>(double t, const Quat<double>& q_NB, const Vec3<double>& omega_BN_B)>
      torque_B;  ///< N m, held until the next sample
  std::vector<Drive> drives;
  std::vector<std::pair<std::string, std::shared_ptr<const Reporting>>>
      reports;  ///< what they publish, under which name

  bool acts() const noexcept { return fault || torque_B || !drives.empty(); }
  /// Of the command that is issued: what arrives at the actuators, and what those from outside make of it.
  template <truth::Plant Plant>
  void act(Plant& plant, double t, VecN<double>& u) const {
    if (fault) fault(t, u);
    if constexpr (acts_on<Plant>) {
      std::vector<truth::DriveStep> steps;
      for (const Drive& d : drives) {
        d.deliver(t, plant.arriving(d.actuator, u[d.actuator]), plant.h_w()[d.actuator], plant.omega_BN_B(), steps);
        plant.drive(d.actuator, steps);
      }
      if (torque_B) plant.push(torque_B(t, plant.q_NB(), plant.omega_BN_B()));
    }
  }

 private:
  template <class Plant>
  static constexpr bool acts_on =
      requires(Plant& p, std::vector<truth::DriveStep> steps) { p.push(Vec3<double>()), p.drive(0, steps); };
};

/// Looks on without a part in the loop. `before` sees a measurement and what was issued over the interval just ended,
/// `after` the same sample once the stack has stepped.
struct NobodyWatches {
  void before(const Measurement<double>&, const Allocation<double>&) {}
  void after(Tick, const Measurement<double>&, const Reference<double>&) {}
};

/// Flies `ticks` intervals; samples 0 ... ticks are stepped. A failing integration or a singularity ends the run with
/// its time and cause, and one in which the stack never issued a command of its own is none; an exception of a component
/// passes through.
template <truth::Plant Plant, class Stack, class Watcher = NobodyWatches>
RunEnd fly(Plant& plant, truth::Sensors& sensors, ReferencePath& reference, Stack& stack, Tick ticks,
           Watcher&& watcher = Watcher{}, const Outside& outside = {}) {
  RunEnd end;
  try {
    for (Tick k = 0;; ++k) {
      Measurement<double> y = plant.measure(sensors);
      if (outside.sensor) outside.sensor(y);
      const Reference<double>& ref = reference.at(k);
      watcher.before(y, stack.last());
      stack.step(y, ref);
      const GuardActions& did = stack.actions();
      ++end.samples;
      if (did.measurement() || did.reference || did.command) ++end.held;
      if (stack.started() && !did.command) ++end.issued;
      end.time = plant.time();
      watcher.after(k, y, ref);
      if ((stack.demand().status | stack.estimate().status).has(Flag::singular)) {  // not of the gimbals
        const double pitch_deg = plant.euler().angles[1] * 57.295779513082320877;
        end.code = RunEnd::Code::singular;
        end.cause = "Euler angles are singular: pitch " + std::to_string(pitch_deg) +
                    " deg at t = " + std::to_string(end.time) + " s";
        return end;
      }
      if (k == ticks) {
        if (end.issued > 0) return end;
        end.code = RunEnd::Code::no_command;
        end.cause = "the stack never issued a command of its own: " + text_of(did);
        return end;
      }
      if (!outside.acts()) {
        plant.advance(stack.last().u);
        continue;
      }
      VecN<double> u = stack.last().u;
      outside.act(plant, end.time, u);
      plant.advance(u);
    }
  } catch (const truth::NonFiniteState& e) {
    end.code = RunEnd::Code::non_finite;
    end.cause = e.what();
  } catch (const truth::IntegrationError& e) {
    end.code = RunEnd::Code::integration_failed;
    end.cause = e.what();
  }
  return end;
}

}  // namespace gyrostat::host
