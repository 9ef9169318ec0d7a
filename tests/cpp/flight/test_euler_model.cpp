// SPDX-License-Identifier: MIT
// The printed Euler-angle model against its formula, derivatives taken numerically, and a body's reference in Euler angles.
#include "gyrostat/flight/parts/euler_model.hpp"

#include <gtest/gtest.h>

#include "../random.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_euler_model {
namespace {

gyrostat::Setup<double> printed() {
  auto setup = vehicle_with<double>(Vec3<double>(200, 400, 270).asDiagonal(), Mat3<double>::Identity(), 1, 0.01);
  setup.vehicle.coordinates = Coordinates::euler_angles;
  setup.vehicle.orbit_rate = 0.4;
  return setup;
}

/// Second column of C_BO: the orbit normal in body axes, less its sign.
Vec3<double> column(const Vec3<double>& a) {
  const double sf = std::sin(a[0]), cf = std::cos(a[0]), st = std::sin(a[1]), ct = std::cos(a[1]);
  const double sp = std::sin(a[2]), cp = std::cos(a[2]);
  return {-sp * ct, cf * cp - sf * st * sp, cf * st * sp + sf * cp};
}

TEST(EulerModel, IsThePrintedOneWithItsDerivativesTakenNumerically) {
  const auto setup = printed();
  const double w0 = setup.vehicle.orbit_rate, h = 1e-5;
  const Vec3<double> J = setup.vehicle.J_B.diagonal();
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3<double> a = random.vector<double>(1.4), rates = random.vector<double>(1);
    const Vec3<double> w = rates + w0 * column(a);
    const Vec3<double> column_rate = (column(a + h * rates) - column(a - h * rates)) / (2 * h);
    const Vec3<double> r(-std::sin(a[1]), std::sin(a[0]) * std::cos(a[1]), std::cos(a[0]) * std::cos(a[1]));
    const Vec3<double> expected((J[1] - J[2]) / J[0] * (w[1] * w[2] - 3 * w0 * w0 * r[1] * r[2]) - w0 * column_rate[0],
                                (J[2] - J[0]) / J[1] * (w[2] * w[0] - 3 * w0 * w0 * r[2] * r[0]) - w0 * column_rate[1],
                                (J[0] - J[1]) / J[2] * (w[0] * w[1] - 3 * w0 * w0 * r[0] * r[1]) - w0 * column_rate[2]);
    // Central differences: h^2 times a third derivative of order one, and rounding over h.
    EXPECT_LT((euler_model_acceleration(setup.vehicle, a, rates) - expected).norm(), 1e-9) << trial;
    const Vec3<double> torque_B = known_torque<double>(setup.vehicle, a, rates, Vec3<double>::Zero());
    EXPECT_LT((torque_B - J.cwiseProduct(expected)).norm(), 1e-6);
  }
}

TEST(EulerModel, OfABodyIsTheGyroscopicTorqueWithItsWheels) {
  const auto setup = ftc_4rw<double>();
  VecN<double> h_w(4);
  h_w << 1, -2, 3, 4;
  const Vec3<double> w(0.1, -0.2, 0.3);
  const Vec3<double> momentum = setup.vehicle.J_B * w + setup.vehicle.D_B * h_w;
  const Vec3<double> expected(-w[1] * momentum[2] + w[2] * momentum[1], -w[2] * momentum[0] + w[0] * momentum[2],
                              -w[0] * momentum[1] + w[1] * momentum[0]);
  EXPECT_LT(
      (known_torque<double>(setup.vehicle, Vec3<double>::Zero(), w, torque<double>(setup.vehicle.D_B, h_w)) - expected)
          .norm(),
      1e-14);
}

TEST(EulerModel, AReferenceHasTheRatesAndAccelerationsOfItsAngles) {
  Random random(2);
  constexpr double h = 1e-4;  // second differences: h^2 and rounding over h^2, both some 1e-7
  for (int trial = 0; trial < 50; ++trial) {
    Reference<double> r;
    r.q_NR = quat_from_euler(random.vector<double>(1.2));
    r.omega_RN_R = random.vector<double>(0.5);
    r.omegadot_RN_R = random.vector<double>(0.2);
    const Reference<double> filled = with_euler(r);
    const auto angles_at = [&](double t) {  // to third order in t, which is odd and drops out of the second difference
      return Vec3<double>(euler(r.q_NR * quat_exp<double>(t * r.omega_RN_R + t * t / 2 * r.omegadot_RN_R)));
    };
    const Vec3<double> before = angles_at(-h), now = angles_at(0), after = angles_at(h);
    EXPECT_EQ(filled.euler.angles, now);
    EXPECT_LT((filled.euler.rates - (after - before) / (2 * h)).norm(), 1e-6) << trial;
    EXPECT_LT((filled.euler_accelerations - (after - 2 * now + before) / (h * h)).norm(), 1e-4) << trial;
  }
}

TEST(EulerModel, AReferenceAtThePoleKeepsTheRatesThatItHad) {
  Reference<double> r;
  r.q_NR = quat_from_euler<double>({0.3, 1.57079632679489662, 0});
  r.omega_RN_R = {0.1, 0.2, 0.3};
  r.euler.rates = {1, 2, 3};
  r.euler_accelerations = {4, 5, 6};
  const Reference<double> filled = with_euler(r);
  EXPECT_EQ(filled.euler.rates, Vec3<double>(1, 2, 3));
  EXPECT_EQ(filled.euler_accelerations, Vec3<double>(4, 5, 6));
}

TEST(EulerModel, RefusesProductsOfInertiaAndWheels) {
  auto setup = printed();
  EXPECT_TRUE(fits_euler_model(setup).ok());
  setup.vehicle.wheels.set(1);
  EXPECT_EQ(fits_euler_model(setup).code, Status<double>::Code::wrong_chart);
  setup.vehicle.coordinates = Coordinates::body;
  EXPECT_TRUE(fits_euler_model(setup).ok());
  setup = printed();
  setup.vehicle.J_B(2, 0) = setup.vehicle.J_B(0, 2) = 1e-9;
  EXPECT_EQ(fits_euler_model(setup).code, Status<double>::Code::wrong_chart);
}

}  // namespace
}  // namespace gyrostat::test::test_euler_model
