// SPDX-License-Identifier: MIT
/// @file  The vehicle, and the two end states, that the tests and the benchmark of the truth layer share.
///
/// End states after 200 s: DOP853 on quaternions at rtol 2.3e-14; Basilisk's RKF78 at 1e-13 agrees to 1.3e-14 in MRP and
/// rates and to 3.2e-13 in wheel speed.
#pragma once
#include <cmath>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/truth/rigid_plant.hpp"

namespace gyrostat::truth::test {

/// A circle 500 km up, of the states of test_magnetorquers.cpp.
inline OrbitElements low_orbit() {
  OrbitElements k;
  k.semi_major_axis = 6871200;
  k.inclination = 1.7;
  k.raan = 0.7;
  k.argument_of_latitude = 0.35;
  k.earth_angle = 1.2;
  return k;
}

inline Mat3<double> total_inertia() {
  Mat3<double> J;
  J << 20, 0, 0.9, 0, 17, 0, 0.9, 0, 15;
  return J;
}

/// Spin axes (1,1,1), (1,-1,1), (-1,-1,1), (-1,1,1), each / sqrt 3.
inline Mat3N<double> pyramid() {
  Mat3N<double> D(3, 4);
  D << 1, 1, -1, -1, 1, -1, -1, 1, 1, 1, 1, 1;
  return D / std::sqrt(3.0);
}

inline VecN<double> vec(std::initializer_list<double> values) {
  VecN<double> v(static_cast<Eigen::Index>(values.size()));
  Eigen::Index i = 0;
  for (const double x : values) v[i++] = x;
  return v;
}

/// MRP of the short way round.
inline Vec3<double> small_mrp(const Quat<double>& q) { return mrp(short_way(q)); }

inline constexpr double wheel_inertia = 0.05;  // kg m^2

/// Four torquers on the pyramid, no limits, no faults.
inline PlantModel torquers(const Integrator& integrator = Cvode{}) {
  PlantModel m;
  m.J_B = total_inertia();
  m.D_B = pyramid();
  m.actuators = Actuators::ideal(4);
  m.integrator = integrator;
  return m;
}

/// Four wheels on the pyramid.
inline PlantModel wheels(const Integrator& integrator = Cvode{}) {
  PlantModel m = torquers(integrator);
  m.J_B -= wheel_inertia * m.D_B * m.D_B.transpose();
  m.actuators.wheel_inertia.setConstant(wheel_inertia);
  return m;
}

/// Momentum of wheels at given speeds relative to the body (rad/s).
inline VecN<double> wheel_momentum(const Mat3N<double>& D_B, const VecN<double>& speed,
                                   const Vec3<double>& omega_BN_B) {
  return wheel_inertia * (speed + project(D_B, omega_BN_B));
}
inline VecN<double> wheel_speed(const Mat3N<double>& D_B, const VecN<double>& h_w, const Vec3<double>& omega_BN_B) {
  return h_w / wheel_inertia - project(D_B, omega_BN_B);
}

inline const Vec3<double> sigma_0{0.1, 0.2, -0.3};

// ---- end state 1: torque-free --------------------------------------------------------------------------------------
inline InitialState free_start() { return {quat_from_mrp(sigma_0), {0.1, -0.2, 0.3}, {}}; }
inline const Vec3<double> free_sigma{0.2543330836114404, 0.05006568504300006, 0.2542987716302665};
inline const Vec3<double> free_omega{-0.23918163157841227, 0.06040933194292894, 0.28279012513333446};

// ---- end state 2: four wheels, motor torque reversed at 100 s, constant external torque -----------------------------
inline InitialState driven_start() {
  const Vec3<double> omega{0.01, -0.02, 0.03};
  return {quat_from_mrp(sigma_0), omega, wheel_momentum(pyramid(), vec({100, -50, 25, 10}), omega)};
}
inline PlantModel driven_model(const Integrator& integrator) {
  PlantModel m = wheels(integrator);
  m.disturbances = {ConstantTorque{{1e-3, -2e-3, 1.5e-3}}};
  return m;
}
/// Torque on the body: the opposite of the motor torque on the wheels.
inline VecN<double> driven_command(bool first_half) {
  return first_half ? vec({-0.010, 0.020, -0.015, -0.005}) : vec({0.012, -0.018, 0.005, 0.010});
}
inline const Vec3<double> driven_sigma{-0.043889397089276756, 0.06829810485496256, -0.4645769176195293};
inline const Vec3<double> driven_omega{0.014068629674196823, 0.04211433270586304, -0.007133655165809838};
inline const VecN<double> driven_speed =
    vec({95.98322837465994, -53.945048171923276, 45.05964987695179, -0.012073576464673202});

/// Runs end state 2 at a sample period; the command is reversed at the sample of 100 s.
inline RigidPlant run_driven(const Integrator& integrator, double dt) {
  RigidPlant plant(driven_model(integrator), driven_start(), dt);
  const auto half = static_cast<Tick>(std::llround(100 / dt));
  for (Tick k = 0; k < 2 * half; ++k) plant.advance(driven_command(k < half));
  return plant;
}

}  // namespace gyrostat::truth::test
