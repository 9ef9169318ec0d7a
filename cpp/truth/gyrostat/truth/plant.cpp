// SPDX-License-Identifier: MIT
#include "gyrostat/truth/plant.hpp"

#include <algorithm>
#include <cmath>

#include "gyrostat/core/attitude.hpp"

namespace gyrostat::truth {
namespace {

constexpr double snap = 1e-9;  // s, switches this close are simultaneous

/// Longest piece of a varying law, in radians of its fastest part: a cubic through four Gauss nodes then errs by
/// (0.05)^4 / 1680 = 4e-9 of the amplitude inside, and by order 8 in the integral over the piece.
constexpr double longest_angle = 0.05;
constexpr double shortest_piece = 1e-6;  // s, however fast a law is

/// Gauss-Legendre nodes and weights on [-1, 1].
constexpr std::array<double, 4> gauss_node{-0.861136311594052575, -0.339981043584856265, 0.339981043584856265,
                                           0.861136311594052575};
constexpr std::array<double, 4> gauss_weight{0.347854845137453857, 0.652145154862546143, 0.652145154862546143,
                                             0.347854845137453857};

/// Powers of x in [0, 1] of the cubic through f at the Gauss nodes.
std::array<double, 4> cubic_through(const std::array<double, 4>& f) noexcept {
  std::array<double, 4> a{};  // coefficients of the shifted Legendre polynomials
  for (std::size_t j = 0; j < 4; ++j) {
    const double z = gauss_node[j], wf = 0.5 * gauss_weight[j] * f[j];
    a[0] += wf;
    a[1] += 3 * wf * z;
    a[2] += 5 * wf * (1.5 * z * z - 0.5);
    a[3] += 7 * wf * (2.5 * z * z - 1.5) * z;
  }
  return {a[0] - a[1] + a[2] - a[3], 2 * a[1] - 6 * a[2] + 12 * a[3], 6 * a[2] - 30 * a[3], 20 * a[3]};
}

double value(const std::array<double, 4>& c, double x) noexcept { return c[0] + x * (c[1] + x * (c[2] + x * c[3])); }
/// Integral from 0 to x.
double integral(const std::array<double, 4>& c, double x) noexcept {
  return x * (c[0] + x * (c[1] / 2 + x * (c[2] / 3 + x * c[3] / 4)));
}

/// Where `beyond` turns from false at lo to true at hi, from above.
template <class Predicate>
double bisect(double lo, double hi, double tolerance, const Predicate& beyond) noexcept {
  while (hi - lo > tolerance) {
    const double mid = 0.5 * (lo + hi);
    if (mid <= lo || mid >= hi) break;
    (beyond(mid) ? hi : lo) = mid;
  }
  return hi;
}

void refuse_if(bool wrong, const char* why) {
  if (wrong) throw std::invalid_argument(why);
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
    momentum_limited_ = momentum_limited_ || std::isfinite(a.momentum_max[i]);
  }
  stored_rest_ = VecN<double>::Zero(n);
  h_w_ = VecN<double>::Zero(n);
  friction_index_.fill(-1);
  for (std::size_t j = 0; j < body_.friction_wheels.size(); ++j) {
    friction_index_[static_cast<std::size_t>(body_.friction_wheels[j].actuator)] = static_cast<int>(j);
  }

  const Vec3<double> H_B = body_.J_B * initial.omega_BN_B + torque<double>(body_.D_B, stored_);
  if (model.coordinates == Coordinates::euler_angles) {
    refuse_if(!initial.euler.allFinite(), "plant: the initial Euler angles must be finite");
    euler_body_.emplace(body_, model.orbit_rate);
    y_ = {initial.euler[0], initial.euler[1], initial.euler[2], 0, H_B[0], H_B[1], H_B[2]};
  } else {
    const Quat<double> q = initial.q_NB.normalized();
    y_ = {q.w(), q.x(), q.y(), q.z(), H_B[0], H_B[1], H_B[2]};
  }

  if (const auto* cvode = std::get_if<Cvode>(&model.integrator)) {
    cvode_.emplace(*cvode, body_.states());
    restart_each_sample_ = cvode->restart_each_sample;
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
  while (t_ < t_end) {
    const double stop = piece_end_ < t_end - snap ? piece_end_ : t_end;
    while (t_ < stop) step_towards(stop);
    if (t_ < t_end) {
      publish();
      enter_piece();
    }
  }
  publish();
  tick_ = static_cast<Tick>(std::floor((t_ + snap) / dt_));
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
  at_limit_ = {};
  double t1 = actuators_.all_constant() ? stop : smooth_end(stop);
  fit_delivered(t1);
  if (momentum_limited_) {
    t1 = stop_at_momentum_limits(t1);
    fit_delivered(t1);
  }
  if (rk4_substeps_ > 0 || restart_) absorb_torquer_impulse();
  set_exchange(t1);
  integrate(t1);
  take_up_storage(t1 - t_);
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
    if (at_limit_.test(i)) {
      c = {};
    } else if (actuators_.constant(i)) {
      c = {actuators_.constant_delivered(i), 0, 0, 0};
    } else {
      std::array<double, 4> f;
      for (std::size_t j = 0; j < 4; ++j) f[j] = actuators_.delivered(i, t_ + 0.5 * (1 + gauss_node[j]) * (t1 - t_));
      c = cubic_through(f);
      degree_ = 3;
    }
  }
}

/// Marks the wheels that are at their momentum limit and would go beyond. Returns the time until which that holds and
/// no other wheel meets its limit. Friction is taken as it is now: the time errs by the second order of the interval.
double Plant::stop_at_momentum_limits(double t1) noexcept {
  const double length = t1 - t_;
  double x1 = 1;
  for (int i = 0; i < actuators_.size(); ++i) {
    const double limit = actuators_.actuators().momentum_max[i];
    if (!std::isfinite(limit)) continue;
    const Cubic& c = delivered_[static_cast<std::size_t>(i)];
    const double h0 = momentum(i), drag = friction(i);
    const auto h = [&](double x) { return h0 - length * (integral(c, x) + drag * x); };
    const auto beyond = [&](double x) { return std::abs(h(x)) > limit; };
    const double nearby = std::min(1.0, snap / length);
    const bool at_limit = std::abs(h0) >= limit * (1 - 1e-9) || beyond(nearby);
    const double outward = h0 > 0 ? -1 : 1;  // sign of the delivered torque that takes the wheel further out
    if (at_limit && outward * value(c, 1e-3) > 0) {
      at_limit_.set(i);
      const auto inward = [&](double x) { return outward * value(c, x) < 0; };
      if (inward(1)) x1 = std::min(x1, bisect(0, 1, 1e-9, inward));
    } else if (!at_limit && beyond(1)) {
      x1 = std::min(x1, bisect(0, 1, 1e-15, beyond));
    }
  }
  return x1 < 1 ? t_ + x1 * length : t1;
}

/// The momentum that the actuators hold, as polynomials until t1.
void Plant::set_exchange(double t1) noexcept {
  const double length = t1 - t_, per_length = 1 / length;
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
    const Vec3<double> g = body_.D_B.col(i);
    const bool torquer = mixed && !actuators_.actuators().is_wheel(i);
    for (std::size_t k = 0; k < powers; ++k) {
      exchange_.stored_B.c[k] += held[k] * g;
      if (torquer) exchange_.torquers_B.c[k] += held[k] * g;
    }
    if (const int j = friction_index_[static_cast<std::size_t>(i)]; j >= 0) {
      Quartic<double>& h = exchange_.friction_wheel_momentum[static_cast<std::size_t>(j)];
      reset(h, 0.0);
      h.c = held;
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
void Plant::take_up_storage(double length) noexcept {
  for (int i = 0; i < actuators_.size(); ++i) {
    const double change = stored_rest_[i] - length * integral(delivered_[static_cast<std::size_t>(i)], 1);
    const double sum = stored_[i] + change;
    stored_rest_[i] = change - (sum - stored_[i]);
    stored_[i] = sum;
  }
}

// ---- integration --------------------------------------------------------------------------------------------------------

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
  constexpr int capacity = friction ? Body::rigid_states + max_actuators : Body::rigid_states;
  integrate_as<capacity, derivative<friction, varying>, true>(motion(), t1);
}

template <int capacity, auto derivative, bool unit_quaternion, class Context>
void Plant::integrate_as(const Context& m, double t1) {
  if (cvode_) {
    if (restart_) cvode_->restart(t_, y_.data());
    restart_ = false;
    const Rhs rhs = [](double t, const double* y, double* ydot, const void* context) noexcept {
      derivative(*static_cast<const Context*>(context), t, y, ydot);
    };
    cvode_->advance(rhs, &m, t1, y_.data());
    return;
  }
  const auto rhs = [&m](double t, const double* y, double* ydot) noexcept { derivative(m, t, y, ydot); };
  const double steps = std::max(1.0, std::ceil((t1 - t_) / dt_ * rk4_substeps_ - 1e-6));
  const double h = (t1 - t_) / steps;
  for (double k = 0; k < steps; ++k) {
    rk4_step<capacity>(rhs, t_ + k * h, h, y_.data(), body_.states());
    if constexpr (!unit_quaternion) continue;
    const double shrink = 1 / std::sqrt(y_[0] * y_[0] + y_[1] * y_[1] + y_[2] * y_[2] + y_[3] * y_[3]);
    for (std::size_t i = 0; i < 4; ++i) y_[i] *= shrink;
  }
  rk4_statistics_.steps += static_cast<std::uint64_t>(steps);
}

IntegratorStatistics Plant::statistics() const {
  if (cvode_) return cvode_->statistics();
  IntegratorStatistics s = rk4_statistics_;
  s.rhs_evaluations = 4 * s.steps;
  return s;
}

// ---- what others see ------------------------------------------------------------------------------------------------------

/// N m s, of wheel i, friction included.
double Plant::momentum(int i) const noexcept {
  const int j = friction_index_[static_cast<std::size_t>(i)];
  const double taken = j < 0 ? 0.0 : y_[static_cast<std::size_t>(Body::rigid_states + j)];
  return stored_[i] + stored_rest_[i] + taken;
}

/// N m on the body along axis i.
double Plant::friction(int i) const noexcept {
  const int j = friction_index_[static_cast<std::size_t>(i)];
  if (j < 0) return 0;
  const Body::FrictionWheel& wheel = body_.friction_wheels[static_cast<std::size_t>(j)];
  return wheel.friction(momentum(i) / wheel.inertia - wheel.axis_B.dot(omega_BN_B_));
}

void Plant::publish() {
  q_NB_ = euler_body_ ? quat_from_euler<double>({y_[0], y_[1], y_[2]})
                      : Quat<double>(y_[0], y_[1], y_[2], y_[3]).normalized();
  Vec3<double> Jw{y_[4], y_[5], y_[6]};
  for (int i = 0; i < actuators_.size(); ++i) {
    const double h = momentum(i);
    Jw -= h * body_.D_B.col(i);
    if (actuators_.actuators().is_wheel(i)) h_w_[i] = h;
  }
  omega_BN_B_ = body_.J_B_inverse * Jw;
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
    s.delivered[i] = (at_limit_.test(i) ? 0.0 : actuators_.delivered(i, t_)) + friction(i);
  }
  s.external_B = external_.torque_B(t_, q_NB_, omega_BN_B_);
  if (euler_body_) {
    const Vec3<double> moment = torque<double>(body_.D_B, s.delivered) + s.external_B;
    s.omegadot_BN_B = euler_body_->acceleration(euler().angles, omega_BN_B_) + body_.J_B_inverse * moment;
    return s;
  }
  const Vec3<double> rotating = body_.J_B * omega_BN_B_ + torque<double>(body_.D_B, h_w_);
  const Vec3<double> moment = torque<double>(body_.D_B, s.delivered) + s.external_B - omega_BN_B_.cross(rotating);
  s.omegadot_BN_B = body_.J_B_inverse * moment;
  return s;
}

}  // namespace gyrostat::truth
