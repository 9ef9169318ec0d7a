// SPDX-License-Identifier: MIT
/// @file  The evidence of one wheel: its momentum says what it delivered, whatever the body does.
///
/// h_w' = -delivered, free of disturbances, of the inertia and of other actuators. Page: docs/components/evidence.md
#pragma once
#include "gyrostat/flight/detectors/parts/fault_fit.hpp"
#include "gyrostat/flight/detectors/parts/tachometer_noise.hpp"

namespace gyrostat {

/// What all wheels share.
template <class S>
struct WheelRules {
  S dt;            ///< s
  int block;       ///< samples
  S z;             ///< variances that noise may be
  S late;          ///< samples that a measurement may be late
  S failed_below;  ///< gain that is stuck at zero
  S confirm;       ///< s
};

template <class S>
class WheelEvidence {
 public:
  /// What a pair has changed.
  enum class News : std::uint8_t { none, declared, recovered };

  WheelEvidence() noexcept = default;
  /// @param smallest  N m, smallest fault sought
  /// @param noise  N m s, of a usual tachometer
  /// @param h_max  N m s, momentum at which the wheel gives no more; infinite: not known
  WheelEvidence(const WheelRules<S>& rules, S smallest, S noise, S h_max) noexcept
      : rules_(rules), smallest_(smallest), h_max_(h_max), noise_(S(0.02) * noise, smallest) {}

  /// What lies between the last sample and the next says nothing: not measured, or a jump.
  void interrupt() noexcept {
    noise_.interrupt();
    begun_ = false;
  }

  /// One sample. @return whether a block has ended with a pair, of which `judge` then makes what there is to make
  /// @param h  N m s, measured now
  /// @param u  N m, command of the interval just ended
  bool sample(S h, S u) noexcept {
    noise_.sample(h, u, rules_.dt);
    const bool at_limit = std::abs(h) >= S(0.995) * h_max_ - S(3) * std::sqrt(noise_.variance());
    if (!begun_) {
      if (noise_.settled()) begin(h, u, at_limit);
      return false;
    }
    sum_ += u;
    ++count_;
    limited_ = limited_ || at_limit;
    if (count_ < length_) return false;
    const S time = static_cast<S>(count_) * rules_.dt, late = rules_.late * rules_.dt / time * (u - u_before_);
    MomentumPair<S> pair;
    pair.delivered = (h_begin_ - h) / time;
    pair.commanded = sum_ / static_cast<S>(count_);
    pair.tolerance =
        std::sqrt(smallest_ * smallest_ + rules_.z * S(2) * noise_.variance() / (time * time) + late * late);
    time_ = time;
    const bool counts = !limited_;
    if (counts) pairs_.push(pair);
    begin(h, u, at_limit);
    return counts;
  }

  /// Of the pair that `sample` has told of. A wheel that recovered twice within ten minutes has a fault that comes and goes.
  News judge() noexcept {
    since_recovery_[0] += time_;
    since_recovery_[1] += time_;
    if (fault_.fault == FaultClass::healthy) {
      if (!pairs_.persists()) return News::none;
      fault_ = {FaultClass::unclear};
      comes_and_goes_ = since_recovery_[1] < S(600);
      good_ = 0;
      classify();
      return News::declared;
    }
    classify();
    if (!recovers()) return News::none;
    fault_ = healthy();
    pairs_.forget();
    since_recovery_[1] = since_recovery_[0];
    since_recovery_[0] = S(0);
    return News::recovered;
  }

  /// Stuck for good, as far as its command has asked: both ways, for long enough.
  bool useless() const noexcept {
    return fault_.fault == FaultClass::stuck && asked_up_ && asked_down_ && stuck_for_ >= rules_.confirm;
  }

  /// Evidence starts anew, of a wheel that is known as faulty.
  void retry() noexcept {
    pairs_.forget();
    interrupt();
    doubt();
  }

  const FaultFit<S>& fault() const noexcept { return fault_; }
  const MomentumPairs<S>& pairs() const noexcept { return pairs_; }
  S noise() const noexcept { return std::sqrt(noise_.variance()); }

 private:
  static FaultFit<S> healthy() noexcept { return {FaultClass::healthy}; }

  /// The block that starts at this sample: as long as noise asks for.
  void begin(S h, S u, bool at_limit) noexcept {
    begun_ = true;
    h_begin_ = h;
    u_before_ = u;
    limited_ = at_limit;
    sum_ = S(0);
    count_ = 0;
    const S shortest = static_cast<S>(rules_.block) * rules_.dt;
    const S wanted = std::sqrt(S(2) * rules_.z * noise_.variance()) / (S(4) * smallest_);
    const S blocks = std::clamp(std::ceil(wanted / shortest), S(1), S(20));
    length_ = rules_.block * static_cast<int>(blocks);
  }

  /// Nothing is learned from a wheel that does what it is told; what was clear stays so until something else is.
  void classify() noexcept {
    const int n = pairs_.since_onset();
    if (n == 0) return;
    const FaultFit<S> fit = fit_fault(pairs_, n, rules_.failed_below);
    if (comes_and_goes_) {
      fault_ = {FaultClass::intermittent, S(1), fit.bias};
      return;
    }
    const bool follows = fit.moved && fit.slope >= S(0.25);  // what is stuck does not
    const bool open = fault_.fault == FaultClass::unclear || (fault_.fault == FaultClass::stuck && follows);
    if (fit.fault != FaultClass::unclear || open) {
      if (fit.fault != fault_.fault) doubt();
      fault_ = fit;
    }
    confirm(fit);
  }

  void doubt() noexcept {
    stuck_for_ = S(0);
    asked_up_ = asked_down_ = false;
  }

  /// Counts while the command moves and the output does not.
  void confirm(const FaultFit<S>& fit) noexcept {
    const MomentumPair<S>& now = pairs_[0];
    if (fault_.fault != FaultClass::stuck || !fit.moved) return;
    if (fit.slope >= S(0.1)) return doubt();
    stuck_for_ += time_;
    asked_up_ = asked_up_ || now.commanded - fault_.bias > now.tolerance;
    asked_down_ = asked_down_ || fault_.bias - now.commanded > now.tolerance;
  }

  /// Two rings of pairs that were well while the fault would have shown.
  bool recovers() noexcept {
    const MomentumPair<S>& now = pairs_[0];
    if (!now.inside()) {
      good_ = very_good_ = 0;
      return false;
    }
    const bool known =
        fault_.fault == FaultClass::gain || fault_.fault == FaultClass::additive || fault_.fault == FaultClass::stuck;
    const S shown = known ? fault_.gain * now.commanded + fault_.bias - now.commanded : now.commanded;
    if (std::abs(shown) <= S(2) * now.tolerance) return false;
    if (good_ == 0) very_good_ = 0;
    ++good_;
    very_good_ += now.inside(S(0.5)) ? 1 : 0;
    constexpr int enough = 2 * MomentumPairs<S>::capacity;
    if (good_ < enough) return false;
    const bool most = 4 * very_good_ >= 3 * good_;
    good_ = very_good_ = 0;
    return most;
  }

  WheelRules<S> rules_{};
  S smallest_ = S(1), h_max_ = std::numeric_limits<S>::infinity();
  TachometerNoise<S> noise_;
  MomentumPairs<S> pairs_;
  FaultFit<S> fault_ = healthy();
  S h_begin_ = S(0), u_before_ = S(0), sum_ = S(0), time_ = S(0);
  S stuck_for_ = S(0);                      ///< s
  S since_recovery_[2] = {S(1e6), S(1e6)};  ///< s, the last one and the one before
  int count_ = 0, length_ = 1, good_ = 0, very_good_ = 0;
  bool begun_ = false, limited_ = false;
  bool asked_up_ = false, asked_down_ = false, comes_and_goes_ = false;
};

}  // namespace gyrostat
