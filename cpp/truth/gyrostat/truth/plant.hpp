// SPDX-License-Identifier: MIT
/// @file  What really flies: body, faulty actuators, effectors, disturbances and integrator behind one face.
///
/// A command is held from sample to sample. Each interval is split at fault and disturbance switches, so no smooth
/// piece straddles one; switches within 1e-9 s of a sample are moved onto it. A wheel that reaches or leaves its
/// momentum limit, or comes to rest in its bearing or breaks loose, ends a piece at that time.
#pragma once
#include <optional>
#include <vector>

#include "gyrostat/truth/actuators.hpp"
#include "gyrostat/truth/euler_body.hpp"
#include "gyrostat/truth/integrator.hpp"

namespace gyrostat::truth {

/// The true vehicle and what happens to it.
struct PlantModel {
  Mat3<double> J_B = Mat3<double>::Identity();  ///< kg m^2, total inertia less what effectors take (wheels: Js g g')
  Mat3N<double> D_B{3, 0};                      ///< actuator axes in columns
  Actuators actuators = Actuators::ideal(0);
  Effectors effectors;  ///< what moves beside the wheels and torquers of `actuators`, or is driven in their place
  std::vector<Fault> faults;
  std::vector<Disturbance> disturbances;
  double orbit_rate = 0;                        ///< rad/s, for gravity_gradient and the Euler-angle model
  Coordinates coordinates = Coordinates::body;  ///< euler_angles: euler_body.hpp flies, omega_BN_B are Euler rates
  Integrator integrator;
};

struct InitialState {
  Quat<double> q_NB = Quat<double>::Identity();    ///< normalised on entry
  Vec3<double> omega_BN_B = Vec3<double>::Zero();  ///< rad/s
  VecN<double> h_w;                           ///< N m s, Js (Omega_i + g_i . w), zero for torquers; empty: all zero
  Vec3<double> euler = Vec3<double>::Zero();  ///< rad, roll, pitch, yaw; read by the Euler-angle model, instead of q_NB
};

/// The truth at one time, one-sided: faults and command are those of the interval that just ended. Before the first
/// one nothing is commanded or delivered.
struct TruthSample {
  double t = 0;  ///< s
  Quat<double> q_NB = Quat<double>::Identity();
  Vec3<double> omega_BN_B = Vec3<double>::Zero();     ///< rad/s
  Vec3<double> omegadot_BN_B = Vec3<double>::Zero();  ///< rad/s^2
  VecN<double> h_w;                                   ///< N m s
  VecN<double> delivered;      ///< N m on the body along each axis, limits and friction included: h_w' = -delivered
  VecN<double> effectiveness;  ///< of the faults
  VecN<double> bias;           ///< N m, of the faults
  Vec3<double> external_B = Vec3<double>::Zero();  ///< N m
};

/// How quickly the truth's own motion goes on, beside what drives it.
struct InnerRates {
  double turning = 0;  ///< 1/s, sqrt(2 (|w|^2 + |H|^2 |J^-1|^2)), H what turns with the body: of turning and precession
  double friction = 0;  ///< 1/s, at which the quickest wheel stops in viscous friction

  static constexpr double longest_step = 0.5;       ///< of rk4, in time constants; it would diverge from 2.785 on
  static constexpr double most_in_a_sample = 1000;  ///< time constants; no integrator goes on beyond
};

/// Attitude, rate or momentum became infinite or NaN.
class NonFiniteState : public std::runtime_error {
 public:
  explicit NonFiniteState(double time);
  double time;  ///< s
};

class Plant {
 public:
  /// @param dt  sample period, s
  /// @throws std::invalid_argument with one line that says what does not fit
  Plant(PlantModel model, const InitialState& initial, double dt);

  /// Holds the command u (N m, one an actuator) from this sample to the next. Takes at most 200 000 steps.
  /// @throws IntegrationError, NonFiniteState, std::invalid_argument when u has the wrong length
  void advance(const VecN<double>& u);
  /// Holds u to any time not before the present one, in one interval. `advance` then goes on to the next sample.
  void advance_to(const VecN<double>& u, double t_end);

  Tick tick() const noexcept { return tick_; }
  double time() const noexcept { return t_; }
  const Quat<double>& q_NB() const noexcept { return q_NB_; }  ///< unit, sign continuous
  const Vec3<double>& omega_BN_B() const noexcept { return omega_BN_B_; }
  const VecN<double>& h_w() const noexcept { return h_w_; }  ///< zero for torquers
  /// The Euler-angle model flies: its state are the angles, which are not confined to a range.
  bool flies_euler() const noexcept { return euler_body_.has_value(); }
  /// Roll, pitch, yaw and their rates.
  EulerState<double> euler() const noexcept;

  TruthSample sample() const;
  IntegratorStatistics statistics() const;
  InnerRates inner_rates() const noexcept;

 private:
  static constexpr int max_states = rigid_states + max_actuators * Effectors::most_states;
  using State = std::array<double, static_cast<std::size_t>(max_states)>;

  /// Wheels that are no longer what they were when the piece began, and why.
  struct Passed {
    Mask stopped, filled, loosened;
    double by = -infinity;  ///< the furthest that any is beyond its bound, relative

    void look(Mask& why, int i, double beyond) noexcept {
      why.set(i, beyond > 0);
      by = beyond > by ? beyond : by;
    }
  };

  std::uint64_t steps() const noexcept { return cvode_ ? cvode_->steps() : statistics_.steps; }
  void list_effectors();
  void limit_work(double t) const;
  void enter_piece();
  void step_towards(double stop);
  double smooth_end(double stop) const noexcept;
  double first_kink(double t1) const noexcept;
  void fit_delivered(double t1) noexcept;
  void hold() noexcept;

  void settle_wheels() noexcept;
  void settle_standing() noexcept;
  void add_standing_inertia() noexcept;
  void store(int i, double momentum) noexcept;
  Passed passed(double t, const State& y) const noexcept;

  double least_steps(double length) const;
  double rk4_steps(double length) const noexcept;
  void integrate(double t1);
  double integrate_watching(double t1);
  bool looks_ahead() const noexcept { return watched_.any() && effectors_.coupled(); }
  template <bool coupled, bool varying>
  void integrate_rigid(double t1);
  template <int capacity, auto derivative, bool unit_quaternion, class Context>
  void integrate_as(const Context& context, double t1);
  template <int capacity, class F>
  double pair_towards(const F& rhs, double t, double t1, State& y);
  double look_ahead(double t1, State& y);
  void single_step(double t1, State& y);
  Rhs rhs_of_wheels() const noexcept;
  void absorb_outer_impulse() noexcept;
  void take_up_storage(double x) noexcept;
  void publish();

  /// N m s now, of wheel i without what turns with the body when it stands; the impulse that torquer i has given away.
  double momentum(int i) const noexcept {
    const int j = counted_[static_cast<std::size_t>(i)];
    const double taken = j < 0 ? 0.0 : y_[static_cast<std::size_t>(j)];
    return stored_[i] + stored_rest_[i] + taken;
  }
  // At (t - t_) / length_ = x of the present piece, in state y.
  double momentum(int i, double x, const State& y, const Vec3<double>& omega_BN_B) const noexcept;
  Vec3<double> rate(double x, const State& y) const noexcept;
  Vec3<double> moment(double x, const State& y, const Vec3<double>& omega_BN_B) const noexcept;

  const Wheel& wheel(int i) const noexcept { return *wheel_[static_cast<std::size_t>(i)]; }
  bool is_wheel(int i) const noexcept { return wheel_[static_cast<std::size_t>(i)] != nullptr; }
  double friction(int i, double speed) const noexcept;
  double inward(int i, int side, double drive, double speed) const noexcept;
  bool turning(int i) const noexcept { return !full_.test(i) && !standing_.test(i); }
  Motion motion() const noexcept { return {effectors_, external_, held_}; }

  Mat3<double> J_B_, J_B_inverse_;
  Mat3N<double> D_B_;
  Effectors effectors_;
  int states_ = rigid_states;
  Mask in_equations_;   ///< channels of effectors in the right-hand side
  Mask along_, outer_;  ///< channels whose impulse goes along a fixed axis; of these, those that leave the vehicle
  double friction_rate_ = 0;                         ///< 1/s, at which the quickest speed dies out in viscous friction
  std::array<const Wheel*, max_actuators> wheel_{};  ///< by channel, into effectors_
  std::array<FrictionWheel*, max_actuators> friction_wheel_{};
  std::optional<EulerBody> euler_body_;
  FaultyActuators actuators_;
  Disturbances external_;
  double dt_;
  int rk4_substeps_ = 0;  ///< zero: another integrator
  bool restart_each_sample_ = false;
  std::optional<CvodeSolver> cvode_;
  Auto pair_;                      ///< its tolerance: of `auto`, and of the look ahead for CVODE
  double pair_length_ = infinity;  ///< s, of its next step
  double inverse_inertia_ = 0;     ///< norm of the inverse

  Tick tick_ = 0;
  double t_ = 0;
  double piece_end_ = 0;  ///< next switch
  bool restart_ = true;   ///< the right-hand side jumped
  bool commanded_ = false;
  std::uint64_t steps_before_ = 0;  ///< when the sample began
  double length_ = 0;               ///< s, of the present piece, which begins at t_
  double pieces_ = 0;               ///< what it counts for in the statistics
  State y_{};
  VecN<double> stored_;       ///< h_w of turning and full wheels without what viscous friction took, p of torquers
  VecN<double> stored_rest_;  ///< what rounding kept out of stored_ (compensated summation)
  int degree_ = 0;
  std::array<Cubic, max_actuators> delivered_{};  ///< N m, in (t - t_) / length_, without viscous friction
  std::array<Cubic, max_actuators> drive_{};      ///< of watched wheels, also without dry friction and momentum limit
  Held held_;
  std::array<int, max_actuators> friction_index_{};  ///< into the state; -1: none
  std::array<int, max_actuators> counted_{};         ///< the same; -1 also while what friction takes is no part of h_w

  // Wheels with a momentum limit or dry friction. On a piece each of them turns, or
  Mask watched_;
  Mask full_;      ///< rests at its limit: drive and friction would take it further out, nothing is delivered
  Mask standing_;  ///< rests in its bearing: dry friction takes what keeps its speed at zero
  std::array<int, max_actuators> direction_{};  ///< sign of the speed, for dry friction; 0: at rest
  Passed passed_;                               ///< at the end of the last piece
  IntegratorStatistics statistics_;

  Quat<double> q_NB_;
  Vec3<double> omega_BN_B_;
  VecN<double> h_w_;
};

}  // namespace gyrostat::truth
