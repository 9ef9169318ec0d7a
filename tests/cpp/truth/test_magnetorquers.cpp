// SPDX-License-Identifier: MIT
// Magnetorquers and the torques of an orbit: states of an independent computation in extended precision (rate form, torques as
// printed), and what must hold of each torque.
#include <gtest/gtest.h>

#include <cmath>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/truth/rigid_plant.hpp"
#include "support.hpp"

namespace gyrostat::truth::test_magnetorquers {
namespace {

using V = Vec3<double>;

constexpr double dt = 4;

VecN<double> command(Tick k, int n) {
  VecN<double> u = VecN<double>::Zero(n);
  for (int i = 0; i < 3; ++i) u[i] = 10 * std::sin(0.01 * dt * static_cast<double>(k) + i);
  return u;
}

/// Three torquers, not quite at right angles, a residual dipole and the gravity gradient.
PlantModel torqued(const Integrator& integrator) {
  PlantModel m;
  m.J_B << 6, 0.1, -0.2, 0.1, 5, 0.15, -0.2, 0.15, 4;
  m.D_B.resize(3, 3);
  m.D_B.col(0) = V(1, 0.02, 0).normalized();
  m.D_B.col(1) = V(0, 1, -0.03).normalized();
  m.D_B.col(2) = V(0.01, 0, 1).normalized();
  m.actuators = Actuators::ideal(3);
  m.magnetorquers = Mask::all(3);
  m.orbit.emplace(test::low_orbit());
  m.disturbances = {GravityGradient{}, ResidualDipole{{0.1, -0.05, 0.08}}};
  m.integrator = integrator;
  return m;
}

const InitialState start{{0.8, 0.2, -0.4, 0.4}, {0.002, -0.001, 0.0015}, {}};

struct End {
  Quat<double> q_NB;
  V omega_BN_B;
};

const End end_torqued{
    {-4.1730928957161304e-01, 8.0038626882027776e-01, 4.2515189234359242e-01, -6.6937627369455583e-02},
    {4.8410333521084590e-03, 6.0327423676525164e-03, -4.3262155479958770e-03}};

double attitude_off(const RigidPlant& p, const End& end) { return (p.q_NB().coeffs() - end.q_NB.coeffs()).norm(); }
double rate_off(const RigidPlant& p, const End& end) { return (p.omega_BN_B() - end.omega_BN_B).norm(); }

RigidPlant flown(const PlantModel& model, const InitialState& from, Tick samples) {
  RigidPlant plant(model, from, dt);
  const int n = static_cast<int>(model.D_B.cols());
  for (Tick k = 0; k < samples; ++k) plant.advance(command(k, n));
  return plant;
}

TEST(Magnetorquers, StatesOfAnIndependentComputation) {
  EXPECT_LT(attitude_off(flown(torqued(Rk4{1}), start, 300), end_torqued), 1.4e-7);
  const RigidPlant rk4 = flown(torqued(Rk4{4}), start, 300);
  EXPECT_LT(attitude_off(rk4, end_torqued), 9e-10);
  EXPECT_LT(rate_off(rk4, end_torqued), 2e-11);
  const RigidPlant precise = flown(torqued(Auto{.rtol = 1e-12}), start, 300);
  EXPECT_LT(attitude_off(precise, end_torqued), 1e-10);
}

TEST(Magnetorquers, CvodeKeepsItsHistoryOverCommands) {
  const RigidPlant cvode = flown(torqued(Cvode{.rtol = 1e-9, .atol = 1e-12}), start, 300);
  EXPECT_LT(attitude_off(cvode, end_torqued), 1e-7);
  EXPECT_EQ(cvode.statistics().restarts, 1u) << "the start alone";
  EXPECT_LT(attitude_off(flown(torqued(Cvode{.rtol = 1e-12, .atol = 1e-15}), start, 300), end_torqued), 5e-10);
}

/// A dipole held for a day of one sign: its impulse is taken up before it drowns the body's momentum.
TEST(Magnetorquers, ADipoleHeldForLongStaysExact) {
  const auto fly = [](const Integrator& integrator) {
    PlantModel m = torqued(integrator);
    m.disturbances.clear();
    RigidPlant plant(m, {start.q_NB, {1e-3, 0, 0}, {}}, 60);
    const VecN<double> held = V(0.3, 0.1, -0.2);
    for (int k = 0; k < 1440; ++k) plant.advance(held);
    return plant;
  };
  const RigidPlant a = fly(Cvode{.rtol = 1e-12, .atol = 1e-15}), b = fly(Auto{.rtol = 1e-12});
  EXPECT_LT(a.q_NB().angularDistance(b.q_NB()), 1e-4);
  EXPECT_LT(a.statistics().restarts, 100u);
}

/// And a wheel, faults of torquers, and eight plates in thin air and sunlight, into the shadow.
PlantModel plated(const Integrator& integrator) {
  PlantModel m = torqued(integrator);
  OrbitElements k = test::low_orbit();
  k.argument_of_latitude = 2.9;
  k.sun_N = {0.48, -0.6, 0.64};
  m.orbit.emplace(k);
  m.J_B -= 0.002 * V::UnitY() * V::UnitY().transpose();
  m.D_B.conservativeResize(3, 4);
  m.D_B.col(3) = V::UnitY();
  m.actuators = Actuators::ideal(4);
  m.actuators.wheel_inertia[3] = 0.002;
  m.faults = {LossOfEffectiveness{{0, 101.3}, 0.5}, StuckOutput{{1, 203.7}, 5.0}, Dead{{2, 400}}};
  Plates plates;
  plates.density = 2e-12;
  plates.area = {0.5, 0.5, 0.6, 0.6, 0.4, 0.4, 1.2, 1.2};
  plates.normal_B = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0},     {0, -1, 0},
                     {0, 0, 1}, {0, 0, -1}, {0, 0.6, 0.8}, {0, -0.6, -0.8}};
  plates.centre_B = {{0.4, 0.05, 0}, {-0.4, 0.05, 0}, {0, 0.45, 0.02}, {0, -0.35, 0.02},
                     {0.03, 0, 0.5}, {0.03, 0, -0.5}, {0, 1.5, 0.1},   {0, 1.5, 0.1}};
  plates.specular = {0.3, 0.3, 0.3, 0.3, 0.2, 0.2, 0.1, 0.1};
  plates.diffuse = {0.4, 0.4, 0.4, 0.4, 0.5, 0.5, 0.1, 0.1};
  m.disturbances.emplace_back(plates);
  return m;
}

const InitialState with_wheel{start.q_NB, start.omega_BN_B, VecN<double>(Eigen::Vector4d(0, 0, 0, 0.4))};

const End end_plated{
    {-8.7946552814068784e-01, -2.1622055561461118e-02, -3.7630347675773356e-01, -2.9063476203916139e-01},
    {-1.6507090600793342e-03, -2.5620399088089132e-03, 3.1074622944213380e-03}};

TEST(Magnetorquers, FaultsPlatesAndShadow) {
  EXPECT_LT(attitude_off(flown(plated(Rk4{1}), with_wheel, 225), end_plated), 2.4e-4);
  EXPECT_LT(attitude_off(flown(plated(Rk4{4}), with_wheel, 225), end_plated), 1.1e-6);
  EXPECT_LT(attitude_off(flown(plated(Rk4{20}), with_wheel, 225), end_plated), 1.4e-8);
  const RigidPlant cvode = flown(plated(Cvode{.rtol = 1e-10, .atol = 1e-13}), with_wheel, 225);
  EXPECT_LT(attitude_off(cvode, end_plated), 1e-7);
  EXPECT_LT(rate_off(cvode, end_plated), 1e-9);
  EXPECT_EQ(cvode.statistics().restarts, 2u) << "start and shadow";
}

/// The torque of the sample's delivered dipoles, and its acceleration.
TEST(Magnetorquers, TorqueIsAcrossTheField) {
  for (const Integrator& integrator : {Integrator(Rk4{2}), Integrator(Cvode{})}) {
    PlantModel m = torqued(integrator);
    m.disturbances.clear();
    const RigidPlant plant = flown(m, start, 57);
    const TruthSample s = plant.sample();
    const V B = s.q_NB.conjugate() * m.orbit->field(s.t).B_N, w = s.omega_BN_B;
    const V torque = m.J_B * s.omegadot_BN_B + w.cross(m.J_B * w);
    EXPECT_GT(torque.norm(), 1e-5);
    EXPECT_NEAR(torque.dot(B) / (torque.norm() * B.norm()), 0, 1e-9);
    V dipole = V::Zero();
    for (int i = 0; i < 3; ++i) dipole += s.delivered[i] * m.D_B.col(i);
    EXPECT_LT((torque - dipole.cross(B)).norm(), 1e-12);
  }
}

TEST(Magnetorquers, BothSignsOfTheQuaternionAreOneAttitude) {
  InitialState other = start;
  other.q_NB.coeffs() = -start.q_NB.coeffs();
  const RigidPlant a = flown(torqued(Rk4{2}), start, 60), b = flown(torqued(Rk4{2}), other, 60);
  EXPECT_LT((a.q_NB().coeffs() + b.q_NB().coeffs()).norm(), 1e-14);
  EXPECT_LT((a.omega_BN_B() - b.omega_BN_B()).norm(), 1e-16);
}

TEST(Magnetorquers, NeedAField) {
  PlantModel m = torqued(Rk4{});
  m.orbit.reset();
  m.disturbances.clear();
  EXPECT_THROW(RigidPlant(m, start, dt), std::invalid_argument);
}

/// Turns x to a direction that is not opposite; Eigen's own has a singular value decomposition compiled for that.
Quat<double> from_x_to(const V& direction) {
  const V d = direction.normalized(), axis = V::UnitX().cross(d);
  return Quat<double>(1 + d.x(), axis.x(), axis.y(), axis.z()).normalized();
}

V torque_at(const Disturbance& d, double t, const Quat<double>& q, const Mat3<double>& J, const OrbitElements& k) {
  Disturbances all({d}, J, 0, Orbit(k));
  all.enter(t);
  return all.torque_B(t, q, V::Zero());
}

TEST(TorquesOfAnOrbit, GravityGradientVanishesForASphereAndAgreesWithTheOtherConvention) {
  const Quat<double> q = Quat<double>(0.8, 0.2, -0.4, 0.4);
  const Mat3<double> J = torqued(Rk4{}).J_B;
  EXPECT_LT(torque_at(GravityGradient{}, 777, q, 5 * Mat3<double>::Identity(), test::low_orbit()).norm(), 1e-21);
  const Orbit o(test::low_orbit());
  Disturbances plain({GravityGradient{}}, J, o.mean_motion());
  plain.enter(0);
  for (const double t : {0.0, 777.0, 5000.0}) {
    const Quat<double> q_OB = o.q_NO(0).conjugate() * q;  // N was O at the start there
    const V expected = plain.torque_B(t, q_OB, V::Zero());
    EXPECT_LT((torque_at(GravityGradient{}, t, q, J, test::low_orbit()) - expected).norm(), 1e-12 * expected.norm());
  }
  OrbitElements k = test::low_orbit();
  k.semi_major_axis = 12e6;
  k.eccentricity = 0.4;
  const V r = q.conjugate() * Orbit(k).r_N(777);
  EXPECT_LT(
      (torque_at(GravityGradient{}, 777, q, J, k) - 3 * earth::mu / std::pow(r.norm(), 5) * r.cross(J * r)).norm(),
      1e-18);
}

TEST(TorquesOfAnOrbit, NothingFromThePlatesInTheDarkWithoutAir) {
  Plates plate;
  plate.area = {1};
  plate.normal_B = {{1, 0, 0}};
  plate.centre_B = {{0, 1, 0}};
  OrbitElements k = test::low_orbit();
  const Mat3<double> J = Mat3<double>::Identity();
  const Orbit o(k);
  double t = 0;
  while (!o.dark(t)) t += 10;
  const Quat<double> to_the_sun = from_x_to(o.sun_N());
  EXPECT_EQ(torque_at(plate, t, to_the_sun, J, k), V::Zero());
  while (o.dark(t)) t += 10;
  // Black: all light is taken up, along the sun's direction; the plate is a metre out along y.
  EXPECT_LT((torque_at(plate, t, to_the_sun, J, k) - V(0, 0, 4.56e-6)).norm(), 1e-17);
  plate.specular = {1};  // a mirror gives it back
  EXPECT_LT((torque_at(plate, t, to_the_sun, J, k) - V(0, 0, 2 * 4.56e-6)).norm(), 1e-17);
}

TEST(TorquesOfAnOrbit, AirFlowsAgainstTheMotionAndThinsWithHeight) {
  Plates plate;
  plate.area = {2};
  plate.normal_B = {{1, 0, 0}};
  plate.centre_B = {{0, 0, 1}};
  plate.solar_pressure = 0;
  plate.density = 1e-12;
  OrbitElements k = test::low_orbit();
  k.inclination = 0;  // the air turns along
  const Orbit o(k);
  const V v = o.at(0).v_N;
  const Quat<double> ahead = from_x_to(v);
  const double speed = v.norm() - earth::rate * k.semi_major_axis, force = 0.5 * 1e-12 * speed * speed * 2.2 * 2;
  const Mat3<double> J = Mat3<double>::Identity();
  EXPECT_LT((torque_at(plate, 0, ahead, J, k) - V(0, -force, 0)).norm(), 1e-12 * force);
  plate.scale_height = 60e3;
  plate.altitude = k.semi_major_axis - earth::radius - 60e3;
  EXPECT_LT((torque_at(plate, 0, ahead, J, k) - V(0, -force / std::exp(1.0), 0)).norm(), 1e-12 * force);
}

TEST(TorquesOfAnOrbit, PlatesThatCannotBe) {
  Plates p;
  EXPECT_EQ(p.check(), "area is missing: one number a plate");
  p.area = {1};
  EXPECT_EQ(p.check(), "normal_B and centre_B must have a row a plate");
  p.normal_B = {{1, 1, 0}};
  p.centre_B = {{0, 0, 0}};
  EXPECT_EQ(p.check(), "plate 0: normal_B must be a unit vector");
  p.normal_B = {{1, 0, 0}};
  p.specular = {0.7};
  p.diffuse = {0.4};
  EXPECT_EQ(p.check(), "plate 0: specular and diffuse are more than all light together");
  EXPECT_THROW(Disturbances({ResidualDipole{}}, Mat3<double>::Identity(), 1e-3), std::invalid_argument);
}

}  // namespace
}  // namespace gyrostat::truth::test_magnetorquers
