// SPDX-License-Identifier: MIT
/// @file  Attitude from directions that are known in N and were seen in B: TRIAD of two, QUEST of any number.
///
/// TRIAD takes the first direction as it is and of the second what is across; QUEST weighs them by their noise (least squares:
/// Wahba's problem). Sources: H. Black 1964; M. Shuster, S. Oh 1981; P. Davenport's matrix.
#pragma once
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "gyrostat/core/attitude.hpp"

namespace gyrostat {

/// A direction, as seen and as known; both unit.
template <class S>
struct Sighting {
  Vec3<S> seen_B = Vec3<S>::UnitX(), known_N = Vec3<S>::UnitX();
  S sigma = S(1);  ///< rad, one sigma an axis of what was seen
};

/// Two directions nearer to one line than this sine name no attitude.
template <class S>
inline constexpr S least_apart = S(0.1);

template <class S>
bool name_an_attitude(const Sighting<S>& one, const Sighting<S>& two) noexcept {
  return one.seen_B.cross(two.seen_B).norm() >= least_apart<S> &&
         one.known_N.cross(two.known_N).norm() >= least_apart<S>;
}

/// q_NB; the first direction is met exactly.
template <class S>
Quat<S> triad(const Sighting<S>& first, const Sighting<S>& second) noexcept {
  const auto frame = [](const Vec3<S>& one, const Vec3<S>& two) {
    const Vec3<S> three = one.cross(two).normalized();
    Mat3<S> m;
    m << one, three, one.cross(three);
    return m;
  };
  const Mat3<S> C_NB = frame(first.known_N, second.known_N) * frame(first.seen_B, second.seen_B).transpose();
  return Quat<S>(C_NB).normalized();
}

/// Covariance of the error rotation (body axes) of `triad`, rad^2.
template <class S>
Mat3<S> triad_covariance(const Sighting<S>& first, const Sighting<S>& second) noexcept {
  const Vec3<S>&b1 = first.seen_B, &b2 = second.seen_B;
  const S v1 = first.sigma * first.sigma, v2 = second.sigma * second.sigma;
  const Mat3<S> crossed = b1 * b2.transpose(), sum = crossed + crossed.transpose();
  return v1 * Mat3<S>::Identity() +
         (v1 * b1.dot(b2) * sum + (v2 - v1) * b1 * b1.transpose()) / b1.cross(b2).squaredNorm();
}

namespace detail {

/// Unit eigenvector of the largest eigenvalue of a symmetric matrix, by Jacobi's rotations.
template <class S>
Eigen::Matrix<S, 4, 1> dominant(Eigen::Matrix<S, 4, 4> K) noexcept {
  constexpr int sweeps = 12;  // four or five are enough; it ends when nothing is left to turn
  Eigen::Matrix<S, 4, 4> V = Eigen::Matrix<S, 4, 4>::Identity();
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    const S scale = K.diagonal().norm();
    S left = S(0);
    for (int p = 0; p < 3; ++p) {
      for (int q = p + 1; q < 4; ++q) {
        left = std::max(left, std::abs(K(p, q)));
        if (K(p, q) == S(0)) continue;
        const S theta = (K(q, q) - K(p, p)) / (S(2) * K(p, q));
        const S t = (theta < S(0) ? S(-1) : S(1)) / (std::abs(theta) + std::sqrt(theta * theta + S(1)));
        const S c = S(1) / std::sqrt(t * t + S(1)), s = t * c;
        for (int k = 0; k < 4; ++k) {
          const S a = K(k, p), b = K(k, q);
          K(k, p) = c * a - s * b;
          K(k, q) = s * a + c * b;
        }
        for (int k = 0; k < 4; ++k) {
          const S a = K(p, k), b = K(q, k), v = V(k, p), w = V(k, q);
          K(p, k) = c * a - s * b;
          K(q, k) = s * a + c * b;
          V(k, p) = c * v - s * w;
          V(k, q) = s * v + c * w;
        }
      }
    }
    if (left <= std::numeric_limits<S>::epsilon() * S(0.01) * scale) break;
  }
  int largest = 0;
  for (int k = 1; k < 4; ++k) {
    if (K(k, k) > K(largest, largest)) largest = k;
  }
  return V.col(largest).normalized();
}

template <class S, std::size_t n>
S least_variance(const std::array<Sighting<S>, n>& all) noexcept {
  S least = std::numeric_limits<S>::max();
  for (const Sighting<S>& one : all) least = std::min(least, one.sigma * one.sigma);
  return least;
}

}  // namespace detail

/// q_NB, of positive scalar part or zero.
template <class S, std::size_t n>
Quat<S> quest(const std::array<Sighting<S>, n>& all) noexcept {
  const S least = detail::least_variance(all);
  Mat3<S> B = Mat3<S>::Zero();
  Vec3<S> z = Vec3<S>::Zero();
  for (const Sighting<S>& one : all) {
    const S weight = least / (one.sigma * one.sigma);
    B += weight * one.seen_B * one.known_N.transpose();
    z += weight * one.seen_B.cross(one.known_N);
  }
  Eigen::Matrix<S, 4, 4> K;
  K(0, 0) = B.trace();
  K.template block<1, 3>(0, 1) = z.transpose();
  K.template block<3, 1>(1, 0) = z;
  K.template block<3, 3>(1, 1) = B + B.transpose() - B.trace() * Mat3<S>::Identity();
  const Eigen::Matrix<S, 4, 1> v = detail::dominant<S>(K);
  return short_way(Quat<S>(v[0], v[1], v[2], v[3]));
}

/// Covariance of the error rotation (body axes) of `quest`, rad^2.
template <class S, std::size_t n>
Mat3<S> quest_covariance(const std::array<Sighting<S>, n>& all) noexcept {
  const S least = detail::least_variance(all);
  Mat3<S> information = Mat3<S>::Zero();
  for (const Sighting<S>& one : all) {
    information += least / (one.sigma * one.sigma) * (Mat3<S>::Identity() - one.seen_B * one.seen_B.transpose());
  }
  return least * information.inverse();
}

}  // namespace gyrostat
