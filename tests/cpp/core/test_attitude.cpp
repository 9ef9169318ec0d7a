// SPDX-License-Identifier: MIT
#include "gyrostat/core/attitude.hpp"

#include <gtest/gtest.h>

#include "../random.hpp"

namespace gyrostat::test {
namespace {

constexpr int trials = 200;

template <class S>
class Attitude : public testing::Test {
 protected:
  static constexpr S eps = Eigen::NumTraits<S>::epsilon();
  // A few tens of operations on numbers of order one.
  static constexpr S rounding = S(32) * eps;
  Random random{20180613};

  static S distance(const Quat<S>& a, const Quat<S>& b) {
    return std::min((a.coeffs() - b.coeffs()).norm(), (a.coeffs() + b.coeffs()).norm());
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Attitude, Scalars);

TYPED_TEST(Attitude, CrossMatrixIsTheCrossProduct) {
  using S = TypeParam;
  const Vec3<S> a{S(1), S(2), S(3)}, b{S(-4), S(5), S(7)};
  EXPECT_EQ(Vec3<S>(cross_matrix(a) * b), a.cross(b));
}

TYPED_TEST(Attitude, DirectionCosinesTurnNumbersFromNToB) {
  using S = TypeParam;
  const S quarter = S(1.57079632679489661923);
  const Mat3<S> C_BN = dcm(quat_exp<S>({S(0), S(0), quarter}));  // B turned by +90 deg about z: x_N lies along -y_B
  const Vec3<S> x_B = C_BN * Vec3<S>::UnitX();
  EXPECT_LT((x_B + Vec3<S>::UnitY()).norm(), this->rounding);
}

TYPED_TEST(Attitude, DirectionCosinesFollowTheBodyRate) {  // C_BN' = -[omega x] C_BN
  using S = TypeParam;
  for (int trial = 0; trial < trials; ++trial) {
    const Quat<S> q = this->random.template attitude<S>();
    const Vec3<S> omega = this->random.template vector<S>(1);
    const Quat<S> rate = quat_rate(q, omega);
    // dcm is a polynomial of degree two in q: its central difference is exact for every step.
    const Mat3<S> Cdot = (dcm(Quat<S>(q.coeffs() + rate.coeffs())) - dcm(Quat<S>(q.coeffs() - rate.coeffs()))) / S(2);
    EXPECT_LT((Cdot + cross_matrix(omega) * dcm(q)).norm(), this->rounding);
  }
}

TYPED_TEST(Attitude, MrpFollowsTheBodyRate) {  // sigma' = G(sigma) omega
  using S = TypeParam;
  for (int trial = 0; trial < trials; ++trial) {
    const Quat<S> q = short_way(this->random.template attitude<S>());
    const Vec3<S> omega = this->random.template vector<S>(1);
    const Quat<S> rate = quat_rate(q, omega);
    const S k = S(1) + q.w();
    const Vec3<S> sigmadot = rate.vec() / k - q.vec() * rate.w() / (k * k);  // quotient rule
    EXPECT_LT((mrp_rate_matrix(mrp(q)) * omega - sigmadot).norm(), this->rounding);
  }
}

TYPED_TEST(Attitude, MrpRateMatrixIdentities) {
  using S = TypeParam;
  for (int trial = 0; trial < trials; ++trial) {
    const Vec3<S> sigma = this->random.template vector<S>(1);
    const Mat3<S> G = mrp_rate_matrix(sigma);
    const S k = (S(1) + sigma.squaredNorm()) / S(4);
    EXPECT_LT((sigma.transpose() * G - k * sigma.transpose()).norm(), this->rounding);
    EXPECT_LT((G.transpose() * G - k * k * Mat3<S>::Identity()).norm(), this->rounding);
    EXPECT_LT((mrp_rate_matrix_inverse(sigma) * G - Mat3<S>::Identity()).norm(), this->rounding);
    const Vec3<S> beyond = this->random.template vector<S>(S(1.73));  // |sigma| up to 3
    EXPECT_LT((mrp_rate_matrix_inverse(beyond) * mrp_rate_matrix(beyond) - Mat3<S>::Identity()).norm(), this->rounding);
  }
}

TYPED_TEST(Attitude, MrpRateMatrixRateIsItsDerivative) {
  using S = TypeParam;
  for (int trial = 0; trial < trials; ++trial) {
    const Vec3<S> sigma = this->random.template vector<S>(1), sigmadot = this->random.template vector<S>(1);
    // G is quadratic: central difference exact for every step.
    const Mat3<S> difference = (mrp_rate_matrix<S>(sigma + sigmadot) - mrp_rate_matrix<S>(sigma - sigmadot)) / S(2);
    EXPECT_LT((mrp_rate_matrix_rate(sigma, sigmadot) - difference).norm(), this->rounding);
  }
}

TYPED_TEST(Attitude, DirectionCosinesOfMrpAgreeWithTheirOwnFormula) {
  using S = TypeParam;
  for (int trial = 0; trial < trials; ++trial) {
    const Vec3<S> sigma = this->random.template vector<S>(1);  // on either side of |sigma| = 1
    const Mat3<S> X = cross_matrix(sigma);
    const S k = S(1) + sigma.squaredNorm();
    const Mat3<S> C = Mat3<S>::Identity() + (S(8) * X * X - S(4) * (S(2) - k) * X) / (k * k);
    EXPECT_LT((dcm(quat_from_mrp(sigma)) - C).norm(), this->rounding);
  }
}

TYPED_TEST(Attitude, MrpRoundTripKeepsTheSet) {
  using S = TypeParam;
  for (int trial = 0; trial < trials; ++trial) {
    const Vec3<S> sigma = this->random.template vector<S>(S(1.2));
    const Quat<S> q = quat_from_mrp(sigma);
    EXPECT_EQ(q.w() < S(0), sigma.norm() > S(1));
    // 1 + w loses digits as sigma grows: (1 + sigma^2)^2 / 2 of them, at most 15 here.
    EXPECT_LT((mrp(q) - sigma).norm(), S(16) * this->rounding);
  }
}

TYPED_TEST(Attitude, ShadowSetIsTheSameAttitude) {
  using S = TypeParam;
  for (int trial = 0; trial < trials; ++trial) {
    const Vec3<S> sigma = this->random.template vector<S>(1);
    const Vec3<S> shadow = mrp_shadow(sigma);
    EXPECT_LT(this->distance(quat_from_mrp(sigma), quat_from_mrp(shadow)), this->rounding);
    EXPECT_LE(std::min(sigma.norm(), shadow.norm()), S(1) + this->rounding);
  }
}

TYPED_TEST(Attitude, ExponentialAndLogarithmAreInverse) {
  using S = TypeParam;
  for (const S size : {S(0), S(1e-30), S(1e-12), S(1e-7), S(1e-4), S(1e-3), S(1), S(1.8)}) {
    const Vec3<S> phi = size * Vec3<S>(S(0.6), S(-0.8), S(1.2));  // |phi| = 1.56 size, below pi
    EXPECT_LE((quat_log(quat_exp(phi)) - phi).norm(), this->rounding * phi.norm()) << size;
  }
}

TYPED_TEST(Attitude, HalfATurnIsStillExact) {
  using S = TypeParam;
  const S pi = S(3.14159265358979323846);
  const Vec3<S> axis = Vec3<S>(S(2), S(-1), S(2)) / S(3);
  const Quat<S> q = quat_exp<S>(pi * axis);
  EXPECT_NEAR(rotation_angle(q), pi, this->rounding);
  const Vec3<S> back = quat_log(q);
  EXPECT_LT(std::min((back - pi * axis).norm(), (back + pi * axis).norm()), this->rounding);
  EXPECT_LT((mrp(short_way(q)).cwiseAbs() - axis.cwiseAbs()).norm(), this->rounding);  // |sigma| = 1
}

TYPED_TEST(Attitude, RotationAngleIsAccurateNearZero) {
  using S = TypeParam;
  const S tiny = S(1e-10);  // acos(w) would say 0
  EXPECT_NEAR(rotation_angle(quat_exp<S>({tiny, S(0), S(0)})), tiny, this->rounding * tiny);
}

TYPED_TEST(Attitude, ErrorVanishesOnTheReferenceAndCancelsFrames) {
  using S = TypeParam;
  for (int trial = 0; trial < trials; ++trial) {
    const Quat<S> q_NR = this->random.template attitude<S>(), q_RB = this->random.template attitude<S>();
    const Vec3<S> omega_RN_R = this->random.template vector<S>(1), omega_BR_B = this->random.template vector<S>(1);
    const Vec3<S> omega_BN_B = omega_BR_B + dcm(q_RB) * omega_RN_R;  // C_BR
    const AttitudeError<S> error = attitude_error<S>(q_NR * q_RB, omega_BN_B, q_NR, omega_RN_R);
    EXPECT_LT(this->distance(error.q_RB, q_RB), this->rounding);
    EXPECT_LT((error.omega_BR_B - omega_BR_B).norm(), this->rounding);
    EXPECT_LT((error.omega_RN_B - dcm(q_RB) * omega_RN_R).norm(), this->rounding);
  }
}

TYPED_TEST(Attitude, EulerAnglesAreRollPitchYawInTurn) {
  using S = TypeParam;
  for (int trial = 0; trial < trials; ++trial) {
    const Vec3<S> angles = this->random.template vector<S>(1.5);
    const Quat<S> q = quat_exp<S>({S(0), S(0), angles[2]}) * quat_exp<S>({S(0), angles[1], S(0)}) *
                      quat_exp<S>({angles[0], S(0), S(0)});
    EXPECT_LT(this->distance(quat_from_euler(angles), q), this->rounding);
    // Roll and yaw lose digits with 1 / cos(pitch), at most 14 here.
    EXPECT_LT((euler(q) - angles).norm(), S(16) * this->rounding);
  }
}

TYPED_TEST(Attitude, GimbalLockStillGivesTheAttitudeBack) {
  using S = TypeParam;
  const S quarter = S(1.57079632679489661923);
  for (const S pitch : {quarter, -quarter}) {
    for (int trial = 0; trial < trials; ++trial) {
      const S roll = static_cast<S>(this->random.uniform(-3, 3)), yaw = static_cast<S>(this->random.uniform(-3, 3));
      const Quat<S> q = quat_from_euler<S>({roll, pitch, yaw});
      const Vec3<S> angles = euler(q);
      ASSERT_TRUE(angles.allFinite());
      // Near the singularity pitch is known to sqrt(eps) only.
      EXPECT_LT(this->distance(quat_from_euler(angles), q), S(4) * std::sqrt(this->eps));
    }
  }
}

TYPED_TEST(Attitude, EulerRatesInvertTheirMatrix) {
  using S = TypeParam;
  for (int trial = 0; trial < trials; ++trial) {
    const Vec3<S> angles = this->random.template vector<S>(1.4), omega = this->random.template vector<S>(1);
    const Vec3<S> rates = euler_rates(angles, omega);
    EXPECT_LT((euler_rate_matrix(angles) * rates - omega).norm(), this->rounding * (S(1) + rates.norm()));
    EXPECT_NEAR(euler_rate_matrix(angles).determinant(), std::cos(angles[1]), this->rounding);
  }
}

TEST(AttitudeDouble, EulerRatesMoveTheQuaternionAsTheBodyRateDoes) {
  Random random(7);
  for (int trial = 0; trial < trials; ++trial) {
    const Vec3<double> angles = random.vector<double>(1.4), rates = random.vector<double>(1);
    const Vec3<double> omega = euler_rate_matrix(angles) * rates;
    const double h = 1e-5;  // central difference: h^2 = 1e-10 of truncation, 1e-11 of rounding
    const Vec3<double> before = angles - h * rates, after = angles + h * rates;
    const Eigen::Vector4d difference = (quat_from_euler(after).coeffs() - quat_from_euler(before).coeffs()) / (2 * h);
    EXPECT_LT((difference - quat_rate(quat_from_euler(angles), omega).coeffs()).norm(), 1e-9);
    const Mat3<double> Edot = (euler_rate_matrix(after) - euler_rate_matrix(before)) / (2 * h);
    EXPECT_LT((Edot - euler_rate_matrix_rate(angles, rates)).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace gyrostat::test
