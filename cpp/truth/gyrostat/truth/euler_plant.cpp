// SPDX-License-Identifier: MIT
#include "gyrostat/truth/euler_plant.hpp"

#include "gyrostat/core/attitude.hpp"

namespace gyrostat::truth {
namespace {

/// Coordinate rotation about an axis.
Mat3<double> turn(int axis, double angle) noexcept {
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  Mat3<double> R = Mat3<double>::Identity();
  R(i, i) = R(j, j) = std::cos(angle);
  R(i, j) = std::sin(angle);
  R(j, i) = -R(i, j);
  return R;
}

/// R' per unit rate: -[e x] R.
Mat3<double> turn_rate(int axis, const Mat3<double>& R) noexcept {
  const Vec3<double> e = Vec3<double>::Unit(axis);
  return -cross_matrix(e) * R;
}

/// All that its right-hand side needs.
struct EulerMotion {
  const EulerBody& body;
  const Disturbances& external;
  const Held& held;
};

/// y' of the state y at time t. `varying`: external torque depends on time or state.
template <bool varying>
void euler_derivative(const EulerMotion& m, double t, const double* y, double* ydot) noexcept {
  const Vec3<double> angles{y[0], y[1], y[2]}, H{y[4], y[5], y[6]};
  const Vec3<double> Jw = H - m.held.stored_B(t);
  const Vec3<double> rates = m.held.J_B_inverse * Jw;
  Vec3<double> d_B = m.external.constant_B();
  if constexpr (varying) d_B = m.external.torque_B(t, Quat<double>::Identity(), rates);
  const Vec3<double> Hdot = m.body.J_B() * m.body.acceleration(angles, rates) + d_B;
  for (int i = 0; i < 3; ++i) {
    ydot[i] = rates[i];
    ydot[4 + i] = Hdot[i];
  }
  ydot[3] = 0;
}

}  // namespace

EulerBody::EulerBody(const Mat3<double>& J_B, double orbit_rate)
    : J_B_(J_B), J_(J_B.diagonal()), orbit_rate_(orbit_rate) {
  const Mat3<double> rest = J_B - Mat3<double>(J_.asDiagonal());
  if (rest.norm() > 0) throw std::invalid_argument("plant: the Euler-angle model needs a diagonal inertia");
}

Vec3<double> EulerBody::acceleration(const Vec3<double>& angles, const Vec3<double>& rates) const noexcept {
  const double w0 = orbit_rate_;
  const Mat3<double> R1 = turn(0, -angles[0]), R2 = turn(1, -angles[1]), R3 = turn(2, -angles[2]);
  const Vec3<double> n = R1 * R2 * R3.col(1);
  const Vec3<double> ndot = -rates[0] * (turn_rate(0, R1) * R2 * R3.col(1)) -
                            rates[1] * (R1 * turn_rate(1, R2) * R3.col(1)) -
                            rates[2] * (R1 * R2 * turn_rate(2, R3).col(1));
  const Vec3<double> r = turn(0, angles[0]) * turn(1, angles[1]).col(2);
  const Vec3<double> w = rates + w0 * n;
  const Vec3<double> moment = 3 * w0 * w0 * r.cross(J_.cwiseProduct(r)) - w.cross(J_.cwiseProduct(w));
  return moment.cwiseQuotient(J_) - w0 * ndot;
}

EulerPlant::EulerPlant(PlantModel model, const InitialState& initial, double dt)
    : HeldPlant(model, initial, dt, model.J_B, rigid_states), body_(J_B_, model.orbit_rate) {
  detail::refuse_if(!initial.euler.allFinite(), "plant: the initial Euler angles must be finite");
  for (int i = 0; i < actuators_.size(); ++i) {
    detail::refuse_if(actuators_.actuators().is_wheel(i),
                      "plant: the Euler-angle model has no wheels; wheel_inertia must be absent or zero");
    detail::refuse_if(stored_[i] != 0, "plant: h_w of an ideal torquer must be zero");
    along_.set(i);
    outer_.set(i);
  }
  const Vec3<double>& a = initial.euler;
  const Vec3<double> H = J_B_ * initial.omega_BN_B;
  std::copy_n(std::array{a[0], a[1], a[2], 0.0, H[0], H[1], H[2]}.begin(), rigid_states, y_.begin());
  begin(initial.omega_BN_B);
}

double EulerPlant::fly_piece(double t1) {
  hold();
  const EulerMotion m{body_, external_, held_};
  external_.varies() ? integrate_as<rigid_states, euler_derivative<true>, false>(m, t1)
                     : integrate_as<rigid_states, euler_derivative<false>, false>(m, t1);
  return t1;
}

void EulerPlant::publish() {
  state_.angles = {y_[0], y_[1], y_[2]};
  state_.q_NB = quat_from_euler<double>(state_.angles);
  Vec3<double> Jw{y_[4], y_[5], y_[6]};
  for (int i = 0; i < actuators_.size(); ++i) Jw -= stored(i) * D_B_.col(i);
  state_.omega_BN_B = J_B_inverse_ * Jw;
}

Measurement<double> EulerPlant::measure(Sensors& sensors) const {
  Measurement<double> y;
  y.tick = tick();
  y.h_w = state_.h_w;
  y.omega_BN_B = y.euler.rates = sensors.rate(tick(), state_.omega_BN_B);
  y.euler.angles = sensors.angles(tick(), state_.angles);
  y.q_NB = quat_from_euler(y.euler.angles);
  sensors.drop_out(y);
  return y;
}

TruthSample EulerPlant::sample() const {
  TruthSample s = sampled();
  const Vec3<double> moment = torque<double>(D_B_, s.delivered) + s.external_B;
  s.omegadot_BN_B = body_.acceleration(state_.angles, state_.omega_BN_B) + J_B_inverse_ * moment;
  return s;
}

static_assert(Plant<EulerPlant>);

}  // namespace gyrostat::truth
