// SPDX-License-Identifier: MIT
// Compiled, never run: the state, the signatures and the signals that the methods of five papers read and write, without
// their laws. It shows that the contract in core/signals.hpp carries them all, heap-free and noexcept.
#include <array>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/stack.hpp"
#include "stacks.hpp"

namespace gyrostat::test {
namespace {

/// Delay line of a fixed length up to its capacity; what a learning interval of several samples needs.
template <class T, int capacity = 64>
class Delay {
 public:
  Delay(int length, const T& fill) noexcept : length_(length) { values_.fill(fill); }
  /// Stores x and returns what was stored `length` samples ago.
  T exchange(const T& x) noexcept {
    const T old = values_[static_cast<std::size_t>(at_)];
    values_[static_cast<std::size_t>(at_)] = x;
    at_ = (at_ + 1) % length_;
    return old;
  }

 private:
  std::array<T, capacity> values_;
  int length_, at_ = 0;
};

/// Every dry component is made of a setup; parameters are of no interest here.
template <class S>
struct Dry {
  using Scalar = S;
  explicit Dry(const Setup<S>& s) noexcept : dt(s.dt) {}
  S dt;
};

// ---- li2018: rate and issued command in, d_B out; s needs the first sample and the demand that was held --------------------
template <class S>
struct Li2018Observer : Dry<S> {
  using Dry<S>::Dry;
  Vec3<S> omega, omega_hat, eta;
  Estimate<S> start(const Vehicle<S>&, const Measurement<S>& y) noexcept {
    omega = omega_hat = y.omega_BN_B;
    eta.setZero();
    return Estimate<S>::healthy(y);
  }
  Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last) noexcept {
    omega_hat += this->dt * (torque<S>(vehicle.D_B, last.u) + eta);
    omega = y.omega_BN_B;
    Estimate<S> x = Estimate<S>::healthy(y);
    x.d_B = omega - omega_hat;
    return x;
  }
};
template <class S>
struct Li2018Controller : Dry<S> {
  using Dry<S>::Dry;
  Vec3<S> omega_0, momentum, u_nominal, gain;
  Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>& det,
                  const Reference<S>& ref) noexcept {
    omega_0 = x.omega_BN_B;
    momentum.setZero();
    return step(vehicle, x, det, ref, Allocation<S>::idle(vehicle.actuators()));
  }
  Demand<S> step(const Vehicle<S>&, const Estimate<S>& x, const Detection<S>&, const Reference<S>& ref,
                 const Allocation<S>&) noexcept {
    momentum += this->dt * u_nominal;
    u_nominal = -attitude_error(x.q_NB, x.omega_BN_B, ref.q_NR, ref.omega_RN_R).omega_BR_B;
    Demand<S> demand;
    demand.tau_B = u_nominal - x.d_B - (x.omega_BN_B - omega_0 - momentum);
    return demand;
  }
};

// ---- cao2022: effectiveness learnt from the rate and the command of the interval just ended; MRP law with sigma_d'' -------
template <class S>
struct Cao2022Observer : Dry<S> {
  explicit Cao2022Observer(const Setup<S>& s) noexcept
      : Dry<S>(s),
        effectiveness(VecN<S>::Ones(s.vehicle.actuators())),
        old_effectiveness(1, effectiveness),
        old_error(1, Vec3<S>(Vec3<S>::Zero())) {}
  Vec3<S> omega_hat, injection;
  VecN<S> effectiveness;
  Delay<VecN<S>> old_effectiveness;
  Delay<Vec3<S>> old_error;
  Estimate<S> start(const Vehicle<S>&, const Measurement<S>& y) noexcept {
    omega_hat = y.omega_BN_B;
    return estimate(y);
  }
  Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last) noexcept {
    // The prediction over [k-1, k] uses u, the estimate and the injection of k-1: all are at hand at k.
    omega_hat += this->dt * (torque<S>(vehicle.D_B, effectiveness.cwiseProduct(last.u)) + injection);
    const Vec3<S> error = y.omega_BN_B - omega_hat;
    const VecN<S> learnt = project<S>(vehicle.D_B, Vec3<S>(error + old_error.exchange(error)));
    effectiveness = old_effectiveness.exchange(effectiveness) + last.u.cwiseProduct(learnt);
    injection = sgn(error);
    return estimate(y);
  }
  Estimate<S> estimate(const Measurement<S>& y) const noexcept {
    Estimate<S> x = Estimate<S>::healthy(y);
    x.effectiveness = effectiveness;  // the allocator divides by it, the controller does not
    return x;
  }
};
template <class S>
struct Cao2022Controller : Dry<S> {
  using Dry<S>::Dry;
  Demand<S> start(const Vehicle<S>&, const Estimate<S>& x, const Detection<S>&, const Reference<S>& ref) noexcept {
    return demand(x, ref);
  }
  Demand<S> step(const Vehicle<S>&, const Estimate<S>& x, const Detection<S>&, const Reference<S>& ref,
                 const Allocation<S>&) noexcept {
    return demand(x, ref);
  }
  Demand<S> demand(const Estimate<S>& x, const Reference<S>& ref) const noexcept {
    // sigma, sigma' and sigma'' of the reference follow from q_NR, omega_RN_R, omegadot_RN_R; the sign of q is kept.
    const Mat3<S> G = mrp_rate_matrix(mrp(x.q_NB)), G_R = mrp_rate_matrix(mrp(ref.q_NR));
    const Vec3<S> z2 = G * x.omega_BN_B - G_R * ref.omega_RN_R;
    Demand<S> out;
    out.tau_B = -z2 - G_R * ref.omegadot_RN_R;
    return out;
  }
};

// ---- wang2023: additive torque learnt with a delay; a second learning law in the controller ----------------------------------
template <class S>
struct Wang2023Observer : Dry<S> {
  explicit Wang2023Observer(const Setup<S>& s) noexcept
      : Dry<S>(s), old_torque(1, Vec3<S>(Vec3<S>::Zero())), old_error(1, Vec3<S>(Vec3<S>::Zero())) {}
  Vec3<S> omega_hat = Vec3<S>::Zero(), u_f = Vec3<S>::Zero(), error = Vec3<S>::Zero();
  Delay<Vec3<S>> old_torque, old_error;
  Estimate<S> start(const Vehicle<S>&, const Measurement<S>& y) noexcept {
    return learn(y);
  }  // cold start: the rate estimate is zero
  Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last) noexcept {
    omega_hat += this->dt * (torque<S>(vehicle.D_B, last.u) + u_f + error + sgn(error));
    return learn(y);
  }
  Estimate<S> learn(const Measurement<S>& y) noexcept {
    error = y.omega_BN_B - omega_hat;
    u_f = old_torque.exchange(u_f) + old_error.exchange(error) + error;
    Estimate<S> x = Estimate<S>::healthy(y);
    x.d_B = u_f;
    return x;
  }
};
template <class S>
struct Wang2023Controller : Dry<S> {
  explicit Wang2023Controller(const Setup<S>& s) noexcept
      : Dry<S>(s), old_torque(1, Vec3<S>(Vec3<S>::Zero())), old_surface(1, Vec3<S>(Vec3<S>::Zero())) {}
  Vec3<S> u_d = Vec3<S>::Zero();
  Delay<Vec3<S>> old_torque, old_surface;
  Demand<S> start(const Vehicle<S>&, const Estimate<S>& x, const Detection<S>&, const Reference<S>& ref) noexcept {
    return learn(x, ref);
  }
  Demand<S> step(const Vehicle<S>&, const Estimate<S>& x, const Detection<S>&, const Reference<S>& ref,
                 const Allocation<S>&) noexcept {
    return learn(x, ref);
  }
  Demand<S> learn(const Estimate<S>& x, const Reference<S>& ref) noexcept {
    const AttitudeError<S> error = attitude_error(x.q_NB, x.omega_BN_B, ref.q_NR, ref.omega_RN_R);
    const Vec3<S> surface = error.omega_BR_B + error.q_RB.vec();  // sign as measured: a long way round stays one
    u_d = old_torque.exchange(u_d) + old_surface.exchange(surface) + surface;
    Demand<S> demand;
    demand.tau_B = -surface - u_d - x.d_B;
    return demand;
  }
};

// ---- cao2023: Euler angles and rates, an orbit, a time since start in ticks --------------------------------------------------
template <class S>
struct Cao2023Observer : Dry<S> {
  explicit Cao2023Observer(const Setup<S>& s) noexcept
      : Dry<S>(s), old_f(10, Vec3<S>(Vec3<S>::Zero())), old_error(10, Vec3<S>(Vec3<S>::Zero())) {}
  Vec3<S> rates, error = Vec3<S>::Zero(), f = Vec3<S>::Zero();
  Delay<Vec3<S>> old_f, old_error;
  Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    rates = y.euler.rates;
    return learn(vehicle, y);
  }
  Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last) noexcept {
    const Vec3<S> unexplained =
        (y.euler.rates - rates) / this->dt - vehicle.orbit_rate * y.euler.angles - torque<S>(vehicle.D_B, last.u);
    error += this->dt * (unexplained - f);
    rates = y.euler.rates;
    return learn(vehicle, y);
  }
  Estimate<S> learn(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    f = old_f.exchange(f) + old_error.exchange(error) + error;
    Estimate<S> x = Estimate<S>::healthy(y);
    x.d_B = vehicle.J_B * f;  // N m, with D := J B
    return x;
  }
};
template <class S>
struct Cao2023Controller : Dry<S> {
  using Dry<S>::Dry;
  Tick first = 0;
  Vec3<S> d0, d1, d2;  // error, its rate and acceleration at the start
  Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>& det,
                  const Reference<S>& ref) noexcept {
    first = x.tick;
    d0 = x.euler.angles - ref.euler.angles;
    d1 = x.euler.rates - ref.euler.rates;
    d2 = -ref.euler_accelerations;
    return step(vehicle, x, det, ref, {});
  }
  Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&, const Reference<S>& ref,
                 const Allocation<S>&) noexcept {
    const S t = static_cast<S>(x.tick - first) * this->dt;
    const Vec3<S> p = d0 + t * d1 + t * t * d2;
    Demand<S> demand;
    demand.tau_B = -(vehicle.J_B * (x.euler.angles - ref.euler.angles - p - ref.euler_accelerations)) - x.d_B;
    return demand;
  }
};

// ---- yang2023: effectiveness with a confidence, a detector that enables the spare, an envelope armed by events ----------------
template <class S>
struct Yang2023Observer : Cao2022Observer<S> {
  using Cao2022Observer<S>::Cao2022Observer;
  Vec3<S> k1, k4;
  S k2 = S(0);
  Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last) noexcept {
    // A spare that is off has u = 0 and is gated by that: no detection is needed here.
    Estimate<S> x = Cao2022Observer<S>::step(vehicle, y, last);
    for (int i = 0; i < last.u.size(); ++i) {
      if (std::abs(last.u[i]) > S(0.05)) x.effectiveness_bound[i] = S(0.1);
    }
    return x;
  }
};
template <class S>
struct Yang2023Detector : Dry<S> {
  explicit Yang2023Detector(const Setup<S>& s) noexcept
      : Dry<S>(s), det(Detection<S>::none(s.vehicle)), reference(VecN<S>::Ones(s.vehicle.actuators())) {}
  Detection<S> det;
  VecN<S> reference;
  std::array<int, max_actuators> samples{};  // how long each has been off its reference
  Detection<S> start(const Vehicle<S>&, const Estimate<S>&) noexcept { return det; }
  Detection<S> step(const Vehicle<S>&, const Estimate<S>& x, const Allocation<S>& last) noexcept {
    for (int i = 0; i < reference.size(); ++i) {
      const bool off = std::abs(last.u[i]) > S(0.05) && std::abs(x.effectiveness[i] - reference[i]) > S(0.2);
      int& count = samples[static_cast<std::size_t>(i)];
      count = off ? count + 1 : 0;
      if (count < 20) continue;
      det.changed.set(i);
      det.enabled = Mask::all(static_cast<int>(reference.size()));
      ++det.event;
      reference[i] = x.effectiveness[i];
    }
    return det;
  }
};
template <class S>
struct Yang2023Controller : Dry<S> {
  using Dry<S>::Dry;
  std::uint32_t fault_event = 0, reference_event = 0;
  Tick armed = 0;
  S sign = S(1);
  Vec3<S> funnel;
  Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                  const Reference<S>& ref) noexcept {
    arm(vehicle, x, ref);
    return demand(x, ref);
  }
  Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>& det, const Reference<S>& ref,
                 const Allocation<S>&) noexcept {
    if (det.event != fault_event || ref.event != reference_event) arm(vehicle, x, ref);
    fault_event = det.event;
    reference_event = ref.event;
    return demand(x, ref);
  }
  void arm(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) noexcept {
    armed = x.tick;
    const Quat<S> q = ref.q_NR.conjugate() * x.q_NB;
    sign = q.w() < S(0) ? S(-1) : S(1);
    const S weakest = vehicle.u_up.minCoeff() * x.effectiveness.minCoeff();
    funnel = q.vec().cwiseAbs() + euler(q) / weakest;
  }
  Demand<S> demand(const Estimate<S>& x, const Reference<S>& ref) const noexcept {
    const AttitudeError<S> error = attitude_error(x.q_NB, x.omega_BN_B, ref.q_NR, ref.omega_RN_R);
    const Vec3<S> inside = (sign * error.q_RB.vec()).cwiseQuotient(funnel);
    Demand<S> out;
    out.tau_B = -inside - error.omega_BR_B - error.q_RB.conjugate() * ref.omegadot_RN_R;
    if (inside.cwiseAbs().maxCoeff() >= S(1)) out.status.set(Flag::breach);
    return out;
  }
};
template <class S>
struct Yang2023Allocator : Dry<S> {
  using Dry<S>::Dry;
  void reset(const Vehicle<S>&) noexcept {}
  Allocation<S> step(const Vehicle<S>& vehicle, const Demand<S>& demand, const Estimate<S>& x,
                     const Detection<S>& det) noexcept {
    Allocation<S> out = Allocation<S>::idle(vehicle.actuators());
    for (int i = 0; i < out.u.size(); ++i) {
      if (det.enabled.test(i)) out.u[i] = vehicle.D_B.col(i).dot(demand.tau_B) * x.effectiveness[i];
    }
    out.worst_case = x.effectiveness_bound.minCoeff();
    out.gap = S(0);
    out.iterations = 1;
    return out;
  }
};

template <class S, template <class> class O, template <class> class D, template <class> class C,
          template <class> class A>
constexpr bool carries() {
  return FlightStack<O<S>, D<S>, C<S>, A<S>>::cannot_throw;
}
template <class S>
constexpr bool carries_all() {
  return carries<S, Li2018Observer, NoDetector, Li2018Controller, PseudoInverse>() &&
         carries<S, Cao2022Observer, NoDetector, Cao2022Controller, PseudoInverse>() &&
         carries<S, Wang2023Observer, NoDetector, Wang2023Controller, PseudoInverse>() &&
         carries<S, Cao2023Observer, NoDetector, Cao2023Controller, PseudoInverse>() &&
         carries<S, Yang2023Observer, Yang2023Detector, Yang2023Controller, Yang2023Allocator>() &&
         // and across papers
         carries<S, Yang2023Observer, Yang2023Detector, Li2018Controller, PseudoInverse>() &&
         carries<S, Li2018Observer, NoDetector, Yang2023Controller, Yang2023Allocator>();
}
static_assert(carries_all<float>() && carries_all<double>());

/// Instantiates the bodies too.
[[maybe_unused]] void step_all(const Setup<double>& s, const Measurement<double>& y, const Reference<double>& ref) {
  const auto step = [&](auto stack) { stack.step(y, ref); };
  const auto none = by_default<NoDetector<double>>(s);
  const auto pinv = by_default<PseudoInverse<double>>(s);
  step(FlightStack(unchecked, s, Li2018Observer<double>(s), none, Li2018Controller<double>(s), pinv));
  step(FlightStack(unchecked, s, Cao2022Observer<double>(s), none, Cao2022Controller<double>(s), pinv));
  step(FlightStack(unchecked, s, Wang2023Observer<double>(s), none, Wang2023Controller<double>(s), pinv));
  step(FlightStack(unchecked, s, Cao2023Observer<double>(s), none, Cao2023Controller<double>(s), pinv));
  step(FlightStack(unchecked, s, Yang2023Observer<double>(s), Yang2023Detector<double>(s),
                   Yang2023Controller<double>(s), Yang2023Allocator<double>(s)));
}

}  // namespace
}  // namespace gyrostat::test
