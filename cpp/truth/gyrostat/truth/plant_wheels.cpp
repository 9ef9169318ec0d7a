// SPDX-License-Identifier: MIT
/// @file  The wheels of a plant that have a momentum limit or dry friction: what they do on a piece, and when that ends.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gyrostat/truth/plant.hpp"
#include "gyrostat/truth/standstill.hpp"

namespace gyrostat::truth {
namespace {

constexpr double at_rest = 1e-13;     // of the parts of a speed: it is zero
constexpr double rounding = 1e-12;    // relative, of a momentum or torque beyond its bound
constexpr double moving = 1e-9;       // of the parts of a full wheel's speed: its direction is known
constexpr double resolution = 1e-12;  // s, of the times at which something ends,
constexpr double small = 1e-11;       // or how far, relative, a bound may then have been passed

int sign(double x) noexcept { return x > 0 ? 1 : (x < 0 ? -1 : 0); }

}  // namespace

// ---- momenta, speeds, torques ------------------------------------------------------------------------------------------

/// N m s, of wheel i, all of it; the impulse that torquer i has given away.
double Plant::momentum(int i, double x, const State& y, const Vec3<double>& omega_BN_B) const noexcept {
  if (standing_.test(i)) return wheel(i).turned_momentum(omega_BN_B);
  const int j = counted_[static_cast<std::size_t>(i)];
  const double taken = j < 0 ? 0.0 : y[static_cast<std::size_t>(j)];
  return stored_[i] + stored_rest_[i] - length_ * integral(delivered_[static_cast<std::size_t>(i)], x) + taken;
}

/// N m on the body, of the bearing of a turning wheel.
double Plant::friction(int i, double speed) const noexcept {
  return wheel(i).viscous * speed + wheel(i).coulomb * direction_[static_cast<std::size_t>(i)];
}

Vec3<double> Plant::rate(double x, const State& y) const noexcept {
  Vec3<double> Jw{y[4], y[5], y[6]};
  for (int i = 0; i < actuators_.size(); ++i) {
    if (!standing_.test(i)) Jw -= momentum(i, x, y, {}) * D_B_.col(i);
  }
  return held_.J_B_inverse * Jw;
}

/// N m, all that turns the body and the wheels that stand in it.
Vec3<double> Plant::moment(double x, const State& y, const Vec3<double>& omega_BN_B) const noexcept {
  Vec3<double> rotating = J_B_ * omega_BN_B, sum = Vec3<double>::Zero();
  for (int i = 0; i < actuators_.size(); ++i) {
    const Vec3<double> g = D_B_.col(i);
    const double h = momentum(i, x, y, omega_BN_B);
    if (is_wheel(i)) rotating += h * g;
    if (!turning(i)) continue;
    const double viscous = is_wheel(i) ? wheel(i).viscous * wheel(i).speed(h, omega_BN_B) : 0.0;
    sum += (value(delivered_[static_cast<std::size_t>(i)], x) + viscous) * g;
  }
  const Quat<double> q_NB(y[0], y[1], y[2], y[3]);
  return sum + external_.torque_B(t_ + x * length_, q_NB, omega_BN_B) - omega_BN_B.cross(rotating);
}

/// What takes a wheel at a limit off it, relative to all torques in it. Dry friction holds a wheel at rest back.
/// @param side  sign of the momentum; zero at a limit of zero, which is never left
double Plant::inward(int i, int side, double drive, double speed) const noexcept {
  if (side == 0) return -1;
  const int direction = direction_[static_cast<std::size_t>(i)];
  const double dry = wheel(i).coulomb, viscous = wheel(i).viscous * speed;
  const double torque = side * (drive + viscous) + (direction == 0 ? -dry : side * direction * dry);
  return torque == 0 ? 0 : torque / (std::abs(drive) + std::abs(viscous) + dry);
}

// ---- what they do on a piece -------------------------------------------------------------------------------------------

/// Decides it where the piece begins, from momenta, speeds and drives there. A wheel that rests, at its limit or in its
/// bearing, has exactly the momentum of the limit or of the body; what it held otherwise is stored when it turns again.
void Plant::settle_wheels() noexcept {
  const Vec3<double> w = looks_ahead() ? rate(0, y_) : omega_BN_B_;
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
void Plant::settle_standing() noexcept {
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

void Plant::add_standing_inertia() noexcept {
  held_.J_B_inverse = J_B_inverse_;
  if (!standing_.any()) return;
  Mat3<double> J = J_B_;
  for (int i = 0; i < actuators_.size(); ++i) {
    if (standing_.test(i)) J += wheel(i).inertia_B();
  }
  held_.J_B_inverse = J.inverse();
}

/// Gives a wheel this momentum, beside what turns with the body when it stands.
void Plant::store(int i, double momentum) noexcept {
  const auto index = static_cast<std::size_t>(i);
  const int j = counted_[index] = turning(i) ? friction_index_[index] : -1;
  const double taken = j < 0 ? 0.0 : y_[static_cast<std::size_t>(j)];
  stored_[i] = momentum - taken;
  stored_rest_[i] = momentum - stored_[i] - taken;
}

// ---- when that ends ----------------------------------------------------------------------------------------------------

Plant::Passed Plant::passed(double t, const State& y) const noexcept {
  const double x = (t - t_) / length_;
  const Vec3<double> w = looks_ahead() ? rate(x, y) : omega_BN_B_;
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
double Plant::integrate_watching(double t1) {
  State end = y_;
  double reached = t1;
  if (looks_ahead()) reached = look_ahead(t1, end);
  passed_ = passed(reached, end);
  if (passed_.by > 0) {
    const auto passed_at = [&](double t) {
      if (looks_ahead()) single_step(t, end);
      return passed(t, end);
    };
    const double by_now = std::min(passed(t_, y_).by, 0.0);
    reached =
        first_positive(t_, by_now, reached, passed_.by, resolution, small, [&](double t) { return passed_at(t).by; });
    reached = std::max(reached, std::min(t1, t_ + resolution + 1e-15 * t_));  // CVODE needs as much to start
    passed_ = passed_at(reached);
  }
  if (!looks_ahead() || cvode_) {
    integrate(reached);
  } else {
    y_ = end;
    ++statistics_.steps;
  }
  return reached;
}

}  // namespace gyrostat::truth
