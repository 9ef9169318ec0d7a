// SPDX-License-Identifier: MIT
#include "gyrostat/truth/plant.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
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

using FrictionWheels = std::vector<FrictionWheel>;

// What a kind beside a fixed axis holds would have to be taken off where the rate is published.
static_assert(!Effectors::beside_axes);

/// Largest eigenvalue of the speeds' own dynamics, s' = -(1/Js + G' J^-1 G) C s.
double relaxation(const FrictionWheels& wheels, const Mat3<double>& J_B_inverse) {
  const auto n = static_cast<Eigen::Index>(wheels.size());
  if (n == 0) return 0;
  Eigen::MatrixXd symmetric(n, n);  // similar to it
  for (Eigen::Index r = 0; r < n; ++r) {
    for (Eigen::Index c = 0; c < n; ++c) {
      const FrictionWheel &a = wheels[static_cast<std::size_t>(r)], &b = wheels[static_cast<std::size_t>(c)];
      const double coupling = a.axis_B.dot(J_B_inverse * b.axis_B) + (r == c ? 1 / a.inertia : 0.0);
      symmetric(r, c) = std::sqrt(a.viscous * b.viscous) * coupling;
    }
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues()[n - 1];
}

void refuse_quick_bearings(const FrictionWheels& wheels, double rate, double dt) {
  if (rate * dt <= InnerRates::most_in_a_sample) return;
  const auto quicker = [](const FrictionWheel& a, const FrictionWheel& b) {
    return a.viscous / a.inertia < b.viscous / b.inertia;
  };
  const FrictionWheel& quickest = *std::max_element(wheels.begin(), wheels.end(), quicker);
  throw std::invalid_argument("plant: viscous_friction = " + text(quickest.viscous) +
                              " N m s stops the wheel of actuator " + std::to_string(quickest.channel) + " (" +
                              text(quickest.inertia) + " kg m^2) in " + text(1 / rate) +
                              " s; nothing quicker than a thousandth of the period, " +
                              text(dt / InnerRates::most_in_a_sample) + " s, can be integrated");
}

void refuse_no_inertia(const Mat3<double>& J_B) {
  const bool symmetric = (J_B - J_B.transpose()).norm() <= 1e-12 * J_B.norm();  // rounding of what the caller computed
  refuse_if(!J_B.allFinite() || !symmetric || Eigen::LLT<Mat3<double>>(J_B).info() != Eigen::Success,
            "body: the inertia (less the wheels' axial inertia) must be symmetric and positive definite");
}

/// The effectors of a model: those that it has, and a wheel or torquer for each channel that none of them takes.
Effectors effectors_of(PlantModel& model) {
  const Actuators& a = model.actuators;
  const int n = a.size();
  if (model.D_B.cols() != n || !model.D_B.allFinite()) {
    throw std::invalid_argument("body: D_B must be finite with one column for each of the " + std::to_string(n) +
                                " actuators");
  }
  if (const std::string error = a.check(); !error.empty()) throw std::invalid_argument(error);
  Mask taken;
  model.effectors.each([&](const auto& e) {
    if (e.channel < 0) return;
    refuse_if(e.channel >= n || taken.test(e.channel), "plant: an effector needs a channel of its own");
    taken.set(e.channel);
  });
  Effectors out = std::move(model.effectors);
  for (int i = 0; i < n; ++i) {
    if (taken.test(i)) continue;
    const Wheel wheel{
        i, model.D_B.col(i), a.wheel_inertia[i], a.viscous_friction[i], a.coulomb_friction[i], a.momentum_max[i]};
    if (!a.is_wheel(i)) {
      out.add(Torquer{i});
    } else if (wheel.viscous > 0 || wheel.coulomb > 0) {
      out.add(FrictionWheel{wheel});
    } else {
      out.add(wheel);
    }
  }
  return out;
}

/// With what the effectors take of it; wheels in the order of their channels, whatever their kind.
Mat3<double> total_inertia(const Mat3<double>& J_B, const Effectors& effectors) {
  std::array<Mat3<double>, max_actuators> of_channel;
  of_channel.fill(Mat3<double>::Zero());
  Mat3<double> total = J_B;
  effectors.each([&](const auto& e) {
    if (e.channel < 0) {
      total += e.inertia_B();
    } else {
      of_channel[static_cast<std::size_t>(e.channel)] = e.inertia_B();
    }
  });
  for (const Mat3<double>& inertia : of_channel) total += inertia;
  return total;
}

}  // namespace

NonFiniteState::NonFiniteState(double time_in)
    : std::runtime_error("the state is no longer finite at t = " + std::to_string(time_in) + " s"), time(time_in) {}

Plant::Plant(PlantModel model, const InitialState& initial, double dt)
    : J_B_(model.J_B),
      J_B_inverse_(model.J_B.inverse()),
      D_B_(model.D_B),
      effectors_(effectors_of(model)),
      states_(rigid_states + effectors_.states()),
      actuators_(std::move(model.actuators), std::move(model.faults)),
      external_(std::move(model.disturbances), total_inertia(model.J_B, effectors_), model.orbit_rate),
      dt_(dt) {
  refuse_no_inertia(J_B_);
  refuse_if(states_ > max_states, "plant: too many effectors with states of their own");
  refuse_if(!(dt > 0) || !std::isfinite(dt), "plant: dt must be positive and finite");
  const double norm = initial.q_NB.norm();
  refuse_if(!(norm > 0) || !std::isfinite(norm), "plant: the initial quaternion must be finite and not zero");
  refuse_if(!initial.omega_BN_B.allFinite(), "plant: the initial rate must be finite");
  const int n = actuators_.size();
  list_effectors();
  stored_ = initial.h_w.size() == 0 ? VecN<double>::Zero(n) : initial.h_w;
  refuse_if(stored_.size() != n || !stored_.allFinite(), "plant: h_w must be finite, with one element an actuator");
  for (int i = 0; i < n; ++i) {
    refuse_if(!is_wheel(i) && stored_[i] != 0, "plant: h_w of an ideal torquer must be zero");
    refuse_if(is_wheel(i) && std::abs(stored_[i]) > wheel(i).momentum_max,
              "plant: a wheel starts beyond its momentum_max");
  }
  stored_rest_ = VecN<double>::Zero(n);
  h_w_ = VecN<double>::Zero(n);

  Vec3<double> H_B = J_B_ * initial.omega_BN_B + torque<double>(D_B_, stored_);
  if (model.coordinates == Coordinates::euler_angles) {
    refuse_if(!initial.euler.allFinite(), "plant: the initial Euler angles must be finite");
    refuse_if(std::any_of(wheel_.begin(), wheel_.end(), [](const Wheel* w) { return w != nullptr; }),
              "plant: the Euler-angle model has no wheels; wheel_inertia must be absent or zero");
    euler_body_.emplace(J_B_, model.orbit_rate);
    y_ = {initial.euler[0], initial.euler[1], initial.euler[2], 0, H_B[0], H_B[1], H_B[2]};
  } else {
    const Quat<double> q = initial.q_NB.normalized();
    y_ = {q.w(), q.x(), q.y(), q.z(), H_B[0], H_B[1], H_B[2]};
  }

  held_.J_B_inverse = J_B_inverse_;
  inverse_inertia_ = J_B_inverse_.norm();
  if (const auto* cvode = std::get_if<Cvode>(&model.integrator)) {
    cvode_.emplace(*cvode, states_);
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

/// Which channels are what, and where the states of friction wheels are.
void Plant::list_effectors() {
  friction_index_.fill(-1);
  int next = rigid_states;
  FrictionWheels friction_wheels;
  effectors_.each([&]<class E>(E& e) {
    const auto index = static_cast<std::size_t>(e.channel);
    if (e.channel >= 0) in_equations_.set(e.channel, detail::Coupled<E>);
    if (E::along_axis) along_.set(e.channel);
    if (E::along_axis && E::storage == Storage::outer) outer_.set(e.channel);
    if constexpr (std::derived_from<E, Wheel>) {
      wheel_[index] = &e;
      watched_.set(e.channel, e.watched());
    }
    if constexpr (std::same_as<E, FrictionWheel>) {
      friction_wheel_[index] = &e;
      friction_index_[index] = next;
      friction_wheels.push_back(e);
    }
    next += E::states;
  });
  counted_ = friction_index_;
  held_.leaves = !outer_.any() ? Held::Leaves::nothing : outer_ == along_ ? Held::Leaves::all : Held::Leaves::some;
  friction_rate_ = relaxation(friction_wheels, J_B_inverse_);
  refuse_quick_bearings(friction_wheels, friction_rate_, dt_);
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
  if (!cvode_ || restart_) absorb_outer_impulse();
  if (watched_.any()) settle_wheels();
  hold();
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
void Plant::hold() noexcept {
  const double length = length_, per_length = 1 / length;
  const auto powers = static_cast<std::size_t>(degree_ + 2);
  const auto reset = [&](auto& polynomial, const auto& zero) {
    polynomial.t0 = t_;
    polynomial.per_length = per_length;
    polynomial.degree = degree_ + 1;
    for (std::size_t k = 0; k < powers; ++k) polynomial.c[k] = zero;
  };
  const Vec3<double> zero = Vec3<double>::Zero();
  reset(held_.stored_B, zero);
  const bool some_leaves = held_.leaves == Held::Leaves::some;
  if (some_leaves) reset(held_.outer_B, zero);
  for (int i = 0; i < actuators_.size(); ++i) {
    const auto index = static_cast<std::size_t>(i);
    const Cubic& c = delivered_[index];
    const std::array<double, 5> P{stored_[i] + stored_rest_[i], -length * c[0], -length * c[1] / 2, -length * c[2] / 3,
                                  -length * c[3] / 4};
    if (in_equations_.test(i)) {
      reset(held_.impulse[index], 0.0);
      held_.impulse[index].c = P;
    }
    if (FrictionWheel* const wheel = friction_wheel_[index]; wheel != nullptr) {
      wheel->counts = counted_[index] < 0 ? 0 : 1;
      wheel->drag = standing_.test(i) ? 0 : wheel->viscous;
    }
    if (!along_.test(i)) continue;
    const Vec3<double> g = D_B_.col(i);
    const bool leaves = some_leaves && outer_.test(i);
    for (std::size_t k = 0; k < powers; ++k) {
      held_.stored_B.c[k] += P[k] * g;
      if (leaves) held_.outer_B.c[k] += P[k] * g;
    }
  }
}

/// Puts the impulse that leaves along fixed axes into the body's momentum and begins to count it anew, so that it stays small.
/// Changes the state: only where the integrator has no history.
void Plant::absorb_outer_impulse() noexcept {
  if (!outer_.any()) return;
  for (int i = 0; i < actuators_.size(); ++i) {
    if (!outer_.test(i)) continue;
    const double impulse = stored_[i] + stored_rest_[i];
    for (int axis = 0; axis < 3; ++axis) y_[static_cast<std::size_t>(4 + axis)] -= impulse * D_B_(axis, i);
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
  if (outer_.any()) held = J_B_ * omega_BN_B_ + torque<double>(D_B_, h_w_);
  const double precession2 = held.squaredNorm() * inverse_inertia_ * inverse_inertia_;
  return {std::sqrt(2 * (omega_BN_B_.squaredNorm() + precession2)), friction_rate_};
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
  if (euler_body_) {
    const EulerMotion m{*euler_body_, motion()};
    external_.varies() ? integrate_as<rigid_states, euler_derivative<true>, false>(m, t1)
                       : integrate_as<rigid_states, euler_derivative<false>, false>(m, t1);
  } else if (effectors_.coupled()) {
    external_.varies() ? integrate_rigid<true, true>(t1) : integrate_rigid<true, false>(t1);
  } else {
    external_.varies() ? integrate_rigid<false, true>(t1) : integrate_rigid<false, false>(t1);
  }
}

template <bool coupled, bool varying>
void Plant::integrate_rigid(double t1) {
  constexpr int capacity = coupled ? max_states : rigid_states;
  integrate_as<capacity, derivative<coupled, varying>, true>(motion(), t1);
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
    rk4_step<capacity>(rhs, t_ + k * h, h, y_.data(), states_);
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
    const double error = pair_step<capacity>(pair_, rhs, t, h, states_, begin.data(), y.data());
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
  const double reached = pair_towards<max_states>(Call{rhs_of_wheels(), &m}, t_, t1, y);
  normalise(y.data());
  return reached;
}

/// The same to t1, without regard to its error.
void Plant::single_step(double t1, State& y) {
  const Motion m = motion();
  const Call rhs{rhs_of_wheels(), &m};
  const int n = states_;
  if (rk4_substeps_ > 0) {
    y = y_;
    rk4_step<max_states>(rhs, t_, t1 - t_, y.data(), n);
    statistics_.rhs_evaluations += 4;
  } else {
    pair_step<max_states>(pair_, rhs, t_, t1 - t_, n, y_.data(), y.data());
    statistics_.rhs_evaluations += DormandPrince::stages;
  }
  normalise(y.data());
}

/// Of a body with effectors in its equations.
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
    if (along_.test(i)) Jw -= h * D_B_.col(i);
    if (is_wheel(i)) h_w_[i] = h;
  }
  omega_BN_B_ = held_.J_B_inverse * Jw;
  if (!standing_.any()) return;
  for (int i = 0; i < actuators_.size(); ++i) {
    if (standing_.test(i)) h_w_[i] = wheel(i).turned_momentum(omega_BN_B_);
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
    s.delivered[i] = turning(i) ? actuators_.delivered(i, t_) : 0.0;
    if (is_wheel(i) && turning(i)) s.delivered[i] += friction(i, wheel(i).speed(h_w_[i], omega_BN_B_));
  }
  s.external_B = external_.torque_B(t_, q_NB_, omega_BN_B_);
  if (euler_body_) {
    const Vec3<double> moment = torque<double>(D_B_, s.delivered) + s.external_B;
    s.omegadot_BN_B = euler_body_->acceleration(euler().angles, omega_BN_B_) + J_B_inverse_ * moment;
    return s;
  }
  const Vec3<double> rotating = J_B_ * omega_BN_B_ + torque<double>(D_B_, h_w_);
  const Vec3<double> moment = torque<double>(D_B_, s.delivered) + s.external_B - omega_BN_B_.cross(rotating);
  s.omegadot_BN_B = held_.J_B_inverse * moment;
  for (int i = 0; i < n && commanded_; ++i) {
    if (standing_.test(i)) s.delivered[i] = -wheel(i).turned_momentum(s.omegadot_BN_B);
  }
  return s;
}

}  // namespace gyrostat::truth
