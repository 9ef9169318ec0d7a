// SPDX-License-Identifier: MIT
/// @file  What can be read of a run at one sample, by name: truth, signals, inner signals of components, shadows.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gyrostat/core/signals.hpp"
#include "gyrostat/flight/control_moment_gyros.hpp"
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

/// How many of what a vehicle has: widths of channels.
struct Counts {
  int actuators = 0, modes = 0, gimbals = 0;  ///< gimbals: actuators, where some of them have one
  bool thrusters = false, orbit = false;
};

/// The true vehicle beside the nominal one; channels compare them.
struct Vehicles {
  Vehicle<double> nominal;
  Mat3N<double> D_B{3, 0}, D_true_B{3, 0};  ///< of magnetorquers with the axes of their dipoles
  ControlMomentGyros<double> gyros;
  std::optional<truth::Orbit> orbit;
  double dt = 0;
};

/// What an observer and its detector say.
struct PairView {
  const Estimate<double>* x = nullptr;
  const Detection<double>* det = nullptr;
  int actuators = 0;
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
  PairView pair;
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
  PairView pair;
};

/// Chosen channels, read together. What nobody chose is never computed.
class ChannelReader {
 public:
  /// Every channel that a run with these parts offers.
  static std::vector<ChannelInfo> offered(const Counts& counts, const std::vector<Reported>& components,
                                          const std::vector<ShadowView>& shadows);
  /// What is recorded when nobody chooses.
  static std::vector<std::string> usual(const std::vector<Reported>& components,
                                        const std::vector<ShadowView>& shadows);

  /// `names` may end in ".*". Throws std::invalid_argument naming the nearest channel; `where` stands before it.
  ChannelReader(const std::vector<std::string>& names, const Counts& counts, const std::vector<Reported>& components,
                std::vector<ShadowView> shadows, const std::string& where);

  /// In the order of their names; one that was named twice stands once.
  const std::vector<ChannelInfo>& channels() const noexcept { return channels_; }
  /// Whether a channel compares with the sample before.
  bool needs_previous() const noexcept { return needs_previous_; }
  /// Whether a channel of a shadow pair is among them.
  bool needs_shadows() const noexcept { return needs_shadows_; }

  /// Takes a sample.
  void read(const Moment& now);
  /// What channel i was at the last one.
  std::span<const double> operator[](std::size_t i) const noexcept {
    return {row_.data() + sources_[i].offset, static_cast<std::size_t>(channels_[i].size)};
  }

 private:
  struct Source {  // of one channel; exactly one of the first three
    void (*fill)(const Moment&, double*) = nullptr;
    void (*fill_pair)(const PairView&, double*) = nullptr;
    int component = -1;
    std::size_t part = 0;    // 0: the loop's pair, else a shadow counted from 1; position in the component's row
    std::size_t offset = 0;  // in row_
  };
  struct Telemetry {  // a component with chosen inner signals
    const Reporting* component;
    std::vector<double> row;
  };

  void choose(const std::string& pattern, const Counts& counts, const std::vector<Reported>& components,
              const std::string& where);
  void add(ChannelInfo info, Source source);
  int telemetry_of(const Reported& component);

  std::vector<ChannelInfo> channels_;
  std::vector<Source> sources_;
  std::vector<Telemetry> telemetry_;
  std::vector<ShadowView> shadows_;
  std::vector<double> row_;
  bool needs_previous_ = false, needs_shadows_ = false;
};

}  // namespace gyrostat::host
