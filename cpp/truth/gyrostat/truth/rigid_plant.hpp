// SPDX-License-Identifier: MIT
/// @file  The rigid body with effectors. A wheel that reaches or leaves its momentum limit, or comes to rest in its bearing or
///        breaks loose, ends a piece of time at that time.
#pragma once
#include "gyrostat/truth/held_plant.hpp"

namespace gyrostat::truth {

/// `List` is an EffectorList; RigidPlant flies the shipped one. Of another list include rigid_plant_definitions.hpp.
template <class List>
class RigidPlantOf final : public HeldPlant {
 public:
  /// @param dt  sample period, s
  /// @param others  what moves beside the wheels and torquers of the model's actuators, or is driven in their place
  /// @throws std::invalid_argument with one line that says what does not fit
  RigidPlantOf(PlantModel model, const InitialState& initial, double dt, List others = {})
      : RigidPlantOf(all_effectors(model, std::move(others)), model, initial, dt) {}

  Measurement<double> measure(Sensors& sensors) const {
    Measurement<double> y = sensors.measure(tick(), state_.q_NB, state_.omega_BN_B, state_.h_w);
    y.gimbal = state_.gimbal;
    return y;
  }
  TruthSample sample() const;
  EulerState<double> euler() const noexcept;
  /// Known up to full turns.
  static Vec3<double> angle_difference(const Vec3<double>& a, const Vec3<double>& b) noexcept;

 private:
  /// Wheels that are no longer what they were when the piece began, and why.
  struct Passed {
    Mask stopped, filled, loosened;
    double by = -infinity;  ///< the furthest that any is beyond its bound, relative

    void look(Mask& why, int i, double beyond) noexcept {
      why.set(i, beyond > 0);
      by = beyond > by ? beyond : by;
    }
  };

  RigidPlantOf(List effectors, PlantModel& model, const InitialState& initial, double dt);
  static List all_effectors(PlantModel& model, List others);
  static Mat3<double> total_inertia(const Mat3<double>& J_B, const List& effectors);
  void list_effectors();
  void set_up_gimbals(const std::vector<ControlMomentGyro>& gyros);
  void look_at_modes();

  double fly_piece(double t1) override;
  void publish() override;
  void show_others();
  void absorb_beside_axes();

  void settle_wheels() noexcept;
  void settle_standing() noexcept;
  void add_standing_inertia() noexcept;
  void store(int i, double momentum) noexcept;
  Passed passed(double t, const State& y) const noexcept;
  void integrate(double t1);
  double integrate_watching(double t1);
  template <bool coupled, bool varying>
  void integrate_rigid(double t1);
  double look_ahead(double t1, State& y);
  void single_step(double t1, State& y);
  Rhs rhs_of_effectors() const noexcept;

  /// N m s now, of wheel i without what turns with the body when it stands; the impulse that torquer i has given away.
  double momentum(int i) const noexcept { return stored(i) + taken(i, y_); }
  /// N m s, that viscous friction has taken.
  double taken(int i, const State& y) const noexcept {
    const int j = counted_[static_cast<std::size_t>(i)];
    return j < 0 ? 0.0 : y[static_cast<std::size_t>(j)];
  }
  // At (t - t_) / length_ = x of the present piece, in state y.
  double momentum(int i, double x, const State& y, const Vec3<double>& omega_BN_B) const noexcept;
  Vec3<double> rate(double x, const State& y) const noexcept;
  Vec3<double> moment(double x, const State& y, const Vec3<double>& omega_BN_B) const noexcept;

  /// Effectors in the right-hand side that are no wheels: momentum, of it what turns with the vehicle, torque on the body.
  struct Others {
    Vec3<double> momentum_B = Vec3<double>::Zero(), turning_B = Vec3<double>::Zero(), torque_B = Vec3<double>::Zero();
  };
  struct Driven {
    double impulse = 0, torque = 0;  ///< P, and the drive of its channel
  };
  auto driven_now() const noexcept {
    return [this](int i) { return Driven{stored(i), delivered(i)}; };
  }
  auto driven_at(double x) const noexcept {
    return [this, x](int i) { return Driven{stored(i, x), value(delivered_[static_cast<std::size_t>(i)], x)}; };
  }
  Scene scene(double x, const State& y, const Vec3<double>& omega_BN_B) const noexcept {
    return scene_at(t_ + x * length_, y.data(), omega_BN_B, orbit_of_effectors());
  }
  Scene scene_now() const noexcept {
    const Quat<double>& q = state_.q_NB;
    const std::array<double, 4> y{q.w(), q.x(), q.y(), q.z()};
    return scene_at(t_, y.data(), state_.omega_BN_B, orbit_of_effectors());
  }
  const Orbit* orbit_of_effectors() const noexcept { return magnetic_ ? external_.orbit() : nullptr; }
  Others others(const Scene& scene, const State& y, const auto& driven) const noexcept;

  const Wheel& wheel(int i) const noexcept { return *wheel_[static_cast<std::size_t>(i)]; }
  bool is_wheel(int i) const noexcept { return wheel_[static_cast<std::size_t>(i)] != nullptr; }
  double friction(int i, double speed) const noexcept;
  double inward(int i, int side, double drive, double speed) const noexcept;
  bool turning(int i) const noexcept { return !full_.test(i) && !standing_.test(i); }
  Motion<List> motion() const noexcept { return {effectors_, external_, held_, orbit_of_effectors()}; }

  static constexpr double at_rest = 1e-13;     ///< of the parts of a speed: it is zero
  static constexpr double rounding = 1e-12;    ///< relative, of a momentum or torque beyond its bound
  static constexpr double moving = 1e-9;       ///< of the parts of a full wheel's speed: its direction is known
  static constexpr double resolution = 1e-12;  ///< s, of the times at which something ends,
  static constexpr double barely = 1e-11;      ///< or how far, relative, a bound may then have been passed
  static int sign(double x) noexcept { return x > 0 ? 1 : (x < 0 ? -1 : 0); }

  static constexpr bool has_others =
      List::any([]<class E>() { return detail::Coupled<E> && !std::derived_from<E, Wheel>; });
  /// Any of them at all.
  bool others_fly() const noexcept { return has_others && others_fly_; }
  static constexpr int capacity = rigid_states + max_actuators * List::most_states;  ///< of the integrators
  static_assert(capacity <= most_states);

  List effectors_;
  bool others_fly_ = false;
  bool magnetic_ = false;                            ///< some of them need the field
  std::array<const Wheel*, max_actuators> wheel_{};  ///< by channel, into effectors_
  std::array<FrictionWheel*, max_actuators> friction_wheel_{};
  std::array<int, max_actuators> friction_index_{};  ///< into the state; -1: none
  std::array<int, max_actuators> counted_{};         ///< the same; -1 also while what friction takes is no part of h_w
  std::array<Cubic, max_actuators> drive_{};  ///< of watched wheels, also without dry friction and momentum limit

  // Wheels with a momentum limit or dry friction. On a piece each of them turns, or
  Mask watched_;
  Mask full_;      ///< rests at its limit: drive and friction would take it further out, nothing is delivered
  Mask standing_;  ///< rests in its bearing: dry friction takes what keeps its speed at zero
  std::array<int, max_actuators> direction_{};  ///< sign of the speed, for dry friction; 0: at rest
  Passed passed_;                               ///< at the end of the last piece
};

using RigidPlant = RigidPlantOf<Effectors>;
extern template class RigidPlantOf<Effectors>;

}  // namespace gyrostat::truth
