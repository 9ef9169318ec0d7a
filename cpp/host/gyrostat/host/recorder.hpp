// SPDX-License-Identifier: MIT
/// @file  Chosen channels of a run, written into preallocated rows. What nobody chose is never computed.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "gyrostat/core/signals.hpp"
#include "gyrostat/host/telemetry.hpp"
#include "gyrostat/truth/plant.hpp"

namespace gyrostat::host {

/// What one channel holds. Its columns are the members of `dimension`: axis (x, y, z), quaternion (w, x, y, z), actuator;
/// "" of one column, or of columns that are none of these.
struct ChannelInfo {
  std::string name;
  int size = 1;
  std::string unit, meaning, dimension;
};

/// The true vehicle beside the nominal one; channels compare them.
struct Vehicles {
  Vehicle<double> nominal;
  Mat3N<double> D_true_B{3, 0};
  double dt = 0;
};

/// All that a channel may read at one sample. Truth is one-sided: the interval just ended.
class Moment {
 public:
  template <truth::Plant Plant>
  Moment(const Vehicles& vehicles_in, const Plant& plant)
      : vehicles(vehicles_in),
        now(plant.state()),
        before(now),
        angle_difference(&Plant::angle_difference),
        plant_(&plant),
        sample_of_([](const void* p) { return static_cast<const Plant*>(p)->sample(); }),
        euler_of_([](const void* p) { return static_cast<const Plant*>(p)->euler(); }) {}

  /// All of the truth; sampled when the first channel asks.
  const truth::TruthSample& truth() const {
    if (!sample_) sample_ = sample_of_(plant_);
    return *sample_;
  }
  EulerState<double> euler() const { return euler_of_(plant_); }

  const Vehicles& vehicles;
  const truth::TruthState& now;
  truth::TruthState before;  ///< one sample ago; for channels that compare with it
  Vec3<double> (*angle_difference)(const Vec3<double>&, const Vec3<double>&);  ///< of roll, pitch, yaw of this plant
  double t = 0;
  const Measurement<double>* y = nullptr;
  const Reference<double>* ref = nullptr;
  const Estimate<double>* x = nullptr;
  const Detection<double>* det = nullptr;
  const Demand<double>* demand = nullptr;
  const Allocation<double>* last = nullptr;
  VecN<double> u_held;  ///< command over the interval just ended

  /// A new sample: forget what was computed for the one before.
  void advance(double time) {
    t = time;
    sample_.reset();
  }

 private:
  const void* plant_;
  truth::TruthSample (*sample_of_)(const void*);
  EulerState<double> (*euler_of_)(const void*);
  mutable std::optional<truth::TruthSample> sample_;
};

/// A component whose telemetry may be recorded, under its role's name ("observer", "shadow0.detector").
struct Reported {
  std::string role;
  const Reporting* component = nullptr;
};

/// An observer and detector beside the loop.
struct ShadowView {
  std::string role;
  const Estimate<double>* x = nullptr;
  const Detection<double>* det = nullptr;
};

class Recorder {
 public:
  /// Every channel that a run with these parts offers.
  static std::vector<ChannelInfo> offered(int actuators, const std::vector<Reported>& components,
                                          const std::vector<ShadowView>& shadows);
  /// What is recorded when nobody chooses.
  static std::vector<std::string> usual(const std::vector<Reported>& components,
                                        const std::vector<ShadowView>& shadows);

  /// `names` may end in ".*". Throws std::invalid_argument naming the nearest channel.
  Recorder(const std::vector<std::string>& names, int actuators, std::vector<Reported> components,
           std::vector<ShadowView> shadows);

  /// Numbers in a row, the time included.
  std::size_t width() const noexcept;
  /// Room for so many rows; to be called once, before the first one is recorded.
  void reserve(std::size_t rows);
  /// Whether a channel compares with the sample before.
  bool needs_previous() const noexcept { return needs_previous_; }
  void record(const Moment& now);

  struct Channel {
    ChannelInfo info;
    std::vector<double> data;  ///< rows x size
  };
  std::vector<Channel> take() &&;
  std::size_t rows() const noexcept { return row_; }
  const std::vector<double>& times() const noexcept { return t_; }

 private:
  struct Slot {  // one chosen channel
    Channel channel;
    void (*fill)(const Moment&, double*) = nullptr;
    void (*fill_shadow)(const ShadowView&, double*) = nullptr;
    std::size_t source = 0, offset = 0;  // of telemetry: component and position in its row; of a shadow: which
  };
  struct Source {  // a component with chosen telemetry
    const Reporting* component;
    std::vector<double> row;
  };

  void choose(const std::string& pattern, int actuators, const std::vector<Reported>& components,
              const std::vector<ShadowView>& shadows);

  std::vector<Slot> slots_;
  std::vector<Source> sources_;
  std::vector<ShadowView> shadows_;
  std::vector<double> t_;
  std::size_t row_ = 0;
  bool needs_previous_ = false;
};

}  // namespace gyrostat::host
