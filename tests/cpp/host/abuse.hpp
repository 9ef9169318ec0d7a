// SPDX-License-Identifier: MIT
/// @file  A closed loop whose inputs are spoilt now and then: what came out, and how long until it flew normally again.
#pragma once
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "../../../benchmarks/scenarios.hpp"
#include "../random.hpp"
#include "gyrostat/host/assembly.hpp"
#include "gyrostat/host/loop.hpp"

namespace gyrostat::test {

/// Ways to spoil a measurement or a reference.
enum class Spoil {
  nan_rate,
  infinite_attitude,
  nan_momentum,
  nan_reference,
  huge_rate,
  huge_momentum,
  huge_reference,
  zero_quaternion,
  unnormalised_quaternion,
  tiny_numbers,
  wrong_state,
  frozen,
  tick_jump,
  count
};

/// A finite number of any size and sign.
inline double any_size(Random& random) {
  const double size = random.log_uniform(1e-300, 1e300);
  return random.uniform(-1, 1) < 0 ? -size : size;
}

inline void spoil(Spoil how, Random& random, Measurement<double>& y, Reference<double>& ref,
                  const Measurement<double>& before) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const int i = static_cast<int>(random.uniform(0, 3));
  switch (how) {
    case Spoil::nan_rate:
      y.omega_BN_B[i] = nan;
      break;
    case Spoil::infinite_attitude:
      y.q_NB.coeffs()[i] = random.uniform(-1, 1) < 0 ? -inf : inf;
      break;
    case Spoil::nan_momentum:
      y.h_w[i] = nan;
      break;
    case Spoil::nan_reference:
      ref.omega_RN_R[i] = nan;
      break;
    case Spoil::huge_rate:
      y.omega_BN_B[i] = any_size(random);
      break;
    case Spoil::huge_momentum:
      y.h_w[i] = any_size(random);
      break;
    case Spoil::huge_reference:
      ref.omegadot_RN_R[i] = any_size(random);
      break;
    case Spoil::zero_quaternion:
      y.q_NB.coeffs().setZero();
      break;
    case Spoil::unnormalised_quaternion:
      y.q_NB.coeffs() *= random.log_uniform(1e-200, 1e200);
      break;
    case Spoil::tiny_numbers:
      y.omega_BN_B *= 1e-310;
      y.q_NB.vec() *= 1e-310;
      break;
    case Spoil::wrong_state:
      y.q_NB = random.attitude<double>();
      y.omega_BN_B = random.vector<double>(1.0);
      break;
    case Spoil::frozen:
      y = before;
      break;
    case Spoil::tick_jump:
      y.tick += static_cast<Tick>(random.log_uniform(1, 1e18));
      break;
    case Spoil::count:
      break;
  }
}

/// What a stack did under abuse.
struct Outcome {
  long samples = 0, episodes = 0;
  long not_finite = 0;    ///< samples with a non-finite command
  long outside = 0;       ///< samples with a command outside its limits
  long held = 0;          ///< samples with Flag::input_held
  long reset = 0;         ///< samples with Flag::component_reset
  long slowest = 0;       ///< samples from the last spoilt input until normal for good, the worst episode
  long unrecovered = 0;   ///< episodes that did not get there in `patience` samples
  Spoil slowest_after{};  ///< what the slowest episode had been spoilt with
};

/// FTC-4RW at 100 Hz with one component exchanged, started near its target, under a torque whose mean is zero: hours of a
/// constant one would fill the wheels beyond what 0.2 N m can turn. An observer's d_B is taken away, so that what
/// it remembers of the abuse is felt. A law that does not regulate is asked for its flags alone.
inline host::Table loop_with(const std::string& role, const std::string& name) {
  host::Table s = bench::ftc_4rw("rk4");
  s.set("initial", host::Table{{"mrp", bench::row({0.001, -0.002, 0.001})}});
  s.set("duration", 1e6);
  const auto sine = [](double amplitude, double omega) {
    return host::Table{{"type", "sine"}, {"amplitude", amplitude}, {"omega", omega}};
  };
  s.set("disturbances",
        host::List{host::Table{{"type", "periodic"},
                               {"torque_B", host::List{sine(1e-3, 0.02), sine(-2e-3, 0.013), sine(1.5e-3, 0.029)}}}});
  s.set("allow_unstable", true);
  s.set("controller", host::Table{{"type", "mrp_feedback"}, {"compensate", role == "observer"}});
  s.set(role, host::Table{{"type", name}});
  return s;
}

/// Flies the loop for about `samples` samples: calm until normal, then a burst of 1 to 500 spoilt samples, and so on.
/// Normal, for half a second: error below `angle`, and none of input_held, component_reset, command_held.
inline Outcome abuse(const host::Table& scenario, bool regulates, long samples, unsigned seed, double angle = 0.0175,
                     long patience = 60000) {
  const host::Assembly a = host::assemble(scenario);
  truth::Plant plant(a.plant, a.initial, a.setup.dt);
  truth::Sensors sensors(a.sensors, a.run.seed, 0, true);
  host::ReferencePath reference(a.reference, a.setup.dt);
  host::Stack stack = host::make_stack(a, {});
  const Vehicle<double>& vehicle = a.setup.vehicle;
  Random random(seed);
  Outcome out;
  Measurement<double> before;
  Tick k = 0;

  const auto sample = [&](const Spoil* how) {
    Measurement<double> y = sensors.measure(k, plant.q_NB(), plant.omega_BN_B(), plant.h_w());
    Reference<double> ref = reference.at(k);
    const Measurement<double> good = y;
    if (how != nullptr) spoil(*how, random, y, ref, before);
    if (how == nullptr || *how != Spoil::frozen) before = good;
    const Allocation<double>& last = stack.step(y, ref);
    ++out.samples;
    ++k;
    if (!last.u.allFinite()) {
      ++out.not_finite;
      return false;
    }
    for (int i = 0; i < vehicle.actuators(); ++i) {
      if (last.u[i] < vehicle.u_lo[i] || last.u[i] > vehicle.u_up[i]) {
        ++out.outside;
        break;
      }
    }
    out.held += last.status.has(Flag::input_held);
    out.reset += last.status.has(Flag::component_reset);
    plant.advance(last.u);
    const bool clean = !last.status.has(Flag::input_held) && !last.status.has(Flag::component_reset) &&
                       !last.status.has(Flag::command_held);
    const double error = 2 * std::acos(std::min(1.0, std::abs(plant.q_NB().w())));
    return clean && (!regulates || error + 5 * plant.omega_BN_B().norm() < 1.5 * angle);
  };
  constexpr long steady = 50;
  // Until normal for `steady` samples; the first of them counts.
  const auto calm = [&] {
    long normal = 0;
    for (long n = 0; n < patience; ++n) {
      normal = sample(nullptr) ? normal + 1 : 0;
      if (normal == steady) return n + 1 - steady;
    }
    ++out.unrecovered;
    return patience;
  };

  for (int n = 0; n < 500; ++n) sample(nullptr);
  calm();
  out.unrecovered = 0;
  while (out.samples < samples && out.unrecovered == 0 && out.not_finite == 0) {
    const auto how = static_cast<Spoil>(out.episodes % static_cast<long>(Spoil::count));
    const int burst = static_cast<int>(random.log_uniform(1, 501));
    for (int n = 0; n < burst; ++n) sample(&how);
    const long took = calm();
    ++out.episodes;
    if (took > out.slowest) {
      out.slowest = took;
      out.slowest_after = how;
    }
  }
  return out;
}

inline const char* name_of(Spoil how) {
  constexpr std::array names{"NaN rate",
                             "infinite attitude",
                             "NaN wheel momentum",
                             "NaN reference",
                             "huge rate",
                             "huge momentum",
                             "huge reference",
                             "zero quaternion",
                             "unnormalised q",
                             "tiny numbers",
                             "wrong attitude and rate",
                             "frozen measurement",
                             "jump of the tick",
                             "nothing"};
  return names[static_cast<std::size_t>(how)];
}

}  // namespace gyrostat::test
