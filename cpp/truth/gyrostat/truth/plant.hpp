// SPDX-License-Identifier: MIT
/// @file  What really flies: body, faulty actuators, disturbances and integrator behind one face.
///
/// A command is held from sample to sample. Each interval is split at fault and disturbance switches, so no smooth
/// piece straddles one; switches within 1e-9 s of a sample are moved onto it.
#pragma once
#include <optional>
#include <vector>

#include "gyrostat/truth/euler_body.hpp"
#include "gyrostat/truth/integrator.hpp"

namespace gyrostat::truth {

/// The true vehicle and what happens to it.
struct PlantModel {
  Mat3<double> J_B = Mat3<double>::Identity();  ///< kg m^2; with wheels: total inertia less sum Js g g'
  Mat3N<double> D_B{3, 0};                      ///< actuator axes in columns
  Actuators actuators = Actuators::ideal(0);
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

  /// Holds the command u (N m, one an actuator) from this sample to the next.
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

 private:
  using Cubic = std::array<double, 4>;  ///< delivered torque, in powers of (t - t_) / length

  void enter_piece();
  void step_towards(double stop);
  double smooth_end(double stop) const noexcept;
  double first_kink(double t1) const noexcept;
  double stop_at_momentum_limits(double t1) noexcept;
  void fit_delivered(double t1) noexcept;
  void set_exchange(double t1) noexcept;
  void integrate(double t1);
  template <bool friction, bool varying>
  void integrate_rigid(double t1);
  template <int capacity, auto derivative, bool unit_quaternion, class Context>
  void integrate_as(const Context& context, double t1);
  void absorb_torquer_impulse() noexcept;
  void take_up_storage(double length) noexcept;
  void publish();
  double momentum(int i) const noexcept;
  double friction(int i) const noexcept;
  Motion motion() const noexcept { return {body_, external_, exchange_}; }

  Body body_;
  std::optional<EulerBody> euler_body_;
  FaultyActuators actuators_;
  Disturbances external_;
  double dt_;
  int rk4_substeps_ = 0;  ///< zero: CVODE
  bool restart_each_sample_ = false;
  std::optional<CvodeSolver> cvode_;
  bool momentum_limited_ = false;

  Tick tick_ = 0;
  double t_ = 0;
  double piece_end_ = 0;  ///< next switch
  bool restart_ = true;   ///< the right-hand side jumped
  bool commanded_ = false;
  std::array<double, Body::rigid_states + max_actuators> y_{};
  VecN<double> stored_;       ///< h_w of wheels without friction's part, p of torquers
  VecN<double> stored_rest_;  ///< what rounding kept out of stored_ (compensated summation)
  Mask at_limit_;             ///< wheels that may not take up more momentum on this piece
  int degree_ = 0;
  std::array<Cubic, max_actuators> delivered_{};
  Exchange exchange_;
  std::array<int, max_actuators> friction_index_{};  ///< into the friction states; -1: none
  IntegratorStatistics rk4_statistics_;

  Quat<double> q_NB_;
  Vec3<double> omega_BN_B_;
  VecN<double> h_w_;
};

}  // namespace gyrostat::truth
