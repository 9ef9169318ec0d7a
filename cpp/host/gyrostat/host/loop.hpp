// SPDX-License-Identifier: MIT
/// @file  The closed loop: sense, step the flight stack, hold the command, integrate truth to the next sample.
#pragma once
#include <functional>
#include <string>

#include "gyrostat/flight/stack.hpp"
#include "gyrostat/host/reference.hpp"
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

/// What takes part in a run from outside the catalogue, between two integrations. An empty function: nothing.
struct Outside {
  std::function<void(Measurement<double>&)> sensor;      ///< changes what the sensors show
  std::function<void(double t, VecN<double>& u)> fault;  ///< changes the command on its way to the actuators
  std::function<Vec3<double>(double t, const Quat<double>& q_NB, const Vec3<double>& omega_BN_B)>
      torque_B;  ///< N m, held until the next sample
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
      if constexpr (requires { plant.push(Vec3<double>()); }) {
        if (outside.torque_B) plant.push(outside.torque_B(end.time, plant.q_NB(), plant.omega_BN_B()));
      }
      if (!outside.fault) {
        plant.advance(stack.last().u);
        continue;
      }
      VecN<double> u = stack.last().u;
      outside.fault(end.time, u);
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
