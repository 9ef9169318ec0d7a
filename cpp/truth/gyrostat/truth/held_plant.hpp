// SPDX-License-Identifier: MIT
/// @file  The time of a plant whose command is held from sample to sample: what its models share.
///
/// Each interval is split at fault and disturbance switches, so no smooth piece straddles one; switches within 1e-9 s of a
/// sample are moved onto it. On a piece every drive is a polynomial, and what it stores another one. A model says what it
/// does on a piece (which may end early) and what is seen of its state y = [ four of attitude, H_B, its own ].
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "gyrostat/truth/momentum_form.hpp"
#include "gyrostat/truth/plant.hpp"

namespace gyrostat::truth {

namespace detail {

template <auto derivative, class Context>
void call(double t, const double* y, double* ydot, const void* context) noexcept {
  derivative(*static_cast<const Context*>(context), t, y, ydot);
}

inline void normalise(double* q) noexcept {
  const double shrink = 1 / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (std::size_t i = 0; i < 4; ++i) q[i] *= shrink;
}

inline void refuse_if(bool wrong, const char* why) {
  if (wrong) throw std::invalid_argument(why);
}

/// For messages.
std::string text(double x);

}  // namespace detail

class HeldPlant {
 public:
  virtual ~HeldPlant() = default;

  /// Holds the command u (N m, one an actuator) from this sample to the next. Takes at most 200 000 steps.
  /// @throws IntegrationError, NonFiniteState, std::invalid_argument when u has the wrong length
  void advance(const VecN<double>& u);
  /// Holds a torque on the body (N m) besides all disturbances, from now until another one: a discontinuity where it changes.
  void push(const Vec3<double>& torque_B) noexcept {
    if (torque_B == external_.outside_B()) return;
    external_.hold(torque_B);
    restart_ = true;
  }
  /// Actuator i gives this over the next interval, whatever it is commanded (FaultyActuatorsOf::drive).
  void drive(int i, std::span<const DriveStep> steps) { actuators_.drive(i, steps); }
  /// What arrives at actuator i of a command of u.
  double arriving(int i, double u) const noexcept { return actuators_.arriving(i, u); }
  /// Holds u to any time not before the present one, in one interval. `advance` then goes on to the next sample.
  void advance_to(const VecN<double>& u, double t_end);

  Tick tick() const noexcept { return tick_; }
  double time() const noexcept { return t_; }
  const TruthState& state() const noexcept { return state_; }
  const Quat<double>& q_NB() const noexcept { return state_.q_NB; }  ///< unit, sign continuous
  const Vec3<double>& omega_BN_B() const noexcept { return state_.omega_BN_B; }
  const VecN<double>& h_w() const noexcept { return state_.h_w; }  ///< zero for torquers
  IntegratorStatistics statistics() const;
  InnerRates inner_rates() const noexcept;

 protected:
  static constexpr int most_states = rigid_states + 2 * max_actuators;
  using State = std::array<double, static_cast<std::size_t>(most_states)>;

  /// @param J_total_B  with all that moves in the vehicle
  /// @param states  in all
  HeldPlant(PlantModel& model, const InitialState& initial, double dt, const Mat3<double>& J_total_B, int states);
  HeldPlant(HeldPlant&&) = default;
  HeldPlant& operator=(HeldPlant&&) = default;

  /// Flies the piece from t_ to t1 whose drives are fitted, or as far as it stays what it is; returns the time reached.
  virtual double fly_piece(double t1) = 0;
  /// state_ of y_, but for the time.
  virtual void publish() = 0;
  /// Once the state is set.
  void begin(const Vec3<double>& omega_BN_B);

  /// The sample without acceleration; delivered without what bearings do.
  TruthSample sampled() const;
  /// N m, now: what drive, faults, limits and stops leave.
  double delivered(int i) const noexcept { return stopped_.test(i) ? 0.0 : actuators_.delivered(i, t_); }
  /// Polynomials of the piece, of what goes along fixed axes.
  void hold() noexcept;
  double rk4_steps(double length) const noexcept;
  void limit_work(double t) const;

  template <int capacity, auto derivative, bool unit_quaternion, class Context>
  void integrate_as(const Context& context, double t1);
  template <int capacity, class F>
  double pair_towards(const F& rhs, double t, double t1, State& y);

  /// Whether the integrator remembers steps before this piece; to be given up where the state is changed.
  bool has_history() const noexcept { return cvode_ && !restart_; }
  void forget_history() noexcept { restart_ = true; }

  /// N m s, that channel i has stored or given away; at x = (t - t_) / length_ of the present piece.
  double stored(int i) const noexcept { return stored_[i] + stored_rest_[i]; }
  double stored(int i, double x) const noexcept {
    return stored_[i] + stored_rest_[i] - length_ * integral(delivered_[static_cast<std::size_t>(i)], x);
  }

  Mat3<double> J_B_, J_B_inverse_;
  Mat3N<double> D_B_;
  int states_;
  Mask in_equations_;   ///< channels of effectors in the right-hand side
  Mask along_, outer_;  ///< channels whose impulse goes along a fixed axis; of these, those where it leaves the vehicle
  bool leaves_beside_axes_ = false;  ///< some impulse that leaves the vehicle does not go along a fixed axis
  double bending_rate_ = 0;          ///< rad/s, of the quickest mode of an appendage
  double friction_rate_ = 0;         ///< 1/s, at which the quickest speed dies out in viscous friction
  bool looks_ahead_ = false;         ///< pieces are flown a step at a time
  Vec3<double> turning_others_B_ =
      Vec3<double>::Zero();  ///< N m s, beside body and wheels, that turns with the vehicle
  FaultyActuators actuators_;
  Disturbances external_;
  double dt_;
  int rk4_substeps_ = 0;  ///< zero: another integrator
  std::optional<CvodeSolver> cvode_;
  Auto pair_;  ///< its tolerance: of `auto`, and of the look ahead for CVODE

  double t_ = 0;
  bool commanded_ = false;
  double length_ = 0;  ///< s, of the present piece, which begins at t_
  State y_{};
  VecN<double> stored_;       ///< h_w of turning and full wheels without what viscous friction took, p of torquers
  VecN<double> stored_rest_;  ///< what rounding kept out of stored_ (compensated summation)
  int degree_ = 0;
  std::array<Cubic, max_actuators> delivered_{};  ///< N m, in (t - t_) / length_, without viscous friction
  Mask stops_;                                    ///< channels whose impulse has bounds,
  VecN<double> stop_lo_, stop_up_;                ///< N m s: what drives it further outward is not delivered
  Mask stopped_;                                  ///< of these, at one on the present piece
  Held held_;
  IntegratorStatistics statistics_;

  TruthState state_;

 private:
  std::uint64_t steps() const noexcept { return cvode_ ? cvode_->steps() : statistics_.steps; }
  void enter_piece();
  void step_towards(double stop);
  double smooth_end(double stop) const noexcept;
  double first_kink(double t1) const noexcept;
  void fit_delivered(double t1) noexcept;
  double least_steps(double length) const;
  void end_at_stops(double& t1) noexcept;
  void snap_to_stops() noexcept;
  void absorb_outer_impulse() noexcept;
  void take_up_storage(double x) noexcept;
  double dry_time(double t1) const noexcept;
  void show_thrust() noexcept;

  bool restart_each_sample_ = false;
  double pair_length_ = infinity;  ///< s, of its next step
  double inverse_inertia_ = 0;     ///< norm of the inverse
  Tick tick_ = 0;
  double piece_end_ = 0;            ///< next switch
  bool restart_ = true;             ///< the right-hand side jumped
  std::uint64_t steps_before_ = 0;  ///< when the sample began
  double pieces_ = 0;               ///< what it counts for in the statistics

  // Of thrusters:
  VecN<double> impulse_, impulse_rest_;  ///< N m s, delivered so far, with what rounding keeps out of it
  VecN<double> impulse_before_;          ///< when the interval began,
  double interval_began_ = 0;            ///< s, at this time
  VecN<double> burnt_per_impulse_;       ///< kg/(N m s)
};

template <int capacity, auto derivative, bool unit_quaternion, class Context>
void HeldPlant::integrate_as(const Context& m, double t1) {
  if (cvode_) {
    if (restart_) cvode_->restart(t_, y_.data());
    restart_ = false;
    cvode_->advance(&detail::call<derivative, Context>, &m, t1, y_.data());
    return;
  }
  const auto rhs = [&m](double t, const double* y, double* ydot) noexcept { derivative(m, t, y, ydot); };
  if (rk4_substeps_ == 0) {
    for (double t = t_; t < t1;) {
      t = pair_towards<capacity>(rhs, t, t1, y_);
      if constexpr (unit_quaternion) detail::normalise(y_.data());
      ++statistics_.steps;
      limit_work(t);
    }
    return;
  }
  const double steps = rk4_steps(t1 - t_);
  const double h = (t1 - t_) / steps;
  for (double k = 0; k < steps; ++k) {
    rk4_step<capacity>(rhs, t_ + k * h, h, y_.data(), states_);
    if constexpr (unit_quaternion) detail::normalise(y_.data());
  }
  statistics_.steps += static_cast<std::uint64_t>(steps);
  statistics_.rhs_evaluations += 4 * static_cast<std::uint64_t>(steps);
}

/// One step of the pair from y at t, to t1 or as far as its tolerance allows. Returns the time reached.
template <int capacity, class F>
double HeldPlant::pair_towards(const F& rhs, double t, double t1, State& y) {
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

}  // namespace gyrostat::truth
