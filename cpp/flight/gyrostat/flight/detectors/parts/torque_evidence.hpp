// SPDX-License-Identifier: MIT
/// @file  The evidence of actuators that store no momentum: the torque that the observer cannot explain by what they were told.
///
/// l = D diag(e - 1) u + d_B, in blocks, less its mean and less all that lies along the axes of actuators that are known as
/// faulty. The gain that explains most of the rest is that of the faulty one, where no other explains nearly as much. A torque
/// that does not follow the command cannot be told from a disturbance, and need not be. Page: docs/components/evidence.md
#pragma once
#include <algorithm>

#include "gyrostat/flight/parts/effectiveness_regression.hpp"

namespace gyrostat {

template <class S>
class TorqueEvidence {
 public:
  static constexpr int capacity = 32, running = 4;  ///< blocks; of them that must agree

  struct Answer {
    int actuator = -1;  ///< -1: none
    S gain = S(1);
  };

  TorqueEvidence() noexcept = default;
  /// @param disturbance  N m, rms of a torque that is not looked at
  TorqueEvidence(int actuators, int block, S disturbance) noexcept
      : actuators_(actuators), block_(block), disturbance_(disturbance) {
    forget();
  }

  void forget() noexcept {
    size_ = newest_ = count_ = agreed_ = 0;
    candidate_ = -1;
    u_sum_ = VecN<S>::Zero(actuators_);
    l_sum_.setZero();
  }

  /// One sample. @return whether a block has ended
  bool sample(const Mat3N<S>& D_B, const Estimate<S>& x, const VecN<S>& u) noexcept {
    const VecN<S> missing = (x.effectiveness.array() - S(1)).matrix().cwiseProduct(u);
    l_sum_ += torque<S>(D_B, missing) + x.d_B;
    u_sum_ += u;
    if (++count_ < block_) return false;
    newest_ = (newest_ + 1) % capacity;
    torque_[newest_] = l_sum_ / static_cast<S>(count_);
    command_[newest_] = u_sum_ / static_cast<S>(count_);
    size_ = std::min(size_ + 1, capacity);
    count_ = 0;
    l_sum_.setZero();
    u_sum_.setZero();
    return true;
  }

  /// Gain of an actuator that is known as faulty, from blocks that began after `forget`; as it was while they say little.
  S gain_of(const Mat3N<S>& D_B, int i, Mask faulty, S before) const noexcept {
    if (size_ < capacity) return before;
    faulty.set(i, false);
    const Fit fit = fitted(D_B, i, beyond<S>(D_B, faulty));
    const bool told = fit.moved > S(capacity) * disturbance_ * disturbance_;
    return told ? std::clamp(S(1) + fit.along / fit.moved, S(0), S(1)) : before;
  }

  /// Of the blocks so far. @param watched  who may be named @param faulty  who is known as faulty
  Answer judge(const Mat3N<S>& D_B, Mask watched, Mask faulty) noexcept {
    if (size_ < capacity) return {};
    const Answer now = best(D_B, watched.without(faulty), beyond<S>(D_B, faulty));
    agreed_ = now.actuator >= 0 && now.actuator == candidate_ ? agreed_ + 1 : 1;
    candidate_ = now.actuator;
    return now.actuator >= 0 && agreed_ >= running ? now : Answer{};
  }

 private:
  struct Fit {
    S along = S(0), moved = S(0);  ///< (N m)^2: of what is not explained with D_i u_i, and of D_i u_i with itself
  };

  Vec3<S> mean_torque() const noexcept {
    Vec3<S> mean = Vec3<S>::Zero();
    for (int k = 0; k < capacity; ++k) mean += torque_[k] / S(capacity);
    return mean;
  }

  Fit fitted(const Mat3N<S>& D_B, int i, const Mat3<S>& P) const noexcept {
    const Vec3<S> l_mean = mean_torque(), axis = P * D_B.col(i);
    S u_mean = S(0);
    for (int k = 0; k < capacity; ++k) u_mean += command_[k][i] / S(capacity);
    Fit fit;
    for (int k = 0; k < capacity; ++k) {
      const S du = command_[k][i] - u_mean;
      fit.along += axis.dot(torque_[k] - l_mean) * du;
      fit.moved += axis.squaredNorm() * du * du;
    }
    return fit;
  }

  Answer best(const Mat3N<S>& D_B, Mask watched, const Mat3<S>& P) const noexcept {
    const Vec3<S> l_mean = mean_torque();
    S total = S(0);
    for (int k = 0; k < capacity; ++k) total += (P * (torque_[k] - l_mean)).squaredNorm();
    if (!(total > S(capacity) * disturbance_ * disturbance_)) return {};
    Answer answer;
    S left = total, runner_up = total;
    for (int i = 0; i < actuators_; ++i) {
      if (!watched.test(i)) continue;
      const auto [along, moved] = fitted(D_B, i, P);
      if (!(moved > S(0))) continue;
      const S rest = total - along * along / moved;
      if (rest < left) {
        runner_up = left;
        left = rest;
        answer = {i, S(1) + along / moved};
      } else {
        runner_up = std::min(runner_up, rest);
      }
    }
    const bool explains = left < S(0.4) * total && runner_up > S(1.5) * left;
    const bool loses = answer.gain > S(-0.5) && answer.gain < S(0.8);
    if (!explains || !loses) return {};
    answer.gain = std::max(answer.gain, S(0));
    return answer;
  }

  int actuators_ = 0;
  int block_ = 1;
  S disturbance_ = S(0);
  Vec3<S> torque_[capacity];
  VecN<S> command_[capacity];
  Vec3<S> l_sum_ = Vec3<S>::Zero();
  VecN<S> u_sum_;
  int size_ = 0, newest_ = 0, count_ = 0, agreed_ = 0, candidate_ = -1;
};

}  // namespace gyrostat
