// SPDX-License-Identifier: MIT
#include "gyrostat/truth/held_plant.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cstdio>

namespace gyrostat::truth {
namespace {

constexpr double snap = 1e-9;  // s, switches this close are simultaneous

/// Longest piece of a varying law, in radians of its fastest part: a cubic through four Gauss nodes then errs by
/// (0.05)^4 / 1680 = 4e-9 of the amplitude inside, and by order 8 in the integral over the piece.
constexpr double longest_angle = 0.05;
constexpr double shortest_piece = 1e-6;  // s, however fast a law is

constexpr std::uint64_t most_steps = 200'000;  // of a sample

}  // namespace

std::string detail::text(double x) {
  std::array<char, 32> out{};
  std::snprintf(out.data(), out.size(), "%.3g", x);
  return out.data();
}

HeldPlant::HeldPlant(PlantModel& model, const InitialState& initial, double dt, const Mat3<double>& J_total_B,
                     int states)
    : J_B_(model.J_B),
      J_B_inverse_(model.J_B.inverse()),
      D_B_(model.D_B),
      states_(states),
      actuators_(std::move(model.actuators), std::move(model.faults)),
      external_(std::move(model.disturbances), J_total_B, model.orbit_rate, std::move(model.orbit)),
      dt_(dt) {
  const bool symmetric =
      (J_B_ - J_B_.transpose()).norm() <= 1e-12 * J_B_.norm();  // rounding of what the caller computed
  detail::refuse_if(!J_B_.allFinite() || !symmetric || Eigen::LLT<Mat3<double>>(J_B_).info() != Eigen::Success,
                    "body: the inertia (less the wheels' axial inertia) must be symmetric and positive definite");
  const int n = actuators_.size();
  if (D_B_.cols() != n || !D_B_.allFinite()) {
    throw std::invalid_argument("body: D_B must be finite with one column for each of the " + std::to_string(n) +
                                " actuators");
  }
  detail::refuse_if(!(dt > 0) || !std::isfinite(dt), "plant: dt must be positive and finite");
  detail::refuse_if(!initial.omega_BN_B.allFinite(), "plant: the initial rate must be finite");
  stored_ = initial.h_w.size() == 0 ? VecN<double>::Zero(n) : initial.h_w;
  detail::refuse_if(stored_.size() != n || !stored_.allFinite(),
                    "plant: h_w must be finite, with one element an actuator");
  stored_rest_ = state_.h_w = VecN<double>::Zero(n);
  impulse_ = impulse_rest_ = impulse_before_ = burnt_per_impulse_ = VecN<double>::Zero(n);
  const Thrusters& thrusters = actuators_.actuators().thrusters;
  detail::refuse_if(thrusters.on_off() && std::abs(thrusters.period - dt) > 1e-12 * dt,
                    "plant: the thrusters' period must be dt");
  for (int i = 0; i < n; ++i) {
    if (thrusters.has(i)) burnt_per_impulse_[i] = 1 / (thrusters[i].lever * thrusters[i].Isp * Thrusters::g0);
  }
  held_.J_B_inverse = J_B_inverse_;
  inverse_inertia_ = J_B_inverse_.norm();
  if (const auto* cvode = std::get_if<Cvode>(&model.integrator)) {
    // Valves, gimbals and dipoles bend the momentum inside and at every sample. An error estimate that takes it for smooth is
    // too small.
    const bool bends = thrusters.on_off() || !model.gyros.empty() || model.magnetorquers.any();
    const double share = bends ? 0.1 : 1;
    cvode_.emplace(Cvode{std::max(1e-15, share * cvode->rtol), share * cvode->atol, false}, states_);
    restart_each_sample_ = cvode->restart_each_sample;
    pair_ = {cvode->rtol, cvode->atol};
  } else if (const auto* pair = std::get_if<Auto>(&model.integrator)) {
    pair_ = *pair;
  } else {
    rk4_substeps_ = std::get<Rk4>(model.integrator).substeps;
    detail::refuse_if(rk4_substeps_ < 1, "rk4: substeps must be at least 1");
  }
}

void HeldPlant::begin(const Vec3<double>& omega_BN_B) {
  held_.leaves = !outer_.any() ? Held::Leaves::nothing : outer_ == along_ ? Held::Leaves::all : Held::Leaves::some;
  publish();
  state_.omega_BN_B = omega_BN_B;
  enter_piece();
}

// ---- time -----------------------------------------------------------------------------------------------------------

void HeldPlant::advance(const VecN<double>& u) {
  const Tick next = tick_ + 1;
  advance_to(u, static_cast<double>(next) * dt_);
  tick_ = next;
}

void HeldPlant::advance_to(const VecN<double>& u, double t_end) {
  detail::refuse_if(u.size() != actuators_.size(), "plant: the command must have one element an actuator");
  detail::refuse_if(!(t_end >= t_), "plant: cannot go back in time");
  if (t_ >= piece_end_ - snap) enter_piece();  // before the command: a lock freezes what was delivered until now
  actuators_.command(u, t_, t_end);
  if (actuators_.steps_between()) enter_piece();
  commanded_ = true;
  impulse_before_ = impulse_ + impulse_rest_;
  interval_began_ = t_;
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
  show_thrust();
  state_.t = t_;
  tick_ = static_cast<Tick>(std::floor((t_ + snap) / dt_));
}

void HeldPlant::limit_work(double t) const {
  if (steps() - steps_before_ > most_steps) {
    throw IntegrationError(t, "a sample takes more than " + std::to_string(most_steps) + " steps");
  }
}

/// Begins the smooth piece that starts now.
void HeldPlant::enter_piece() {
  const double from = t_ + snap;
  piece_end_ = std::min(actuators_.next_switch(from), external_.next_switch(from));
  const double branch = 0.5 * (from + (std::isfinite(piece_end_) ? piece_end_ : from + dt_));
  actuators_.enter(t_, branch);

  const Vec3<double> before_B = external_.torque_B(t_, state_.q_NB, state_.omega_BN_B);
  external_.enter(branch);
  const Vec3<double> after_B = external_.torque_B(t_, state_.q_NB, state_.omega_BN_B);
  const double rounding = 1e-13 * (before_B.norm() + after_B.norm());
  if ((after_B - before_B).norm() > rounding) restart_ = true;
}

/// One piece of time on which everything is smooth: to `stop` or as far as that goes.
void HeldPlant::step_towards(double stop) {
  double t1 = actuators_.all_constant() ? stop : smooth_end(stop);
  pieces_ = least_steps(t1 - t_);
  if (looks_ahead_) {  // a step at a time
    if (rk4_substeps_ > 0) t1 = t_ + (t1 - t_) / rk4_steps(t1 - t_);
    pieces_ = 1;
  }
  length_ = t1 - t_;
  fit_delivered(t1);
  const double dry = dry_time(t1);
  if (dry <= t_) return actuators_.run_dry();
  if (dry < t1) {
    t1 = dry;
    length_ = t1 - t_;
    fit_delivered(t1);
  }
  if (stops_.any()) end_at_stops(t1);
  if (!has_history()) absorb_outer_impulse();
  t1 = fly_piece(t1);
  statistics_.pieces += static_cast<std::uint64_t>(pieces_);
  take_up_storage((t1 - t_) / length_);
  if (stops_.any()) snap_to_stops();
  t_ = t1;
  if (t_ >= dry) actuators_.run_dry();
  if (!std::isfinite(y_[0] + y_[1] + y_[2] + y_[3] + y_[4] + y_[5] + y_[6])) throw NonFiniteState(t_);
}

// ---- actuators over one piece -----------------------------------------------------------------------------------------

double HeldPlant::smooth_end(double stop) const noexcept {
  double t1 = stop;
  if (actuators_.fastest() > 0) {
    const double longest = std::max(longest_angle / actuators_.fastest(), shortest_piece);
    const double pieces = std::ceil((stop - t_) / longest);
    if (pieces > 1) t1 = t_ + (stop - t_) / pieces;
  }
  return actuators_.may_kink() ? first_kink(t1) : t1;
}

/// First time until t1 at which a varying output meets or leaves its limit.
double HeldPlant::first_kink(double t1) const noexcept {
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

void HeldPlant::fit_delivered(double t1) noexcept {
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
void HeldPlant::hold() noexcept {
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
    if (!along_.test(i)) continue;
    const Vec3<double> g = D_B_.col(i);
    const bool leaves = some_leaves && outer_.test(i);
    for (std::size_t k = 0; k < powers; ++k) {
      held_.stored_B.c[k] += P[k] * g;
      if (leaves) held_.outer_B.c[k] += P[k] * g;
    }
  }
}

/// A channel at a stop delivers nothing outward. The piece ends where one reaches its stop or leaves it: of constant drives
/// exactly, of others within 1e-12 s.
void HeldPlant::end_at_stops(double& t1) noexcept {
  constexpr int probes = 8;
  const double shortest = 1e-12 + 1e-15 * t_;  // CVODE needs as much to start
  stopped_ = {};
  double end = 1;  // of the piece
  for (int i = 0; i < actuators_.size(); ++i) {
    if (!stops_.test(i)) continue;
    const Cubic& drive = delivered_[static_cast<std::size_t>(i)];
    const double P = stored(i);
    const int side = P <= stop_lo_[i] ? -1 : P >= stop_up_[i] ? 1 : 0;  // P' = -drive
    const bool rests = side != 0 && -side * drive[0] >= 0;
    stopped_.set(i, rests);
    const auto over = [&](double x) {
      if (rests) return -side * value(drive, x) < 0;
      const double p = stored(i, x);
      return p < stop_lo_[i] || p > stop_up_[i];
    };
    if (!rests && actuators_.constant(i)) {
      const double bound = drive[0] > 0 ? stop_lo_[i] : stop_up_[i];
      if (over(end)) end = std::min(end, (P - bound) / (length_ * drive[0]));
      continue;
    }
    double lo = 0;
    for (int k = 1; k <= probes && lo < end; ++k) {
      const double hi = static_cast<double>(k) / probes;
      if (over(hi)) {
        end = std::min(end, bisect(lo, hi, 1e-12 / length_, over));
        break;
      }
      lo = hi;
    }
  }
  if (end < 1) {
    t1 = std::min(t1, t_ + std::max(end * length_, shortest));
    length_ = t1 - t_;
    fit_delivered(t1);
  }
  for (int i = 0; i < actuators_.size(); ++i) {
    if (stopped_.test(i)) delivered_[static_cast<std::size_t>(i)] = {};
  }
}

/// What a piece has brought to a stop, but for rounding, is there.
void HeldPlant::snap_to_stops() noexcept {
  for (int i = 0; i < actuators_.size(); ++i) {
    if (!stops_.test(i)) continue;
    const double P = stored(i), near = 1e-11 * (stop_up_[i] - stop_lo_[i]);
    for (const double bound : {stop_lo_[i], stop_up_[i]}) {
      if (std::abs(P - bound) > near) continue;
      stored_[i] = bound;
      stored_rest_[i] = 0;
    }
  }
}

/// Puts the impulse that leaves along fixed axes into the body's momentum and begins to count it anew, so that it stays small.
/// Changes the state: only where the integrator has no history.
void HeldPlant::absorb_outer_impulse() noexcept {
  if (!outer_.any()) return;
  for (int i = 0; i < actuators_.size(); ++i) {
    if (!outer_.test(i)) continue;
    const double impulse = stored_[i] + stored_rest_[i];
    for (int axis = 0; axis < 3; ++axis) y_[static_cast<std::size_t>(4 + axis)] -= impulse * D_B_(axis, i);
    stored_[i] = stored_rest_[i] = 0;
  }
}

namespace {
/// Kahan's sum; `rest` is what the last additions lost.
void add_compensated(double& sum, double& rest, double change) noexcept {
  change += rest;
  const double more = sum + change;
  rest = change - (more - sum);
  sum = more;
}
}  // namespace

/// Compensated: over many samples a constant torque would else be rounded the same way each time.
/// @param x  how much of the piece was gone through
void HeldPlant::take_up_storage(double x) noexcept {
  for (int i = 0; i < actuators_.size(); ++i) {
    add_compensated(stored_[i], stored_rest_[i], -length_ * integral(delivered_[static_cast<std::size_t>(i)], x));
  }
  const Thrusters& thrusters = actuators_.actuators().thrusters;
  for (int i = thrusters.first; thrusters.has(i); ++i) {
    add_compensated(impulse_[i], impulse_rest_[i], length_ * integral(delivered_[static_cast<std::size_t>(i)], x));
  }
}

/// When the propellant is used up on the piece to t1, whose drives are fitted: not after t_ when it is; infinity: later.
double HeldPlant::dry_time(double t1) const noexcept {
  const double mass = actuators_.actuators().thrusters.propellant_mass;
  if (!std::isfinite(mass) || actuators_.dry()) return infinity;
  const double left = mass - burnt_per_impulse_.dot(impulse_ + impulse_rest_);
  Cubic burning{};
  for (int i = 0; i < actuators_.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k)
      burning[k] += burnt_per_impulse_[i] * delivered_[static_cast<std::size_t>(i)][k];
  }
  const auto burnt = [&](double x) { return length_ * integral(burning, x); };
  const double rounding = 1e-15 * mass, shortest = 1e-12 + 1e-15 * t_;  // s, that CVODE can start on
  if (left <= rounding) return t_;
  if (burnt(1) < left) return infinity;
  const double x = degree_ == 0 ? left / burnt(1) : bisect(0, 1, 1e-15, [&](double z) { return burnt(z) >= left; });
  const double t = t_ + x * length_;
  return t - t_ < shortest ? t_ : t1 - t < shortest ? t1 : t;
}

/// What thrusters did: since the start, and on average over the interval.
void HeldPlant::show_thrust() noexcept {
  const Thrusters& thrusters = actuators_.actuators().thrusters;
  state_.propellant = 0;
  state_.thruster_impulse_B.setZero();
  for (int i = thrusters.first; thrusters.has(i); ++i) {
    const double impulse = impulse_[i] + impulse_rest_[i];
    state_.propellant += burnt_per_impulse_[i] * impulse;
    state_.thruster_impulse_B += impulse / thrusters[i].lever * thrusters[i].direction_B;
  }
}

// ---- integration --------------------------------------------------------------------------------------------------------

InnerRates HeldPlant::inner_rates() const noexcept {
  Vec3<double> held{y_[4], y_[5], y_[6]};
  if (outer_.any() || leaves_beside_axes_)
    held = J_B_ * state_.omega_BN_B + torque<double>(D_B_, state_.h_w) + turning_others_B_;
  const double precession2 = held.squaredNorm() * inverse_inertia_ * inverse_inertia_;
  return {std::sqrt(2 * (state_.omega_BN_B.squaredNorm() + precession2)), bending_rate_, friction_rate_};
}

/// Steps on this length so that none is longer than rk4 may take them.
/// @throws IntegrationError when they are so many that no method gets through a sample
double HeldPlant::least_steps(double length) const {
  const InnerRates rates = inner_rates();
  const double rate = rates.turning + rates.friction;
  if (!(length * rate > InnerRates::longest_step)) return 1;  // nor a rate that is not finite: that is found later
  if (rate * dt_ > InnerRates::most_in_a_sample) {
    throw IntegrationError(t_, "the vehicle turns, precesses or slows down at " + detail::text(rate) +
                                   " 1/s, more than 1000 times in a sample,");
  }
  return std::ceil(length * rate / InnerRates::longest_step);
}

/// Of rk4, on the present piece.
double HeldPlant::rk4_steps(double length) const noexcept {
  return std::max(std::ceil(length / dt_ * rk4_substeps_ - 1e-6), pieces_);
}

IntegratorStatistics HeldPlant::statistics() const {
  IntegratorStatistics s = statistics_;
  if (cvode_) {
    const IntegratorStatistics c = cvode_->statistics();
    s.steps += c.steps;
    s.rhs_evaluations += c.rhs_evaluations;
    s.restarts = c.restarts;
  }
  return s;
}

TruthSample HeldPlant::sampled() const {
  const int n = actuators_.size();
  TruthSample s;
  static_cast<TruthState&>(s) = state_;
  s.delivered = s.bias = VecN<double>::Zero(n);
  s.effectiveness = VecN<double>::Ones(n);
  for (int i = 0; i < n && commanded_; ++i) {
    const Effect e = actuators_.effect(i, t_);
    s.effectiveness[i] = e.effectiveness;
    s.bias[i] = e.bias;
    s.delivered[i] = delivered(i);
  }
  const Thrusters& thrusters = actuators_.actuators().thrusters;
  for (int i = thrusters.first; thrusters.has(i) && t_ > interval_began_; ++i) {
    s.delivered[i] = (impulse_[i] + impulse_rest_[i] - impulse_before_[i]) / (t_ - interval_began_);
    s.thruster_force_B += s.delivered[i] / thrusters[i].lever * thrusters[i].direction_B;
  }
  s.external_B = external_.torque_B(t_, state_.q_NB, state_.omega_BN_B);
  return s;
}

}  // namespace gyrostat::truth
