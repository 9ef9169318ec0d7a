// SPDX-License-Identifier: MIT
/// @file  A closed loop whose inputs are spoilt now and then: what came out, and how long until it flew normally again.
#pragma once
#include <algorithm>
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
  no_momentum,
  nan_reference,
  huge_rate,
  huge_momentum,
  huge_reference,
  zero_quaternion,
  unnormalised_quaternion,
  tiny_numbers,
  wrong_state,
  frozen,
  not_renewed,
  dropout,
  tick_jump,
  count
};

/// A finite number of any size and sign.
inline double any_size(Random& random) {
  const double size = random.log_uniform(1e-300, 1e300);
  return random.uniform(-1, 1) < 0 ? -size : size;
}

/// @param before  the last sample that was not spoilt
inline void spoil(Spoil how, Random& random, Measurement<double>& y, Reference<double>& ref,
                  const Measurement<double>& before) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const int i = static_cast<int>(random.uniform(0, 3));
  const Eigen::Index wheel = i % std::max<Eigen::Index>(y.h_w.size(), 1);
  const Tick tick = y.tick;
  switch (how) {
    case Spoil::nan_rate:
      y.omega_BN_B[i] = nan;
      break;
    case Spoil::infinite_attitude:
      y.q_NB.coeffs()[i] = random.uniform(-1, 1) < 0 ? -inf : inf;
      break;
    case Spoil::nan_momentum:
      y.h_w[wheel] = nan;
      break;
    case Spoil::no_momentum:
      y.h_w.resize(static_cast<Eigen::Index>(random.uniform(0, max_actuators)));
      break;
    case Spoil::nan_reference:
      ref.omega_RN_R[i] = nan;
      break;
    case Spoil::huge_rate:
      y.omega_BN_B[i] = any_size(random);
      break;
    case Spoil::huge_momentum:
      y.h_w[wheel] = any_size(random);
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
      y.tick = tick;
      break;
    case Spoil::not_renewed:
      y = before;
      break;
    case Spoil::dropout:
      y = before;
      y.tick = tick;
      y.attitude_valid = i == 0;
      y.rate_valid = i == 1;
      y.momentum_valid = i == 2;
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
  long not_finite =
      0;             ///< samples with a non-finite command, or one that threw the vehicle out of all that can be flown
  long outside = 0;  ///< samples with a command outside its limits
  long held = 0;     ///< samples with Flag::input_held
  long reset = 0;    ///< samples with Flag::component_reset
  long slowest = 0;  ///< samples from the last spoilt input until normal for good, the worst episode
  long slew = 0;     ///< samples that a stack takes which is started where that episode left the vehicle
  long unrecovered = 0;   ///< episodes that did not get there in `patience` samples
  Spoil slowest_after{};  ///< what the slowest episode had been spoilt with
};

/// A stack in closed loop, from a state of the vehicle on.
class AbusedLoop {
 public:
  /// @param regulates  whether the pointing error is asked for
  AbusedLoop(const host::Assembly& a, const truth::InitialState& initial, bool regulates)
      : vehicle_(a.setup.vehicle),
        regulates_(regulates),
        plant_(a.plant, initial, a.setup.dt),
        sensors_(a.sensors, a.run.seed, 0, true, a.setup.dt),
        reference_(a.reference, a.setup.dt),
        stack_(host::make_stack(a, {})) {}

  /// One sample, spoilt or not. Whether it was normal: no flag of the guard, and the vehicle points, and will for five seconds
  /// at the rate that it has.
  bool sample(const Spoil* how, Random& random, Outcome& out) {
    Measurement<double> y = sensors_.measure(k_, plant_.q_NB(), plant_.omega_BN_B(), plant_.h_w());
    Reference<double> ref = reference_.at(k_);
    const Measurement<double> good = y;
    if (how != nullptr) spoil(*how, random, y, ref, before_);
    if (how == nullptr) before_ = good;
    const Allocation<double>& last = stack_.step(y, ref);
    ++out.samples;
    ++k_;
    if (!last.u.allFinite()) {
      ++out.not_finite;
      return false;
    }
    for (int i = 0; i < vehicle_.actuators(); ++i) {
      if (last.u[i] < vehicle_.u_lo[i] || last.u[i] > vehicle_.u_up[i]) {
        ++out.outside;
        break;
      }
    }
    out.held += last.status.has(Flag::input_held);
    out.reset += last.status.has(Flag::component_reset);
    try {
      plant_.advance(last.u);
    } catch (const truth::NonFiniteState&) {
      ++out.not_finite;
      return false;
    } catch (const truth::IntegrationError&) {
      ++out.not_finite;
      return false;
    }
    const bool clean = !last.status.has(Flag::input_held) && !last.status.has(Flag::component_reset) &&
                       !last.status.has(Flag::command_held);
    const double error = 2 * std::acos(std::min(1.0, std::abs(plant_.q_NB().w())));
    return clean && (!regulates_ || error + 5 * plant_.omega_BN_B().norm() < 0.0262);  // 1.5 deg
  }

  /// Samples until it is normal for half a second; the first of them counts. `patience` when it does not get there.
  long calm(Random& random, Outcome& out, long patience) {
    constexpr long steady = 50;
    long normal = 0;
    for (long n = 0; n < patience && out.not_finite == 0; ++n) {
      normal = sample(nullptr, random, out) ? normal + 1 : 0;
      if (normal == steady) return n + 1 - steady;
    }
    return patience;
  }

  truth::InitialState state(truth::InitialState like) const {
    like.q_NB = plant_.q_NB();
    like.omega_BN_B = plant_.omega_BN_B();
    like.h_w = plant_.h_w();
    return like;
  }

 private:
  const Vehicle<double>& vehicle_;
  bool regulates_;
  truth::RigidPlant plant_;
  truth::Sensors sensors_;
  host::ReferencePath reference_;
  host::Stack stack_;
  Measurement<double> before_;
  Tick k_ = 1;  ///< 0 would be a caller that does not count
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

/// What flight knows of the limits, and how many actuators there are.
enum class Limits { finite, infinite, one_sided, zero, mixed, count };
inline constexpr std::array actuator_counts{3, 4, 16};
inline constexpr int vehicles = static_cast<int>(Limits::count) * static_cast<int>(actuator_counts.size());

/// One of the `vehicles`: torquers about axes all round, without the torque that only wheels of some size can take.
inline host::Table loop_on(int which, const std::string& role, const std::string& name) {
  const auto limits = static_cast<Limits>(which % static_cast<int>(Limits::count));
  const int n = actuator_counts[static_cast<std::size_t>(which) / static_cast<std::size_t>(Limits::count)];
  host::List x, y, z, lo, up;
  for (int i = 0; i < n; ++i) {
    // Three: the axes. More: a spiral over the sphere, whose opposite sides pull against each other.
    const double c = 1 - (2 * i + 1.0) / n, s = std::sqrt(1 - c * c), phi = 2.4 * i;
    x.push_back(n <= 3 ? double(i == 0) : s * std::cos(phi));
    y.push_back(n <= 3 ? double(i == 1) : s * std::sin(phi));
    z.push_back(n <= 3 ? double(i == 2) : c);
    const double infinite = std::numeric_limits<double>::infinity();
    const bool odd = i % 2 == 1;
    double most = limits == Limits::zero ? 0 : 0.2;
    if (limits == Limits::infinite || (limits == Limits::mixed && odd)) most = infinite;
    up.push_back(most);
    lo.push_back(limits == Limits::one_sided ? 0.0 : -most);
  }
  host::Table s = loop_with(role, name);
  s.set("vehicle",
        host::Table{{"J_B", host::List{bench::row({20, 0, 0.9}), bench::row({0, 17, 0}), bench::row({0.9, 0, 15})}},
                    {"D_B", host::List{x, y, z}},
                    {"u_max", up},
                    {"u_min", lo}});
  return s;
}

/// Whether a stack can point it.
inline bool can_point(int which) {
  const auto limits = static_cast<Limits>(which % static_cast<int>(Limits::count));
  return limits != Limits::zero && limits != Limits::one_sided;
}

/// Flies the loop for about `samples` samples: calm until normal, then a burst of 1 to 500 spoilt samples, and so on.
inline Outcome abuse(const host::Table& scenario, bool regulates, long samples, unsigned seed, long patience = 60000) {
  const host::Assembly a = host::assemble(scenario);
  Random random(seed);
  Outcome out;
  AbusedLoop loop(a, a.initial, regulates);
  for (int n = 0; n < 500; ++n) loop.sample(nullptr, random, out);
  loop.calm(random, out, patience);
  while (out.samples < samples && out.unrecovered == 0 && out.not_finite == 0) {
    const auto how = static_cast<Spoil>(out.episodes % static_cast<long>(Spoil::count));
    const int burst = static_cast<int>(random.log_uniform(1, 501));
    for (int n = 0; n < burst && out.not_finite == 0; ++n) loop.sample(&how, random, out);
    if (out.not_finite > 0) {
      out.slowest_after = how;
      break;
    }
    const truth::InitialState left = loop.state(a.initial);
    const long took = loop.calm(random, out, patience);
    ++out.episodes;
    out.unrecovered += took == patience;
    if (took > out.slowest) {
      out.slowest = took;
      out.slowest_after = how;
      Outcome aside;
      out.slew = AbusedLoop(a, left, regulates).calm(random, aside, patience);
    }
  }
  return out;
}

inline const char* name_of(Spoil how) {
  constexpr std::array names{"NaN rate",
                             "infinite attitude",
                             "NaN wheel momentum",
                             "wrong number of wheels",
                             "NaN reference",
                             "huge rate",
                             "huge momentum",
                             "huge reference",
                             "zero quaternion",
                             "unnormalised q",
                             "tiny numbers",
                             "wrong attitude and rate",
                             "frozen measurement",
                             "measurement not renewed",
                             "dropout",
                             "jump of the tick",
                             "nothing"};
  return names[static_cast<std::size_t>(how)];
}

}  // namespace gyrostat::test
