// SPDX-License-Identifier: MIT
#include "gyrostat/truth/plant.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "gyrostat/core/attitude.hpp"

namespace gyrostat::truth {
namespace {

constexpr double snap = 1e-9;  // s, switches this close are simultaneous

/// Longest piece of a varying law, in radians of its fastest part: a cubic through four Gauss nodes then errs by
/// (0.05)^4 / 1680 = 4e-9 of the amplitude inside, and by order 8 in the integral over the piece.
constexpr double longest_angle = 0.05;
constexpr double shortest_piece = 1e-6;  // s, however fast a law is

constexpr std::uint64_t most_steps = 200'000;  // of a sample

template <auto derivative, class Context>
void call(double t, const double* y, double* ydot, const void* context) noexcept {
  derivative(*static_cast<const Context*>(context), t, y, ydot);
}

/// A right-hand side with its context.
struct Call {
  Rhs rhs;
  const void* context;
  void operator()(double t, const double* y, double* ydot) const noexcept { rhs(t, y, ydot, context); }
};

void normalise(double* q) noexcept {
  const double shrink = 1 / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (std::size_t i = 0; i < 4; ++i) q[i] *= shrink;
}

void refuse_if(bool wrong, const char* why) {
  if (wrong) throw std::invalid_argument(why);
}

std::string text(double x) {
  std::array<char, 32> out{};
  std::snprintf(out.data(), out.size(), "%.3g", x);
  return out.data();
}

void refuse_quick_bearings(const Body& body, double dt) {
  if (body.friction_rate * dt <= InnerRates::most_in_a_sample) return;
  const auto quicker = [](const Body::FrictionWheel& a, const Body::FrictionWheel& b) {
    return a.viscous / a.inertia < b.viscous / b.inertia;
  };
  const auto quickest = std::max_element(body.friction_wheels.begin(), body.friction_wheels.end(), quicker);
  throw std::invalid_argument("plant: viscous_friction = " + text(quickest->viscous) +
                              " N m s stops the wheel of actuator " + std::to_string(quickest->actuator) + " (" +
                              text(quickest->inertia) + " kg m^2) in " + text(1 / body.friction_rate) +
                              " s; nothing quicker than a thousandth of the period, " +
                              text(dt / InnerRates::most_in_a_sample) + " s, can be integrated");
}

}  // namespace

NonFiniteState::NonFiniteState(double time_in)
    : std::runtime_error("the state is no longer finite at t = " + std::to_string(time_in) + " s"), time(time_in) {}

Plant::Plant(PlantModel model, const InitialState& initial, double dt)
    : body_(model.J_B, model.D_B, model.actuators),
      actuators_(std::move(model.actuators), std::move(model.faults)),
      external_(std::move(model.disturbances), body_.J_total_B, model.orbit_rate),
      dt_(dt) {
  refuse_if(!(dt > 0) || !std::isfinite(dt), "plant: dt must be positive and finite");
  const double norm = initial.q_NB.norm();
  refuse_if(!(norm > 0) || !std::isfinite(norm), "plant: the initial quaternion must be finite and not zero");
  refuse_if(!initial.omega_BN_B.allFinite(), "plant: the initial rate must be finite");
  const int n = actuators_.size();
  const Actuators& a = actuators_.actuators();
  stored_ = initial.h_w.size() == 0 ? VecN<double>::Zero(n) : initial.h_w;
  refuse_if(stored_.size() != n || !stored_.allFinite(), "plant: h_w must be finite, with one element an actuator");
  for (int i = 0; i < n; ++i) {
    refuse_if(!a.is_wheel(i) && stored_[i] != 0, "plant: h_w of an ideal torquer must be zero");
    refuse_if(std::abs(stored_[i]) > a.momentum_max[i], "plant: a wheel starts beyond its momentum_max");
    watched_.set(i, a.is_wheel(i) && (std::isfinite(a.momentum_max[i]) || a.coulomb_friction[i] > 0));
  }
  refuse_quick_bearings(body_, dt);
  stored_rest_ = VecN<double>::Zero(n);
  h_w_ = VecN<double>::Zero(n);
  friction_index_.fill(-1);
  for (std::size_t j = 0; j < body_.friction_wheels.size(); ++j) {
    friction_index_[static_cast<std::size_t>(body_.friction_wheels[j].actuator)] = static_cast<int>(j);
  }
  counted_ = friction_index_;

  const Vec3<double> H_B = body_.J_B * initial.omega_BN_B + torque<double>(body_.D_B, stored_);
  if (model.coordinates == Coordinates::euler_angles) {
    refuse_if(!initial.euler.allFinite(), "plant: the initial Euler angles must be finite");
    euler_body_.emplace(body_, model.orbit_rate);
    y_ = {initial.euler[0], initial.euler[1], initial.euler[2], 0, H_B[0], H_B[1], H_B[2]};
  } else {
    const Quat<double> q = initial.q_NB.normalized();
    y_ = {q.w(), q.x(), q.y(), q.z(), H_B[0], H_B[1], H_B[2]};
  }

  exchange_.J_B_inverse = body_.J_B_inverse;
  inverse_inertia_ = body_.J_B_inverse.norm();
  if (const auto* cvode = std::get_if<Cvode>(&model.integrator)) {
    cvode_.emplace(*cvode, body_.states());
    restart_each_sample_ = cvode->restart_each_sample;
    pair_ = {cvode->rtol, cvode->atol};
  } else if (const auto* pair = std::get_if<Auto>(&model.integrator)) {
    pair_ = *pair;
  } else {
    rk4_substeps_ = std::get<Rk4>(model.integrator).substeps;
    refuse_if(rk4_substeps_ < 1, "rk4: substeps must be at least 1");
  }
  publish();
  omega_BN_B_ = initial.omega_BN_B;
  enter_piece();
}

// ---- time -----------------------------------------------------------------------------------------------------------

void Plant::advance(const VecN<double>& u) {
  const Tick next = tick_ + 1;
  advance_to(u, static_cast<double>(next) * dt_);
  tick_ = next;
}

void Plant::advance_to(const VecN<double>& u, double t_end) {
  refuse_if(u.size() != actuators_.size(), "plant: the command must have one element an actuator");
  refuse_if(!(t_end >= t_), "plant: cannot go back in time");
  if (t_ >= piece_end_ - snap) enter_piece();  // before the command: a lock freezes what was delivered until now
  actuators_.command(u);
  commanded_ = true;
  if (restart_each_sample_) restart_ = true;
  steps_before_ = steps();
  while (t_ < t_end) {
    const double stop = piece_end_ < t_end - snap ? piece_end_ : t_end;
    while (t_ < stop) {
      step_towards(stop);
      if (t_ < t_end) limit_work(t_);
    }
    if (t_ < t_end) {
      publish();
      enter_piece();
    }
  }
  publish();
  tick_ = static_cast<Tick>(std::floor((t_ + snap) / dt_));
}

void Plant::limit_work(double t) const {
  if (steps() - steps_before_ > most_steps) {
    throw IntegrationError(t, "a sample takes more than " + std::to_string(most_steps) + " steps");
  }
}

/// Begins the smooth piece that starts now.
void Plant::enter_piece() {
  const double from = t_ + snap;
  piece_end_ = std::min(actuators_.next_switch(from), external_.next_switch(from));
  const double branch = 0.5 * (from + (std::isfinite(piece_end_) ? piece_end_ : from + dt_));
  actuators_.enter(t_, branch);

  const Vec3<double> before_B = external_.torque_B(t_, q_NB_, omega_BN_B_);
  external_.enter(branch);
  const Vec3<double> after_B = external_.torque_B(t_, q_NB_, omega_BN_B_);
  const double rounding = 1e-13 * (before_B.norm() + after_B.norm());
  if ((after_B - before_B).norm() > rounding) restart_ = true;
}

/// One piece of time on which everything is smooth: to `stop` or as far as that goes.
void Plant::step_towards(double stop) {
  double t1 = actuators_.all_constant() ? stop : smooth_end(stop);
  pieces_ = least_steps(t1 - t_);
  if (looks_ahead()) {  // a step at a time
    if (rk4_substeps_ > 0) t1 = t_ + (t1 - t_) / rk4_steps(t1 - t_);
    pieces_ = 1;
  }
  length_ = t1 - t_;
  fit_delivered(t1);
  if (!cvode_ || restart_) absorb_torquer_impulse();
  if (watched_.any()) settle_wheels();
  set_exchange();
  if (watched_.any()) {
    t1 = integrate_watching(t1);
  } else {
    integrate(t1);
  }
  statistics_.pieces += static_cast<std::uint64_t>(pieces_);
  take_up_storage((t1 - t_) / length_);
  t_ = t1;
  if (!std::isfinite(y_[0] + y_[1] + y_[2] + y_[3] + y_[4] + y_[5] + y_[6])) throw NonFiniteState(t_);
}

// ---- actuators over one piece -----------------------------------------------------------------------------------------

double Plant::smooth_end(double stop) const noexcept {
  double t1 = stop;
  if (actuators_.fastest() > 0) {
    const double longest = std::max(longest_angle / actuators_.fastest(), shortest_piece);
    const double pieces = std::ceil((stop - t_) / longest);
    if (pieces > 1) t1 = t_ + (stop - t_) / pieces;
  }
  return actuators_.may_kink() ? first_kink(t1) : t1;
}

/// First time until t1 at which a varying output meets or leaves its limit.
double Plant::first_kink(double t1) const noexcept {
  constexpr int probes = 8;
  const double t0 = t_ + std::min(snap, 0.5 * (t1 - t_));  // t_ itself may be such a time
  for (int i = 0; i < actuators_.size(); ++i) {
    if (actuators_.constant(i)) continue;
    const int side = actuators_.limit_side(i, t0);
    const auto left = [&](double t) { return actuators_.limit_side(i, t) != side; };
    double lo = t0;
    for (int k = 1; k <= probes; ++k) {
      const double hi = k == probes ? t1 : t0 + (t1 - t0) * k / probes;
      if (left(hi)) {
        t1 = bisect(lo, hi, 1e-12, left);
        break;
      }
      lo = hi;
    }
  }
  return t1;
}

void Plant::fit_delivered(double t1) noexcept {
  degree_ = 0;
  for (int i = 0; i < actuators_.size(); ++i) {
    Cubic& c = delivered_[static_cast<std::size_t>(i)];
    if (actuators_.constant(i)) {
      c = {actuators_.constant_delivered(i), 0, 0, 0};
    } else {
      std::array<double, 4> f;
      for (std::size_t j = 0; j < 4; ++j) f[j] = actuators_.delivered(i, t_ + 0.5 * (1 + gauss_node[j]) * (t1 - t_));
      c = cubic_through(f);
      degree_ = 3;
    }
  }
}

/// The momentum that the actuators hold, as polynomials of the present piece.
void Plant::set_exchange() noexcept {
  const double length = length_, per_length = 1 / length;
  const auto powers = static_cast<std::size_t>(degree_ + 2);
  const auto reset = [&](auto& polynomial, const auto& zero) {
    polynomial.t0 = t_;
    polynomial.per_length = per_length;
    polynomial.degree = degree_ + 1;
    for (std::size_t k = 0; k < powers; ++k) polynomial.c[k] = zero;
  };
  const Vec3<double> zero = Vec3<double>::Zero();
  reset(exchange_.stored_B, zero);
  const bool mixed = body_.kind == Body::Kind::mixed;
  if (mixed) reset(exchange_.torquers_B, zero);
  for (int i = 0; i < actuators_.size(); ++i) {
    const Cubic& c = delivered_[static_cast<std::size_t>(i)];
    const std::array<double, 5> held{stored_[i] + stored_rest_[i], -length * c[0], -length * c[1] / 2,
                                     -length * c[2] / 3, -length * c[3] / 4};
    if (const int j = friction_index_[static_cast<std::size_t>(i)]; j >= 0) {
      Exchange::FrictionWheel& wheel = exchange_.friction_wheels[static_cast<std::size_t>(j)];
      wheel.counts = counted_[static_cast<std::size_t>(i)] < 0 ? 0 : 1;
      wheel.viscous = standing_.test(i) ? 0 : actuators_.actuators().viscous_friction[i];
      reset(wheel.momentum, 0.0);
      wheel.momentum.c = held;
    }
    const Vec3<double> g = body_.D_B.col(i);
    const bool torquer = mixed && !actuators_.actuators().is_wheel(i);
    for (std::size_t k = 0; k < powers; ++k) {
      exchange_.stored_B.c[k] += held[k] * g;
      if (torquer) exchange_.torquers_B.c[k] += held[k] * g;
    }
  }
}

/// Puts the impulse of ideal torquers into the body's momentum and begins to count it anew, so that it stays small.
/// Changes the state: only where the integrator has no history.
void Plant::absorb_torquer_impulse() noexcept {
  if (body_.kind == Body::Kind::wheels) return;
  for (int i = 0; i < actuators_.size(); ++i) {
    if (actuators_.actuators().is_wheel(i)) continue;
    const double impulse = stored_[i] + stored_rest_[i];
    for (int axis = 0; axis < 3; ++axis) y_[static_cast<std::size_t>(4 + axis)] -= impulse * body_.D_B(axis, i);
    stored_[i] = stored_rest_[i] = 0;
  }
}

/// Compensated: over many samples a constant torque would else be rounded the same way each time.
/// @param x  how much of the piece was gone through
void Plant::take_up_storage(double x) noexcept {
  for (int i = 0; i < actuators_.size(); ++i) {
    const double change = stored_rest_[i] - length_ * integral(delivered_[static_cast<std::size_t>(i)], x);
    const double sum = stored_[i] + change;
    stored_rest_[i] = change - (sum - stored_[i]);
    stored_[i] = sum;
  }
}

// ---- integration --------------------------------------------------------------------------------------------------------

InnerRates Plant::inner_rates() const noexcept {
  Vec3<double> held{y_[4], y_[5], y_[6]};
  if (body_.kind != Body::Kind::wheels) held = body_.J_B * omega_BN_B_ + torque<double>(body_.D_B, h_w_);
  const double precession2 = held.squaredNorm() * inverse_inertia_ * inverse_inertia_;
  return {std::sqrt(2 * (omega_BN_B_.squaredNorm() + precession2)), body_.friction_rate};
}

/// Steps on this length so that none is longer than rk4 may take them.
/// @throws IntegrationError when they are so many that no method gets through a sample
double Plant::least_steps(double length) const {
  const InnerRates rates = inner_rates();
  const double rate = rates.turning + rates.friction;
  if (!(length * rate > InnerRates::longest_step)) return 1;  // nor a rate that is not finite: that is found later
  if (rate * dt_ > InnerRates::most_in_a_sample) {
    throw IntegrationError(
        t_, "the vehicle turns, precesses or slows down at " + text(rate) + " 1/s, more than 1000 times in a sample,");
  }
  return std::ceil(length * rate / InnerRates::longest_step);
}

/// Of rk4, on the present piece.
double Plant::rk4_steps(double length) const noexcept {
  return std::max(std::ceil(length / dt_ * rk4_substeps_ - 1e-6), pieces_);
}

void Plant::integrate(double t1) {
  const bool friction = !body_.friction_wheels.empty();
  if (euler_body_) {
    const EulerMotion m{*euler_body_, motion()};
    external_.varies() ? integrate_as<Body::rigid_states, euler_derivative<true>, false>(m, t1)
                       : integrate_as<Body::rigid_states, euler_derivative<false>, false>(m, t1);
  } else if (friction) {
    external_.varies() ? integrate_rigid<true, true>(t1) : integrate_rigid<true, false>(t1);
  } else {
    external_.varies() ? integrate_rigid<false, true>(t1) : integrate_rigid<false, false>(t1);
  }
}

template <bool friction, bool varying>
void Plant::integrate_rigid(double t1) {
  constexpr int capacity = friction ? Body::max_states : Body::rigid_states;
  integrate_as<capacity, derivative<friction, varying>, true>(motion(), t1);
}

template <int capacity, auto derivative, bool unit_quaternion, class Context>
void Plant::integrate_as(const Context& m, double t1) {
  if (cvode_) {
    if (restart_) cvode_->restart(t_, y_.data());
    restart_ = false;
    cvode_->advance(&call<derivative, Context>, &m, t1, y_.data());
    return;
  }
  const auto rhs = [&m](double t, const double* y, double* ydot) noexcept { derivative(m, t, y, ydot); };
  if (rk4_substeps_ == 0) {
    for (double t = t_; t < t1;) {
      t = pair_towards<capacity>(rhs, t, t1, y_);
      if constexpr (unit_quaternion) normalise(y_.data());
      ++statistics_.steps;
      limit_work(t);
    }
    return;
  }
  const double steps = rk4_steps(t1 - t_);
  const double h = (t1 - t_) / steps;
  for (double k = 0; k < steps; ++k) {
    rk4_step<capacity>(rhs, t_ + k * h, h, y_.data(), body_.states());
    if constexpr (unit_quaternion) normalise(y_.data());
  }
  statistics_.steps += static_cast<std::uint64_t>(steps);
  statistics_.rhs_evaluations += 4 * static_cast<std::uint64_t>(steps);
}

/// One step of the pair from y at t, to t1 or as far as its tolerance allows. Returns the time reached.
template <int capacity, class F>
double Plant::pair_towards(const F& rhs, double t, double t1, State& y) {
  const State begin = y;
  for (;;) {
    const bool whole = t1 - t <= pair_length_;
    const double h = whole ? t1 - t : pair_length_;
    if (!(t + h > t)) throw IntegrationError(t, "auto: the steps shrink to nothing");
    const double error = pair_step<capacity>(pair_, rhs, t, h, body_.states(), begin.data(), y.data());
    statistics_.rhs_evaluations += DormandPrince::stages;
    const double next = error < 1e-4 ? 5 * h : h * std::clamp(0.9 * std::pow(error, -0.2), 0.2, 5.0);
    if (error > 1) {
      pair_length_ = next;
      continue;
    }
    pair_length_ = whole ? std::max(pair_length_, next) : next;
    return whole ? t1 : t + h;
  }
}

/// One step of a method without history from the beginning of the piece, to t1 or as far as its tolerance allows.
double Plant::look_ahead(double t1, State& y) {
  if (rk4_substeps_ > 0) {
    single_step(t1, y);
    return t1;
  }
  const Motion m = motion();
  y = y_;
  const double reached = pair_towards<Body::max_states>(Call{rhs_of_wheels(), &m}, t_, t1, y);
  normalise(y.data());
  return reached;
}

/// The same to t1, without regard to its error.
void Plant::single_step(double t1, State& y) {
  const Motion m = motion();
  const Call rhs{rhs_of_wheels(), &m};
  const int n = body_.states();
  if (rk4_substeps_ > 0) {
    y = y_;
    rk4_step<Body::max_states>(rhs, t_, t1 - t_, y.data(), n);
    statistics_.rhs_evaluations += 4;
  } else {
    pair_step<Body::max_states>(pair_, rhs, t_, t1 - t_, n, y_.data(), y.data());
    statistics_.rhs_evaluations += DormandPrince::stages;
  }
  normalise(y.data());
}

/// Of a body with friction wheels.
Rhs Plant::rhs_of_wheels() const noexcept {
  return external_.varies() ? &call<derivative<true, true>, Motion> : &call<derivative<true, false>, Motion>;
}

IntegratorStatistics Plant::statistics() const {
  IntegratorStatistics s = statistics_;
  if (cvode_) {
    const IntegratorStatistics c = cvode_->statistics();
    s.steps += c.steps;
    s.rhs_evaluations += c.rhs_evaluations;
    s.restarts = c.restarts;
  }
  return s;
}

// ---- what others see ------------------------------------------------------------------------------------------------------

void Plant::publish() {
  q_NB_ = euler_body_ ? quat_from_euler<double>({y_[0], y_[1], y_[2]})
                      : Quat<double>(y_[0], y_[1], y_[2], y_[3]).normalized();
  Vec3<double> Jw{y_[4], y_[5], y_[6]};
  for (int i = 0; i < actuators_.size(); ++i) {
    const double h = momentum(i);
    Jw -= h * body_.D_B.col(i);
    if (actuators_.actuators().is_wheel(i)) h_w_[i] = h;
  }
  omega_BN_B_ = exchange_.J_B_inverse * Jw;
  if (!standing_.any()) return;
  for (int i = 0; i < actuators_.size(); ++i) {
    if (standing_.test(i)) h_w_[i] = turned_momentum(i, omega_BN_B_);
  }
}

EulerState<double> Plant::euler() const noexcept {
  if (euler_body_) return {{y_[0], y_[1], y_[2]}, omega_BN_B_};
  const Vec3<double> angles = gyrostat::euler(q_NB_);
  return {angles, euler_rates(angles, omega_BN_B_)};
}

TruthSample Plant::sample() const {
  const int n = actuators_.size();
  TruthSample s;
  s.t = t_;
  s.q_NB = q_NB_;
  s.omega_BN_B = omega_BN_B_;
  s.h_w = h_w_;
  s.delivered = s.bias = VecN<double>::Zero(n);
  s.effectiveness = VecN<double>::Ones(n);
  for (int i = 0; i < n && commanded_; ++i) {
    const Effect e = actuators_.effect(i, t_);
    s.effectiveness[i] = e.effectiveness;
    s.bias[i] = e.bias;
    s.delivered[i] = turning(i) ? actuators_.delivered(i, t_) + friction(i, speed(i, h_w_[i], omega_BN_B_)) : 0.0;
  }
  s.external_B = external_.torque_B(t_, q_NB_, omega_BN_B_);
  if (euler_body_) {
    const Vec3<double> moment = torque<double>(body_.D_B, s.delivered) + s.external_B;
    s.omegadot_BN_B = euler_body_->acceleration(euler().angles, omega_BN_B_) + body_.J_B_inverse * moment;
    return s;
  }
  const Vec3<double> rotating = body_.J_B * omega_BN_B_ + torque<double>(body_.D_B, h_w_);
  const Vec3<double> moment = torque<double>(body_.D_B, s.delivered) + s.external_B - omega_BN_B_.cross(rotating);
  s.omegadot_BN_B = exchange_.J_B_inverse * moment;
  for (int i = 0; i < n && commanded_; ++i) {
    if (standing_.test(i)) s.delivered[i] = -turned_momentum(i, s.omegadot_BN_B);
  }
  return s;
}

}  // namespace gyrostat::truth
