// SPDX-License-Identifier: MIT
/// @file  What can be read of a run at one sample, by name: truth, signals, inner signals of components, shadows.
#pragma once
#include <optional>
#include <span>
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
  Moment(const Vehicles& vehicles_in, const truth::Plant& plant) : vehicles(vehicles_in), plant_(plant) {}

  const truth::TruthSample& truth() const;

  const Vehicles& vehicles;
  double t = 0;
  const Measurement<double>* y = nullptr;
  const Reference<double>* ref = nullptr;
  const Estimate<double>* x = nullptr;
  const Detection<double>* det = nullptr;
  const Demand<double>* demand = nullptr;
  const Allocation<double>* last = nullptr;
  const VecN<double>* u_held = nullptr;          ///< command over the interval just ended
  const Vec3<double>* omega_before_B = nullptr;  ///< true rate one sample ago
  const VecN<double>* h_w_before = nullptr;      ///< true wheel momentum one sample ago
  const Vec3<double>* angles_before = nullptr;   ///< true Euler angles one sample ago; the Euler-angle model only
  const Vec3<double>& omega_BN_B() const { return plant_.omega_BN_B(); }
  const Quat<double>& q_NB() const { return plant_.q_NB(); }
  EulerState<double> euler() const { return plant_.euler(); }
  const VecN<double>& h_w() const { return plant_.h_w(); }

  /// A new sample: forget what was computed for the one before.
  void advance(double time) {
    t = time;
    sample_.reset();
  }

 private:
  const truth::Plant& plant_;
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

/// Chosen channels, read together. What nobody chose is never computed.
class ChannelReader {
 public:
  /// Every channel that a run with these parts offers.
  static std::vector<ChannelInfo> offered(int actuators, const std::vector<Reported>& components,
                                          const std::vector<ShadowView>& shadows);
  /// What is recorded when nobody chooses.
  static std::vector<std::string> usual(const std::vector<Reported>& components,
                                        const std::vector<ShadowView>& shadows);

  /// `names` may end in ".*". Throws std::invalid_argument naming the nearest channel; `where` stands before it.
  ChannelReader(const std::vector<std::string>& names, int actuators, const std::vector<Reported>& components,
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
    void (*fill_shadow)(const ShadowView&, double*) = nullptr;
    int component = -1;
    std::size_t part = 0;    // which shadow; position in the component's row
    std::size_t offset = 0;  // in row_
  };
  struct Telemetry {  // a component with chosen inner signals
    const Reporting* component;
    std::vector<double> row;
  };

  void choose(const std::string& pattern, int actuators, const std::vector<Reported>& components,
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
