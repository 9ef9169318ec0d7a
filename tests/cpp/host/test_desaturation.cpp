// SPDX-License-Identifier: MIT
// Momentum on an orbit: wheels that fill under a torque from outside, and magnetorquers that empty them; a tumble that dies out.
#include "gyrostat/flight/desaturation.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/controllers/open_loop.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"
#include "gyrostat/flight/stack.hpp"
#include "gyrostat/truth/rigid_plant.hpp"

namespace gyrostat::host::test_desaturation {
namespace {

using V = Vec3<double>;
using Law = CrossProductDesaturation<double>;
/// Somebody who knows what has failed.
struct Told {
  using Scalar = double;
  struct Params {
    explicit Params(const Setup<double>&) {}
  };
  Detection<double> known;

  Detection<double> start(const Vehicle<double>&, const Estimate<double>&) noexcept { return known; }
  Detection<double> step(const Vehicle<double>&, const Estimate<double>&, const Allocation<double>&) noexcept {
    return known;
  }
};

template <class Controller>
using Stack = FlightStack<PassthroughObserver<double>, Told, Controller, PseudoInverse<double>, NoNavigator<double>,
                          MagneticAxes<double>, Law>;

constexpr double dt = 4;

truth::Orbit orbit() {
  truth::OrbitElements k;
  k.semi_major_axis = 6871200;
  k.inclination = 1.7;
  k.raan = 0.7;
  k.argument_of_latitude = 0.35;
  k.earth_angle = 1.2;
  return truth::Orbit(k);
}

/// Three wheels on the axes and three torquers, nearly on them.
Mat3N<double> axes() {
  Mat3N<double> D(3, 6);
  D.leftCols<3>().setIdentity();
  D.col(3) = V(1, 0.02, 0).normalized();
  D.col(4) = V(0, 1, -0.03).normalized();
  D.col(5) = V(0.01, 0, 1).normalized();
  return D;
}

Setup<double> setup() {
  Setup<double> s;
  s.dt = dt;
  s.vehicle.J_B = V(6, 5, 4).asDiagonal();
  s.vehicle.D_B = axes();
  s.vehicle.D_B.rightCols<3>().setZero();
  s.vehicle.u_up = VecN<double>(Eigen::Vector<double, 6>(0.1, 0.1, 0.1, 15, 15, 15));
  s.vehicle.u_lo = -s.vehicle.u_up;
  s.vehicle.u_rate = VecN<double>::Constant(6, std::numeric_limits<double>::infinity());
  s.vehicle.wheels = Mask::all(3);
  s.vehicle.magnetorquers = Mask::all(6).without(Mask::all(3));
  s.vehicle.orbit_rate = orbit().mean_motion();
  return s;
}

/// A torque that stands still in N, in the axes of a vehicle that looks down.
truth::Disturbance inertial(const V& torque_N) {
  const truth::Orbit o = orbit();
  const double n = o.mean_motion();
  const V now = o.q_NO(0).conjugate() * torque_N, quarter = o.q_NO(full_turn / 4 / n).conjugate() * torque_N;
  const auto wave = [&](double at_start, double later) {  // at_start cos n t + later sin n t
    return truth::SineWave{0, std::hypot(at_start, later), n, std::atan2(at_start, later)};
  };
  return truth::PeriodicTorque{{wave(now[0], quarter[0]), now[1], wave(now[2], quarter[2])}};
}

constexpr double pointing = 0.35 * full_turn / 360;  // rad

struct Flight {
  std::array<double, 3> momentum{};  ///< N m s, largest in each orbit
  double error = 0;                  ///< rad, largest after 600 s
  double dipole = 0;                 ///< A m^2, largest
};

struct Case {
  double gain = 2;
  V torque_N{4e-5, 3e-5, -2e-5};
  V h_w = V::Zero();
  int dead = -1;  ///< torquer
  bool told = true;
};

/// Nadir hold for three orbits.
Flight nadir(const Case& c) {
  const Setup<double> s = setup();
  const truth::Orbit o = orbit();
  truth::PlantModel m;
  const double Js = 0.002;
  m.J_B = s.vehicle.J_B;
  m.D_B = axes();
  m.actuators = truth::Actuators::ideal(6);
  m.actuators.wheel_inertia.head<3>().setConstant(Js);
  m.magnetorquers = s.vehicle.magnetorquers;
  m.orbit = o;
  m.disturbances = {inertial(c.torque_N), truth::ResidualDipole{{0.1, -0.05, 0.08}}};
  if (c.dead >= 0) m.faults = {truth::Dead{{3 + c.dead}}};
  m.integrator = truth::Rk4{2};
  VecN<double> h = VecN<double>::Zero(6);
  h.head<3>() = c.h_w;
  truth::RigidPlant plant(m, {o.q_NO(0), o.omega_ON_O(0), h}, dt);

  typename Stack<MrpFeedback<double>>::Params p(s);
  p.controller.K = 4 * 0.05 * 0.05 * 6;
  p.controller.P = 1.6 * 0.05 * 6;
  Law::Params law(s);
  law.gain = c.gain;
  EXPECT_TRUE(Law::check(s, law).ok());
  Detection<double> known = Detection<double>::none(s.vehicle);
  if (c.dead >= 0 && c.told) known.failed.set(3 + c.dead);
  Stack<MrpFeedback<double>> stack(
      unchecked, s, PassthroughObserver<double>(unchecked, s, p.observer), Told{known},
      MrpFeedback<double>(unchecked, s, p.controller), PseudoInverse<double>(unchecked, s, p.allocator),
      NoNavigator<double>(unchecked, s, p.navigator), MagneticAxes<double>{axes()}, Law(unchecked, s, law));
  truth::Sensors sensors({}, 0, 0, false, s.dt, Mask::all(max_actuators), orbit());
  Flight out;
  for (Tick k = 0; plant.time() < 3 * o.period(); ++k) {
    const double t = plant.time();
    Reference<double> ref;
    ref.q_NR = o.q_NO(t);
    ref.omega_RN_R = o.omega_ON_O(t);
    plant.advance(stack.step(plant.measure(sensors), ref).u);
    const auto turn = static_cast<std::size_t>(std::min(2.0, t / o.period()));
    out.momentum[turn] = std::max(out.momentum[turn], plant.h_w().head<3>().norm());
    if (t > 600) out.error = std::max(out.error, plant.q_NB().angularDistance(o.q_NO(plant.time())));
    out.dipole = std::max(out.dipole, stack.last().u.tail<3>().cwiseAbs().maxCoeff());
  }
  return out;
}

TEST(Desaturation, WithoutItTheWheelsFillForEver) {
  const Flight f = nadir({.gain = 0});
  EXPECT_NEAR(f.momentum[0], 0.308, 0.01);
  EXPECT_NEAR(f.momentum[1] - f.momentum[0], 0.31, 0.01);
  EXPECT_NEAR(f.momentum[2] - f.momentum[1], 0.31, 0.01);
  EXPECT_LT(f.error, pointing);
  EXPECT_LT(f.dipole, 1e-3) << "the allocator leaves to the torquers next to nothing";
}

TEST(Desaturation, TakesMomentumOffAsQuicklyAsItsGainSays) {
  const Flight slow = nadir({.gain = 1.1e-3 / orbit().mean_motion()}), quick = nadir({.gain = 2});
  EXPECT_NEAR(slow.momentum[2], 0.113, 0.01);
  EXPECT_NEAR(quick.momentum[2], 0.065, 0.01);
  EXPECT_LT(quick.momentum[2], 1.05 * quick.momentum[1]);
  EXPECT_LT(quick.dipole, 5);
  EXPECT_LT(slow.error, pointing);
  EXPECT_LT(quick.error, pointing);
}

TEST(Desaturation, AnyTorquerMayDie) {
  const Case filled{.torque_N = {2e-5, 1e-5, -1.5e-5}, .h_w = {0.3, -0.2, 0.25}};
  const Flight healthy = nadir(filled);
  EXPECT_NEAR(healthy.momentum[0], 0.44, 0.01) << "at the start";
  EXPECT_NEAR(healthy.momentum[2], 0.032, 0.005);
  EXPECT_LT(healthy.error, pointing);
  const std::array<double, 3> expected{0.037, 0.080, 0.032};
  for (int dead = 0; dead < 3; ++dead) {
    Case c = filled;
    c.dead = dead;
    const Flight known = nadir(c);
    EXPECT_NEAR(known.momentum[2], expected[static_cast<std::size_t>(dead)], 0.01) << dead;
    EXPECT_LT(known.error, pointing) << dead;
    c.told = false;  // the wheels then cancel a torque that never comes
    const Flight unseen = nadir(c);
    EXPECT_NEAR(unseen.momentum[2], known.momentum[2], 0.02) << dead;
    EXPECT_LT(unseen.error, 3 * full_turn / 360) << dead;
  }
}

/// 5 deg/s of a 6U body, torquers of 0.2 A m^2 and no wheels.
TEST(Desaturation, ATumbleDiesOutOnTorquersAlone) {
  gyrostat::Setup<double> s = setup();
  s.vehicle.J_B = V(0.13, 0.1, 0.05).asDiagonal();
  s.vehicle.D_B = Mat3N<double>::Zero(3, 3);
  s.vehicle.u_up = VecN<double>::Constant(3, 0.2);
  s.vehicle.u_lo = -s.vehicle.u_up;
  s.vehicle.u_rate = VecN<double>::Constant(3, std::numeric_limits<double>::infinity());
  s.vehicle.wheels = {};
  s.vehicle.magnetorquers = Mask::all(3);
  s.dt = 1;
  const truth::Orbit o = orbit();
  truth::PlantModel m;
  m.J_B = s.vehicle.J_B;
  m.D_B = axes().rightCols<3>();
  m.actuators = truth::Actuators::ideal(3);
  m.magnetorquers = s.vehicle.magnetorquers;
  m.orbit = o;
  m.integrator = truth::Rk4{1};
  truth::RigidPlant plant(m, {Quat<double>::Identity(), {0.05, -0.06, 0.04}, {}}, s.dt);
  using Magnetic = Stack<OpenLoop<double>>;
  const Detection<double> known = Detection<double>::none(s.vehicle);
  typename Magnetic::Params p(s);
  Law::Params law(s);
  law.gain = 3.5;  // 2 (1 + sin of the orbit's inclination to the geomagnetic equator)
  law.momentum = Law::Momentum::total;
  Magnetic stack(unchecked, s, PassthroughObserver<double>(unchecked, s, p.observer), Told{known},
                 OpenLoop<double>(unchecked, s, p.controller), PseudoInverse<double>(unchecked, s, p.allocator),
                 NoNavigator<double>(unchecked, s, p.navigator), MagneticAxes<double>{m.D_B}, Law(unchecked, s, law));
  truth::Sensors sensors({}, 0, 0, false, s.dt, Mask::all(max_actuators), orbit());
  double momentum = 1, before = 1;
  for (Tick k = 0; plant.time() < 3 * o.period(); ++k) {
    plant.advance(stack.step(plant.measure(sensors), {}).u);
    momentum = (m.J_B * plant.omega_BN_B()).norm();
    ASSERT_LT(momentum, before * (1 + 1e-5)) << "never grows: at " << plant.time();
    before = momentum;
  }
  EXPECT_LT(plant.omega_BN_B().norm(), 2e-3);
}

TEST(Desaturation, SaysWhatItNeeds) {
  gyrostat::Setup<double> s = setup();
  Law::Params p(s);
  p.gain = 300;
  EXPECT_EQ(Law::check(s, p).code, Status<double>::Code::unstable);
  p.gain = 2;
  s.vehicle.orbit_rate = 0;
  EXPECT_STREQ(Law::check(s, p).quantity, "orbit_rate");
  s.vehicle.magnetorquers = {};
  EXPECT_STREQ(Law::check(s, p).quantity, "magnetorquers");
}

/// A field that is not measured for a while stands still in space, and the vehicle turns under it.
TEST(Desaturation, AFieldThatIsNotMeasuredStandsStillInSpace) {
  const gyrostat::Setup<double> s = setup();
  const Detection<double> known = Detection<double>::none(s.vehicle);
  typename Stack<OpenLoop<double>>::Params p(s);
  Law::Params law(s);
  Stack<OpenLoop<double>> stack(
      unchecked, s, PassthroughObserver<double>(unchecked, s, p.observer), Told{known},
      OpenLoop<double>(unchecked, s, p.controller), PseudoInverse<double>(unchecked, s, p.allocator),
      NoNavigator<double>(unchecked, s, p.navigator), MagneticAxes<double>{axes()}, Law(unchecked, s, law));
  const V field_N{2e-5, -1e-5, 3e-5};
  Measurement<double> y;
  y.h_w = VecN<double>::Constant(6, 0);
  y.h_w.head<3>() << 0.1, -0.05, 0.02;
  y.omega_BN_B = {0, 0, 0.01};
  for (Tick k = 0; k < 20; ++k) {
    y.tick = k;
    y.q_NB = Quat<double>(Eigen::AngleAxisd(0.01 * dt * static_cast<double>(k), V::UnitZ()));
    y.field_valid = k < 5;
    y.field_B = y.field_valid ? V(y.q_NB.conjugate() * field_N) : V(1e3, std::nan(""), 0);
    const VecN<double> u = stack.step(y, {}).u;
    const V now = y.q_NB.conjugate() * field_N;
    EXPECT_LT((stack.estimate().field_B - now).norm(), 1e-18) << k;
    const V expected = 2 * s.vehicle.orbit_rate / now.squaredNorm() * V(y.h_w.head<3>()).cross(now);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(u[3 + i], axes().col(3 + i).dot(expected), 1e-6) << k;
  }
}

}  // namespace
}  // namespace gyrostat::host::test_desaturation
