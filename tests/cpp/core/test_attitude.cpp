// SPDX-License-Identifier: MIT
#include "gyrostat/core/attitude.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <limits>

#include "../random.hpp"

namespace gyrostat::test::test_attitude {
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
  static Quat<S> scaled(S length, const Quat<S>& q) { return Quat<S>(Eigen::Matrix<S, 4, 1>(length * q.coeffs())); }
  /// Unit, from any length, in more digits than S has: what the functions are held against.
  static Quat<S> direction(const Quat<S>& q) {
    using Wide = Eigen::Matrix<long double, 4, 1>;
    const Wide wide = q.coeffs().template cast<long double>();
    return Quat<S>((wide / wide.norm()).template cast<S>());
  }
  /// From 1e-30 to 1e30 squares leave the range of float, from 1e-200 to 1e200 that of double.
  static std::initializer_list<S> lengths() {
    static constexpr bool wide = std::numeric_limits<S>::max_exponent10 > 300;
    static constexpr S far = wide ? S(1e200) : S(1e30);
    static constexpr std::initializer_list<S> all = {S(1) / far, S(1e-9), S(0.5), S(0.9999),
                                                     S(1.0001),  S(40),   S(1e9), far};
    return all;
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
    // |q|^2 dcm(q) is a polynomial of degree two in q: its central difference is exact for every step. The rate is at
    // right angles to q, so both ends have the same length.
    const S squared = S(1) + rate.squaredNorm();
    const Mat3<S> Cdot =
        squared * (dcm(Quat<S>(q.coeffs() + rate.coeffs())) - dcm(Quat<S>(q.coeffs() - rate.coeffs()))) / S(2);
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

TYPED_TEST(Attitude, EulerAnglesGiveTheAttitudeBackAtAndAroundTheLock) {
  using S = TypeParam;
  const S quarter = S(1.57079632679489661923);
  for (const double from_lock : {0.0, 1e-17, 1e-12, 1e-9, 1e-7, 6e-5 * 1.745e-2, 1e-5, 1e-3, 0.03, 0.125, 0.3}) {
    for (const S side : {S(1), S(-1)}) {
      for (int trial = 0; trial < trials / 10; ++trial) {
        const S roll = static_cast<S>(this->random.uniform(-3, 3)), yaw = static_cast<S>(this->random.uniform(-3, 3));
        const S pitch = side * (quarter - static_cast<S>(from_lock));
        const Quat<S> q = quat_from_euler<S>({roll, pitch, yaw});
        // Rounded to float as well: not on the lock any more, and not of unit length.
        for (const Quat<S>& given : {q, Quat<S>(q.template cast<float>().template cast<S>())}) {
          const Vec3<S> angles = euler(given);
          ASSERT_LE(std::abs(angles[1]), quarter);
          EXPECT_LT(this->distance(quat_from_euler(angles), this->direction(given)), this->rounding)
              << from_lock << " from pitch " << S(90) * side;
        }
      }
    }
  }
}

TYPED_TEST(Attitude, OnTheLockRollTakesAllAndYawIsZero) {
  using S = TypeParam;
  const S quarter = S(1.57079632679489661923);
  const S roll = S(0.7), yaw = S(-0.4);
  const Vec3<S> up = euler(quat_from_euler<S>({roll, quarter, yaw}));
  const Vec3<S> down = euler(quat_from_euler<S>({roll, -quarter, yaw}));
  EXPECT_LT((up - Vec3<S>(roll - yaw, quarter, S(0))).norm(), this->rounding);
  EXPECT_LT((down - Vec3<S>(roll + yaw, -quarter, S(0))).norm(), this->rounding);
}

// ---- length and edges: the rule of attitude.hpp -------------------------------------------------------------------

TYPED_TEST(Attitude, AQuaternionOfAnyLengthStandsForItsDirection) {
  using S = TypeParam;
  for (int trial = 0; trial < trials / 4; ++trial) {
    const Quat<S> q = this->random.template attitude<S>(), q_NR = this->random.template attitude<S>();
    const Vec3<S> omega = this->random.template vector<S>(1), omega_R = this->random.template vector<S>(1);
    const AttitudeError<S> error = attitude_error(q, omega, q_NR, omega_R);
    for (const S length : this->lengths()) {
      const Quat<S> long_q = this->scaled(length, q), long_q_NR = this->scaled(length, q_NR);
      EXPECT_LT((unit(long_q).coeffs() - q.coeffs()).norm(), this->rounding) << length;
      EXPECT_LT((dcm(long_q) - dcm(q)).norm(), this->rounding) << length;
      EXPECT_NEAR(rotation_angle(long_q), rotation_angle(q), this->rounding) << length;
      EXPECT_LT((quat_log(long_q) - quat_log(q)).norm(), S(4) * this->rounding) << length;
      EXPECT_LT((mrp(short_way(long_q)) - mrp(short_way(q))).norm(), this->rounding) << length;
      EXPECT_LT(this->distance(quat_from_euler(euler(long_q)), q), this->rounding) << length;
      const AttitudeError<S> same = attitude_error(long_q, omega, long_q_NR, omega_R);
      EXPECT_LT((same.q_RB.coeffs() - error.q_RB.coeffs()).norm(), this->rounding) << length;
      EXPECT_LT((same.omega_BR_B - error.omega_BR_B).norm(), this->rounding) << length;
      EXPECT_LT((same.omega_RN_B - error.omega_RN_B).norm(), this->rounding) << length;
    }
  }
}

TYPED_TEST(Attitude, AQuaternionOfUnitLengthKeepsItsBits) {
  using S = TypeParam;
  for (int trial = 0; trial < trials; ++trial) {
    const Quat<S> a = this->random.template attitude<S>();
    const Quat<S> b = Quat<S>(this->random.template attitude<double>().template cast<S>());
    for (const Quat<S>& q : {a, b, Quat<S>(a.conjugate() * b), quat_from_mrp(this->random.template vector<S>(1))}) {
      EXPECT_EQ(unit(q).coeffs(), q.coeffs());
      EXPECT_EQ(dcm(q), q.toRotationMatrix().transpose());
      const Quat<S> near = short_way(q);
      EXPECT_EQ(mrp(near), Vec3<S>(near.vec() / (S(1) + near.w())));
    }
  }
}

TYPED_TEST(Attitude, WhatDescribesNoAttitudeGivesNaN) {
  using S = TypeParam;
  const S inf = std::numeric_limits<S>::infinity(), nan = std::numeric_limits<S>::quiet_NaN();
  const Vec3<S> rest = Vec3<S>::Zero();
  for (const Quat<S>& q :
       {Quat<S>(S(0), S(0), S(0), S(0)), Quat<S>(S(1), inf, S(0), S(0)), Quat<S>(-inf, S(0), S(0), S(0)),
        Quat<S>(S(-1), nan, S(0), S(0)), Quat<S>(nan, S(0), S(0), S(1))}) {
    EXPECT_TRUE(dcm(q).hasNaN());
    EXPECT_TRUE(mrp(q).hasNaN());
    EXPECT_TRUE(euler(q).hasNaN());
    EXPECT_TRUE(quat_log(q).hasNaN());
    EXPECT_TRUE(std::isnan(rotation_angle(q)));
    EXPECT_TRUE(attitude_error<S>(q, rest, Quat<S>::Identity(), rest).q_RB.coeffs().hasNaN());
    EXPECT_TRUE(attitude_error<S>(Quat<S>::Identity(), rest, q, rest).q_RB.coeffs().hasNaN());
  }
  for (const S bad : {inf, -inf, nan}) {
    const Vec3<S> v{S(0.1), bad, S(0)};
    EXPECT_TRUE(mrp_shadow(v).hasNaN());
    EXPECT_TRUE(quat_from_mrp(v).coeffs().hasNaN());
    EXPECT_TRUE(quat_exp(v).coeffs().hasNaN());
    EXPECT_TRUE(quat_from_euler(v).coeffs().hasNaN());
    EXPECT_TRUE(std::isnan(wrapped(bad)));
  }
}

TYPED_TEST(Attitude, MrpIsAccurateUpToAFullTurn) {
  using S = TypeParam;
  for (const S left : {S(2), S(1), S(1e-2), S(1e-4), S(1e-9), S(1e-12), S(1e-30)}) {  // rad to a full turn
    const Vec3<S> axis = Vec3<S>(S(2), S(-1), S(2)) / S(3);
    const S quarter_left = left / S(4);
    const Quat<S> q(-std::cos(left / S(2)), std::sin(left / S(2)) * axis[0], std::sin(left / S(2)) * axis[1],
                    std::sin(left / S(2)) * axis[2]);
    const Vec3<S> expected = axis / std::tan(quarter_left);  // tan((2 pi - left) / 4)
    EXPECT_LT((mrp(q) - expected).norm(), this->rounding * expected.norm()) << left;
    EXPECT_LT(this->distance(quat_from_mrp(mrp(q)), q), this->rounding) << left;
    EXPECT_LT((mrp_shadow(mrp(q)) + axis * std::tan(quarter_left)).norm(), this->rounding * quarter_left) << left;
  }
}

TYPED_TEST(Attitude, MrpOfAFullTurnIsTheNearestThatExists) {
  using S = TypeParam;
  const S least = std::numeric_limits<S>::denorm_min();
  EXPECT_EQ(mrp(Quat<S>(S(-1), S(0), S(0), S(0))), Vec3<S>::Zero());
  EXPECT_EQ(mrp(Quat<S>(S(-1), least, S(0), S(0))), Vec3<S>::Zero());  // 2 / least is not a number of S
  EXPECT_EQ(mrp_shadow<S>(Vec3<S>::Zero()), Vec3<S>::Zero());
  EXPECT_EQ(mrp_shadow<S>({least, S(0), S(0)}), Vec3<S>::Zero());
}

TYPED_TEST(Attitude, MrpOfAnySizeIsAnAttitudeAndHasAShadow) {
  using S = TypeParam;
  const Vec3<S> axis = Vec3<S>(S(2), S(-1), S(2)) / S(3);
  const int decades = std::numeric_limits<S>::max_exponent10 - 1;
  for (int decade = 1 - decades; decade < decades; ++decade) {
    const S size = std::pow(S(10), static_cast<S>(decade));
    const Vec3<S> sigma = size * axis, shadow = mrp_shadow(sigma);
    EXPECT_LT((shadow * size + axis).norm(), this->rounding) << size;
    const Quat<S> q = quat_from_mrp(sigma);
    EXPECT_NEAR(q.norm(), S(1), this->rounding) << size;
    EXPECT_LT(this->distance(q, quat_from_mrp(shadow)), this->rounding) << size;
    EXPECT_LT((mrp(q) / size - axis).norm(), this->rounding) << size;
    // sigma is an eigenvector of G, of value (1 + |sigma|^2) / 4
    const long double value = (1 + static_cast<long double>(size) * static_cast<long double>(size)) / 4;
    const S least = std::numeric_limits<S>::min();
    const Vec3<S> expected = static_cast<S>(1 / value) * axis;
    EXPECT_LE((mrp_rate_matrix_inverse(sigma) * axis - expected).template lpNorm<Eigen::Infinity>(),
              this->rounding * static_cast<S>(1 / value) + least)
        << size;
  }
}

TYPED_TEST(Attitude, RotationVectorsOfAnySizeAreRotations) {
  using S = TypeParam;
  const Vec3<S> axis = Vec3<S>(S(2), S(-1), S(2)) / S(3);
  const int decades = std::numeric_limits<S>::max_exponent10 - 1;
  for (int decade = 1 - decades; decade < decades; ++decade) {
    const S size = std::pow(S(10), static_cast<S>(decade));
    const Quat<S> q = quat_exp<S>(size * axis);
    EXPECT_NEAR(q.norm(), S(1), this->rounding) << size;
    if (decade >= 0) continue;
    EXPECT_LT(std::abs(rotation_angle(q) - size), this->rounding * size) << size;
    EXPECT_LT((quat_log(q) - size * axis).norm(), this->rounding * size) << size;
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
}  // namespace gyrostat::test::test_attitude
