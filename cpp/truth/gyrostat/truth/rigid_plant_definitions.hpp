// SPDX-License-Identifier: MIT
/// @file  Definitions of RigidPlantOf, for those who fly another list of effectors than the shipped one.
#pragma once
#include <Eigen/LU>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/truth/rigid_plant.hpp"
#include "gyrostat/truth/standstill.hpp"

namespace gyrostat::truth {
namespace detail {

/// A right-hand side with its context.
struct RhsCall {
  Rhs rhs;
  const void* context;
  void operator()(double t, const double* y, double* ydot) const noexcept { rhs(t, y, ydot, context); }
};

/// Largest eigenvalue of the speeds' own dynamics, s' = -(1/Js + G' J^-1 G) C s.
double relaxation(const std::vector<FrictionWheel>& wheels, const Mat3<double>& J_B_inverse);
void refuse_quick_bearings(const std::vector<FrictionWheel>& wheels, double rate, double dt);
/// Each with those of the faults that slow its rotor down. A fault of which nothing is left ends when the rotor is at rest.
std::vector<ControlMomentGyro> with_slow_downs(std::vector<ControlMomentGyro> gyros, std::vector<Fault>& faults);

}  // namespace detail

// ---- effectors ------------------------------------------------------------------------------------------------------

/// Those that are given, and a wheel or torquer for each channel that none of them takes.
template <class List>
List RigidPlantOf<List>::all_effectors(PlantModel& model, List others) {
  const Actuators& a = model.actuators;
  if (const std::string error = a.check(); !error.empty()) throw std::invalid_argument(error);
  detail::refuse_if(model.D_B.cols() < a.size(), "body: D_B must have one column an actuator");
  if constexpr (List::template has<FlexibleMode>) {
    for (const FlexibleMode& mode : model.modes) others.add(mode);
  } else {
    detail::refuse_if(!model.modes.empty(), "plant: appendages need effectors that bend");
  }
  const std::vector<ControlMomentGyro> gyros = detail::with_slow_downs(model.gyros, model.faults);
  if constexpr (List::template has<ControlMomentGyro>) {
    for (const ControlMomentGyro& gyro : gyros) others.add(gyro);
  } else {
    detail::refuse_if(!gyros.empty(), "plant: control moment gyros need effectors that are some");
  }
  if constexpr (List::template has<Magnetorquer>) {
    for (int i = 0; i < a.size(); ++i) {
      if (model.magnetorquers.test(i)) others.add(Magnetorquer{i, model.D_B.col(i)});
    }
    detail::refuse_if(model.magnetorquers.any() && !model.orbit, "plant: magnetorquers need an orbit, for its field");
  }
  Mask taken;
  others.each([&](const auto& e) {
    if (e.channel < 0) return;
    detail::refuse_if(e.channel >= a.size() || taken.test(e.channel), "plant: an effector needs a channel of its own");
    taken.set(e.channel);
  });
  for (int i = 0; i < a.size(); ++i) {
    if (taken.test(i)) continue;
    const Wheel wheel{
        i, model.D_B.col(i), a.wheel_inertia[i], a.viscous_friction[i], a.coulomb_friction[i], a.momentum_max[i]};
    if (!a.is_wheel(i)) {
      others.add(Torquer{i});
    } else if (wheel.viscous > 0 || wheel.coulomb > 0) {
      others.add(FrictionWheel{wheel});
    } else {
      others.add(wheel);
    }
  }
  return others;
}

/// With what the effectors take of it; those with a channel in the order of the channels, whatever their kind.
template <class List>
Mat3<double> RigidPlantOf<List>::total_inertia(const Mat3<double>& J_B, const List& effectors) {
  std::array<Mat3<double>, max_actuators> of_channel;
  of_channel.fill(Mat3<double>::Zero());
  Mat3<double> total = J_B;
  effectors.each([&](const auto& e) {
    (e.channel < 0 ? total : of_channel[static_cast<std::size_t>(e.channel)]) += e.inertia_B();
  });
  for (const Mat3<double>& inertia : of_channel) total += inertia;
  return total;
}

template <class List>
RigidPlantOf<List>::RigidPlantOf(List effectors, PlantModel& model, const InitialState& initial, double dt)
    : HeldPlant(model, initial, dt, total_inertia(model.J_B, effectors), rigid_states + effectors.states()),
      effectors_(std::move(effectors)) {
  detail::refuse_if(states_ > capacity, "plant: too many effectors with states of their own");
  const double norm = initial.q_NB.norm();
  detail::refuse_if(!(norm > 0) || !std::isfinite(norm), "plant: the initial quaternion must be finite and not zero");
  list_effectors();
  if (!model.gyros.empty()) set_up_gimbals(model.gyros);
  for (int i = 0; i < actuators_.size(); ++i) {
    detail::refuse_if(!is_wheel(i) && stored_[i] != 0, "plant: h_w of an ideal torquer must be zero");
    detail::refuse_if(is_wheel(i) && std::abs(stored_[i]) > wheel(i).momentum_max,
                      "plant: a wheel starts beyond its momentum_max");
  }
  const Quat<double> q = initial.q_NB.normalized();
  state_.q_NB = q;
  state_.omega_BN_B = initial.omega_BN_B;
  const Scene scene = scene_now();
  double* inner = y_.data() + rigid_states;
  effectors_.each_coupled([&]<class E>(const E& e) {
    if constexpr (E::states > 0) e.start(scene, inner);
    inner += E::states;
  });
  Vec3<double> H_B = J_B_ * initial.omega_BN_B + torque<double>(D_B_, stored_);
  if (others_fly()) H_B += others(scene, y_, driven_now()).momentum_B;
  std::copy_n(std::array{q.w(), q.x(), q.y(), q.z(), H_B[0], H_B[1], H_B[2]}.begin(), rigid_states, y_.begin());
  begin(initial.omega_BN_B);
}

/// Stops of gimbals are bounds of the impulse: the angle is a linear function of it.
template <class List>
void RigidPlantOf<List>::set_up_gimbals(const std::vector<ControlMomentGyro>& gyros) {
  const int n = actuators_.size();
  state_.gimbal = state_.rotor_momentum = VecN<double>::Zero(n);
  stop_up_ = VecN<double>::Constant(n, infinity);
  stop_lo_ = -stop_up_;
  for (const ControlMomentGyro& gyro : gyros) {
    detail::refuse_if(std::abs(gyro.angle) > gyro.angle_max, "plant: a gimbal starts beyond its stop");
    if (gyro.angle_max == infinity) continue;
    stops_.set(gyro.channel);
    stop_lo_[gyro.channel] = gyro.rotor_momentum * (gyro.angle - gyro.angle_max);
    stop_up_[gyro.channel] = gyro.rotor_momentum * (gyro.angle + gyro.angle_max);
  }
}

/// Which channels are what, and where the states of friction wheels are.
template <class List>
void RigidPlantOf<List>::list_effectors() {
  friction_index_.fill(-1);
  int next = rigid_states;
  std::vector<FrictionWheel> friction_wheels;
  effectors_.each([&]<class E>(E& e) {
    const auto index = static_cast<std::size_t>(e.channel);
    if (e.channel >= 0) in_equations_.set(e.channel, detail::Coupled<E>);
    if constexpr (detail::Coupled<E> && !std::derived_from<E, Wheel>) others_fly_ = true;
    if constexpr (detail::Coupled<E> && E::storage == Storage::outer) leaves_beside_axes_ = true;
    if constexpr (std::same_as<E, Magnetorquer>) magnetic_ = true;
    if constexpr (E::along_axis) {
      along_.set(e.channel);
      outer_.set(e.channel, E::storage == Storage::outer);
    }
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
  looks_ahead_ = watched_.any() && effectors_.coupled();
  friction_rate_ = detail::relaxation(friction_wheels, J_B_inverse_);
  detail::refuse_quick_bearings(friction_wheels, friction_rate_, dt_);
  look_at_modes();
}

/// Of appendages: rk4 would diverge where its step is too long for one.
template <class List>
void RigidPlantOf<List>::look_at_modes() {
  std::vector<FlexibleMode> modes;
  Mat3<double> J_B = J_B_;
  effectors_.each([&]<class E>(const E& e) {
    if constexpr (std::same_as<E, FlexibleMode>) {
      modes.push_back(e);
      J_B += e.inertia_B();
    }
  });
  if (modes.empty()) return;
  bending_rate_ = free_frequencies(J_B, modes).back();
  const double h = dt_ / std::max(rk4_substeps_, 1);
  if (rk4_substeps_ == 0 || bending_rate_ * h <= InnerRates::longest_bending) return;
  throw std::invalid_argument("rk4: a step of " + detail::text(h) + " s is " + detail::text(bending_rate_ * h) +
                              " rad of the quickest mode of the appendages (" + detail::text(bending_rate_) +
                              " rad/s on the free body); more than 2.785 diverges: more substeps, or cvode");
}

template <class List>
auto RigidPlantOf<List>::others(const Scene& scene, const State& y, const auto& driven) const noexcept -> Others {
  Others out;
  const double* inner = y.data() + rigid_states;
  effectors_.each_coupled([&]<class E>(const E& e) {
    if constexpr (!std::derived_from<E, Wheel>) {
      const Driven by = e.channel < 0 ? Driven{} : driven(e.channel);
      std::array<double, E::states + 1> rates{};
      e.rates(scene, by.impulse, inner, rates.data());
      const Vec3<double> h = e.momentum_B(scene, by.impulse, inner);
      out.momentum_B += h;
      out.torque_B -= e.momentum_rate_B(scene, by.impulse, -by.torque, inner, rates.data());
      if constexpr (E::storage == Storage::inner) {
        out.turning_B += h;
      } else {
        out.torque_B += e.torque_B(scene, by.impulse, inner);
      }
    }
    inner += E::states;
  });
  return out;
}

// ---- integration --------------------------------------------------------------------------------------------------------

template <class List>
double RigidPlantOf<List>::fly_piece(double t1) {
  absorb_beside_axes();
  if (watched_.any()) settle_wheels();
  for (int i = 0; i < actuators_.size(); ++i) {
    const auto index = static_cast<std::size_t>(i);
    FrictionWheel* const wheel = friction_wheel_[index];
    if (wheel == nullptr) continue;
    wheel->counts = counted_[index] < 0 ? 0 : 1;
    wheel->drag = standing_.test(i) ? 0 : wheel->viscous;
  }
  hold();
  if (watched_.any()) return integrate_watching(t1);
  integrate(t1);
  return t1;
}

template <class List>
void RigidPlantOf<List>::integrate(double t1) {
  if (effectors_.coupled()) {
    external_.varies() ? integrate_rigid<true, true>(t1) : integrate_rigid<true, false>(t1);
  } else {
    external_.varies() ? integrate_rigid<false, true>(t1) : integrate_rigid<false, false>(t1);
  }
}

template <class List>
template <bool coupled, bool varying>
void RigidPlantOf<List>::integrate_rigid(double t1) {
  integrate_as<coupled ? capacity : rigid_states, derivative<coupled, varying, List>, true>(motion(), t1);
}

/// One step of a method without history from the beginning of the piece, to t1 or as far as its tolerance allows.
template <class List>
double RigidPlantOf<List>::look_ahead(double t1, State& y) {
  if (rk4_substeps_ > 0) {
    single_step(t1, y);
    return t1;
  }
  const Motion<List> m = motion();
  y = y_;
  const double reached = pair_towards<capacity>(detail::RhsCall{rhs_of_effectors(), &m}, t_, t1, y);
  detail::normalise(y.data());
  return reached;
}

/// The same to t1, without regard to its error.
template <class List>
void RigidPlantOf<List>::single_step(double t1, State& y) {
  const Motion<List> m = motion();
  const detail::RhsCall rhs{rhs_of_effectors(), &m};
  const int n = states_;
  if (rk4_substeps_ > 0) {
    y = y_;
    rk4_step<capacity>(rhs, t_, t1 - t_, y.data(), n);
    statistics_.rhs_evaluations += 4;
  } else {
    pair_step<capacity>(pair_, rhs, t_, t1 - t_, n, y_.data(), y.data());
    statistics_.rhs_evaluations += DormandPrince::stages;
  }
  detail::normalise(y.data());
}

/// Of a body with effectors in its equations.
template <class List>
Rhs RigidPlantOf<List>::rhs_of_effectors() const noexcept {
  return external_.varies() ? &detail::call<derivative<true, true, List>, Motion<List>>
                            : &detail::call<derivative<true, false, List>, Motion<List>>;
}

/// As absorb_outer_impulse, of what is not along an axis; CVODE's history is given up where it has grown beyond what turns.
template <class List>
void RigidPlantOf<List>::absorb_beside_axes() {
  if (!leaves_beside_axes_) return;
  const Scene now = scene(0, y_, Vec3<double>::Zero());
  Vec3<double> left_B = Vec3<double>::Zero();
  effectors_.each_coupled([&]<class E>(const E& e) {
    if constexpr (E::storage == Storage::outer && E::states == 0)
      left_B += e.momentum_B(now, stored(e.channel), nullptr);
  });
  const Vec3<double> H{y_[4], y_[5], y_[6]};
  const double most = 10 * ((H - left_B).norm() + 0.01 * J_B_.norm());  // of 0.01 rad/s: much for a dipole
  if (has_history() && left_B.norm() <= most) return;
  effectors_.each_coupled([&]<class E>(const E& e) {
    if constexpr (E::storage == Storage::outer && E::states == 0) stored_[e.channel] = stored_rest_[e.channel] = 0;
  });
  for (int axis = 0; axis < 3; ++axis) y_[static_cast<std::size_t>(4 + axis)] -= left_B[axis];
  forget_history();
}

// ---- what others see ------------------------------------------------------------------------------------------------------

template <class List>
void RigidPlantOf<List>::publish() {
  state_.q_NB = Quat<double>(y_[0], y_[1], y_[2], y_[3]).normalized();
  Vec3<double> Jw{y_[4], y_[5], y_[6]};
  for (int i = 0; i < actuators_.size(); ++i) {
    const double h = momentum(i);
    if (along_.test(i)) Jw -= h * D_B_.col(i);
    if (is_wheel(i)) state_.h_w[i] = h;
  }
  if (others_fly()) {
    const Others more = others(scene_now(), y_, driven_now());
    Jw -= more.momentum_B;
    turning_others_B_ = more.turning_B;
  }
  state_.omega_BN_B = held_.J_B_inverse * Jw;
  if (others_fly()) show_others();
  if (!standing_.any()) return;
  for (int i = 0; i < actuators_.size(); ++i) {
    if (standing_.test(i)) state_.h_w[i] = wheel(i).turned_momentum(state_.omega_BN_B);
  }
}

/// What is seen of their states.
template <class List>
void RigidPlantOf<List>::show_others() {
  const Scene scene = scene_now();
  const double* inner = y_.data() + rigid_states;
  state_.eta.resize(0);
  state_.eta_rate.resize(0);
  effectors_.each_coupled([&]<class E>(const E& e) {
    if constexpr (requires { e.show(scene, 0.0, inner, state_); }) {
      e.show(scene, e.channel < 0 ? 0.0 : stored(e.channel), inner, state_);
    }
    inner += E::states;
  });
}

template <class List>
Vec3<double> RigidPlantOf<List>::angle_difference(const Vec3<double>& a, const Vec3<double>& b) noexcept {
  Vec3<double> z = a - b;
  for (double& angle : z) angle = wrapped(angle);
  return z;
}

template <class List>
EulerState<double> RigidPlantOf<List>::euler() const noexcept {
  const Vec3<double> angles = gyrostat::euler(state_.q_NB);
  return {angles, euler_rates(angles, state_.omega_BN_B)};
}

template <class List>
TruthSample RigidPlantOf<List>::sample() const {
  const int n = actuators_.size();
  TruthSample s = sampled();
  for (int i = 0; i < n && commanded_; ++i) {
    if (!turning(i)) {
      s.delivered[i] = 0;
    } else if (is_wheel(i)) {
      s.delivered[i] += friction(i, wheel(i).speed(state_.h_w[i], state_.omega_BN_B));
    }
  }
  effectors_.each([&]<class E>(const E& e) {  // of a gyro's, what its rotor still holds
    if constexpr (std::same_as<E, ControlMomentGyro>) {
      const double share = e.momentum(t_) / e.rotor_momentum;
      for (VecN<double>* v : {&s.delivered, &s.effectiveness, &s.bias}) (*v)[e.channel] *= share;
    }
  });
  Vec3<double> rotating = J_B_ * state_.omega_BN_B + torque<double>(D_B_, state_.h_w),
               along = torque<double>(D_B_, s.delivered);
  if (others_fly()) {
    along.setZero();
    for (int i = 0; i < n; ++i) {
      if (along_.test(i)) along += D_B_.col(i) * s.delivered[i];
    }
    const Others more = others(scene_now(), y_, driven_now());
    rotating += more.turning_B;
    along += more.torque_B;
  }
  const Vec3<double> moment = along + s.external_B - state_.omega_BN_B.cross(rotating);
  s.omegadot_BN_B = held_.J_B_inverse * moment;
  for (int i = 0; i < n && commanded_; ++i) {
    if (standing_.test(i)) s.delivered[i] = -wheel(i).turned_momentum(s.omegadot_BN_B);
  }
  return s;
}

// ---- momenta, speeds, torques ------------------------------------------------------------------------------------------

/// N m s, of wheel i, all of it; the impulse that torquer i has given away.
template <class List>
double RigidPlantOf<List>::momentum(int i, double x, const State& y, const Vec3<double>& omega_BN_B) const noexcept {
  if (standing_.test(i)) return wheel(i).turned_momentum(omega_BN_B);
  return stored(i, x) + taken(i, y);
}

/// N m on the body, of the bearing of a turning wheel.
template <class List>
double RigidPlantOf<List>::friction(int i, double speed) const noexcept {
  return wheel(i).viscous * speed + wheel(i).coulomb * direction_[static_cast<std::size_t>(i)];
}

template <class List>
Vec3<double> RigidPlantOf<List>::rate(double x, const State& y) const noexcept {
  Vec3<double> Jw{y[4], y[5], y[6]};
  for (int i = 0; i < actuators_.size(); ++i) {
    if (along_.test(i) && !standing_.test(i)) Jw -= (stored(i, x) + taken(i, y)) * D_B_.col(i);
  }
  if (others_fly()) Jw -= others(scene(x, y, Vec3<double>::Zero()), y, driven_at(x)).momentum_B;
  return held_.J_B_inverse * Jw;
}

/// N m, all that turns the body and the wheels that stand in it.
template <class List>
Vec3<double> RigidPlantOf<List>::moment(double x, const State& y, const Vec3<double>& omega_BN_B) const noexcept {
  Vec3<double> rotating = J_B_ * omega_BN_B, sum = Vec3<double>::Zero();
  for (int i = 0; i < actuators_.size(); ++i) {
    const Vec3<double> g = D_B_.col(i);
    const double h = momentum(i, x, y, omega_BN_B);
    if (is_wheel(i)) rotating += h * g;
    if (!along_.test(i) || !turning(i)) continue;
    const double viscous = is_wheel(i) ? wheel(i).viscous * wheel(i).speed(h, omega_BN_B) : 0.0;
    sum += (value(delivered_[static_cast<std::size_t>(i)], x) + viscous) * g;
  }
  if (others_fly()) {
    const Others more = others(scene(x, y, omega_BN_B), y, driven_at(x));
    rotating += more.turning_B;
    sum += more.torque_B;
  }
  const Quat<double> q_NB(y[0], y[1], y[2], y[3]);
  return sum + external_.torque_B(t_ + x * length_, q_NB, omega_BN_B) - omega_BN_B.cross(rotating);
}

/// What takes a wheel at a limit off it, relative to all torques in it. Dry friction holds a wheel at rest back.
/// @param side  sign of the momentum; zero at a limit of zero, which is never left
template <class List>
double RigidPlantOf<List>::inward(int i, int side, double drive, double speed) const noexcept {
  if (side == 0) return -1;
  const int direction = direction_[static_cast<std::size_t>(i)];
  const double dry = wheel(i).coulomb, viscous = wheel(i).viscous * speed;
  const double torque = side * (drive + viscous) + (direction == 0 ? -dry : side * direction * dry);
  return torque == 0 ? 0 : torque / (std::abs(drive) + std::abs(viscous) + dry);
}

// ---- what they do on a piece -------------------------------------------------------------------------------------------

/// Decides it where the piece begins, from momenta, speeds and drives there. A wheel that rests, at its limit or in its
/// bearing, has exactly the momentum of the limit or of the body; what it held otherwise is stored when it turns again.
template <class List>
void RigidPlantOf<List>::settle_wheels() noexcept {
  const Vec3<double> w = looks_ahead_ ? rate(0, y_) : state_.omega_BN_B;
  const bool stood = standing_.any();
  for (int i = 0; i < actuators_.size(); ++i) {
    if (!watched_.test(i)) continue;
    const auto index = static_cast<std::size_t>(i);
    const double h = momentum(i, 0, y_, w), limit = wheel(i).momentum_max, dry = wheel(i).coulomb;
    const double v = wheel(i).speed(h, w), parts = wheel(i).speed_parts(h, w);
    drive_[index] = delivered_[index];
    direction_[index] = passed_.stopped.test(i) || std::abs(v) <= at_rest * parts ? 0 : sign(v);
    const bool at_limit = passed_.filled.test(i) || std::abs(h) >= limit;
    const bool full = at_limit && !(inward(i, sign(h), drive_[index][0], v) > 0);
    const bool rests = !full && dry > 0 && direction_[index] == 0;
    const bool turned = turning(i), was_full = full_.test(i);
    full_.set(i, full);
    standing_.set(i, rests);
    if (full) {
      if (!was_full) store(i, sign(h) * limit);
      delivered_[index] = {};
    } else if (rests) {
      store(i, 0);
    } else {
      if (!turned) store(i, h);
      delivered_[index][0] += dry * direction_[index];
    }
  }
  if (stood || standing_.any()) settle_standing();
}

/// Which of the wheels at rest in their bearings stay there; the others begin to turn.
template <class List>
void RigidPlantOf<List>::settle_standing() noexcept {
  add_standing_inertia();
  const Vec3<double> w = rate(0, y_);
  Standstill at_rest_now;
  for (int i = 0; i < actuators_.size(); ++i) {
    if (!standing_.test(i)) continue;
    at_rest_now.add({i, D_B_.col(i), wheel(i).inertia, drive_[static_cast<std::size_t>(i)][0], wheel(i).coulomb});
  }
  at_rest_now.settle(J_B_, moment(0, y_, w));
  for (int k = 0; k < at_rest_now.count; ++k) {
    const StandingWheel& wheel = at_rest_now.wheels[static_cast<std::size_t>(k)];
    const auto index = static_cast<std::size_t>(wheel.actuator);
    delivered_[index] = {};
    if (wheel.direction == 0) continue;
    standing_.set(wheel.actuator, false);
    store(wheel.actuator, this->wheel(wheel.actuator).turned_momentum(w));
    direction_[index] = wheel.direction;
    delivered_[index] = drive_[index];
    delivered_[index][0] += wheel.dry * wheel.direction;
  }
  add_standing_inertia();
}

template <class List>
void RigidPlantOf<List>::add_standing_inertia() noexcept {
  held_.J_B_inverse = J_B_inverse_;
  if (!standing_.any()) return;
  Mat3<double> J = J_B_;
  for (int i = 0; i < actuators_.size(); ++i) {
    if (standing_.test(i)) J += wheel(i).inertia_B();
  }
  held_.J_B_inverse = J.inverse();
}

/// Gives a wheel this momentum, beside what turns with the body when it stands.
template <class List>
void RigidPlantOf<List>::store(int i, double momentum) noexcept {
  const auto index = static_cast<std::size_t>(i);
  counted_[index] = turning(i) ? friction_index_[index] : -1;
  const double friction_took = taken(i, y_);
  stored_[i] = momentum - friction_took;
  stored_rest_[i] = momentum - stored_[i] - friction_took;
}

// ---- when that ends ----------------------------------------------------------------------------------------------------

template <class List>
auto RigidPlantOf<List>::passed(double t, const State& y) const noexcept -> Passed {
  const double x = (t - t_) / length_;
  const Vec3<double> w = looks_ahead_ ? rate(x, y) : state_.omega_BN_B;
  Vec3<double> turn = Vec3<double>::Zero();
  if (standing_.any()) turn = held_.J_B_inverse * moment(x, y, w);
  Passed out;
  for (int i = 0; i < actuators_.size(); ++i) {
    if (!watched_.test(i)) continue;
    const auto index = static_cast<std::size_t>(i);
    const double h = momentum(i, x, y, w), limit = wheel(i).momentum_max, dry = wheel(i).coulomb;
    const double drive = value(drive_[index], x), v = wheel(i).speed(h, w), parts = wheel(i).speed_parts(h, w);
    const int direction = direction_[index];
    if (full_.test(i)) {
      if (limit == 0) continue;
      out.look(out.loosened, i, inward(i, sign(h), drive, v) - rounding);
      const double turned = direction == 0 ? std::abs(v) / parts - moving : -direction * v / parts - at_rest;
      if (dry > 0 && turned > 0) out.look(out.loosened, i, turned);
      continue;
    }
    out.look(out.filled, i, std::abs(h) / limit - 1 - rounding);
    if (standing_.test(i)) {
      const double needed = std::abs(drive + wheel(i).turned_momentum(turn));
      out.look(out.loosened, i, (needed - dry) / (std::abs(drive) + dry) - rounding);
    } else if (dry > 0) {
      out.look(out.stopped, i, -direction * v / parts - at_rest);
    }
  }
  return out;
}

/// Integrates to t1, or to the first time at which a wheel is no longer what it was; returns it. Where that depends on
/// the body's motion a single step of a method without history looks ahead; unless CVODE flies, it is also taken.
template <class List>
double RigidPlantOf<List>::integrate_watching(double t1) {
  State end = y_;
  double reached = t1;
  if (looks_ahead_) reached = look_ahead(t1, end);
  passed_ = passed(reached, end);
  if (passed_.by > 0) {
    const auto passed_at = [&](double t) {
      if (looks_ahead_) single_step(t, end);
      return passed(t, end);
    };
    const double by_now = std::min(passed(t_, y_).by, 0.0);
    reached =
        first_positive(t_, by_now, reached, passed_.by, resolution, barely, [&](double t) { return passed_at(t).by; });
    reached = std::max(reached, std::min(t1, t_ + resolution + 1e-15 * t_));  // CVODE needs as much to start
    passed_ = passed_at(reached);
  }
  if (!looks_ahead_ || cvode_) {
    integrate(reached);
  } else {
    y_ = end;
    ++statistics_.steps;
  }
  return reached;
}

}  // namespace gyrostat::truth
