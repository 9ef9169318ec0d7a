// SPDX-License-Identifier: MIT
/// @file  External torques on the body, in body axes. Any number; they add.
#pragma once
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "gyrostat/truth/orbit.hpp"
#include "gyrostat/truth/waveform.hpp"

namespace gyrostat::truth {

/// torque_B
struct ConstantTorque {
  static constexpr const char* name = "constant";
  Vec3<double> torque_B = Vec3<double>::Zero();

  static constexpr void describe(auto& p, auto&& field) {
    field(p.torque_B, Field{"torque_B", "N m", -infinity, infinity, "in body axes"});
  }
  std::string check() const { return {}; }
};

/// One waveform an axis
struct PeriodicTorque {
  static constexpr const char* name = "periodic";
  std::vector<Waveform> torque_B{0.0, 0.0, 0.0};

  static constexpr void describe(auto& p, auto&& field) {
    field(p.torque_B, Field{"torque_B", "N m", -infinity, infinity, "one waveform a body axis"});
  }
  std::string check() const;
};

/// 3 mu / r^3 e x J e, e the direction to nadir in body axes and J the total inertia.
///
/// On the scenario's orbit; without one on a circle at the vehicle's orbit_rate (mu / r^3 its square), whose orbital frame O (x along track, y minus orbit normal, z nadir)
/// coincides with N at t = 0 and turns at -orbit_rate about y.
struct GravityGradient {
  static constexpr const char* name = "gravity_gradient";

  static constexpr void describe(auto&, auto&&) {}
  std::string check() const { return {}; }
};

/// Sines whose phase runs with the body's rate: offset_B + sum over terms j of
/// amplitude[j] sin(multiple[j] gain |omega| t + phase[j]) on body axis axis[j].
///
/// Li et al. 2018, section 5: gain = 10, two terms an axis.
struct RatePhaseTorque {
  static constexpr const char* name = "rate_phase";
  double gain = 10;
  Vec3<double> offset_B = Vec3<double>::Zero();
  std::vector<double> axis, amplitude, multiple, phase;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.gain, Field{"gain", "", -infinity, infinity, "phase rate per body rate"});
    field(p.offset_B, Field{"offset_B", "N m", -infinity, infinity, "constant part, in body axes"});
    field(p.axis, Field{"axis", "", 0, 2, "body axis of each term"});
    field(p.amplitude, Field{"amplitude", "N m", -infinity, infinity, "of each term"});
    field(p.multiple, Field{"multiple", "", -infinity, infinity, "of gain |omega| t, in each term"});
    field(p.phase, Field{"phase", "rad", -infinity, infinity, "of each term; pi/2 makes a cosine"});
  }
  std::string check() const;
};

/// Waveforms that grow with the body's rate: (at_rest + growth |omega|^2) wave_B(t).
///
/// Cao et al. 2022: at_rest = 5e-4, growth = 0.01, unit sines and cosines.
struct RateScaledTorque {
  static constexpr const char* name = "rate_scaled";
  double at_rest = 0, growth = 0;
  std::vector<Waveform> wave_B{0.0, 0.0, 0.0};

  static constexpr void describe(auto& p, auto&& field) {
    field(p.at_rest, Field{"at_rest", "N m", -infinity, infinity, "factor at zero rate"});
    field(p.growth, Field{"growth", "N m s^2/rad^2", -infinity, infinity, "of the factor with the squared rate"});
    field(p.wave_B, Field{"wave_B", "", -infinity, infinity, "one waveform a body axis"});
  }
  std::string check() const;
};

/// dipole_B x B_B in the field of the scenario's orbit
struct ResidualDipole {
  static constexpr const char* name = "residual_dipole";
  Vec3<double> dipole_B = Vec3<double>::Zero();

  static constexpr void describe(auto& p, auto&& field) {
    field(p.dipole_B, Field{"dipole_B", "A m^2", -infinity, infinity, "in body axes"});
  }
  std::string check() const { return {}; }
};

/// Flat plates in thin air and in sunlight, on the scenario's orbit; they do not shade each other.
///
/// Air that turns with the Earth, flowing at v against a plate with n . v > 0: F = -1/2 rho C_D A (n . v) v. Sun, outside the
/// shadow on a plate with n . s > 0: F = -P A (n . s) ((1 - specular) s + 2 (specular (n . s) + diffuse / 3) n).
struct Plates {
  static constexpr const char* name = "plates";
  std::vector<double> area;
  std::vector<std::vector<double>> normal_B, centre_B;
  std::vector<double> specular, diffuse;
  double density = 0, altitude = 0, scale_height = infinity;
  double drag_coefficient = 2.2, solar_pressure = 4.56e-6;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.area, Field{"area", "m^2", 0, 1e6, "of each plate"});
    field(p.normal_B, Field{"normal_B", "", -1, 1, "of each plate, outward, a row a plate"});
    field(p.centre_B, Field{"centre_B", "m", -1e3, 1e3, "of each plate, from the centre of mass"});
    field(p.specular, Field{"specular", "", 0, 1, "share of light that a plate reflects like a mirror; absent: 0"});
    field(p.diffuse, Field{"diffuse", "", 0, 1, "share that it scatters; absent: 0"});
    field(p.density, Field{"density", "kg/m^3", 0, 1, "of the air; 0: none"});
    field(p.altitude, Field{"altitude", "m", 0, 1e8, "at which it has this density"});
    field(p.scale_height, Field{"scale_height", "m", 1, infinity, "over which it falls to 1/e; infinite: nowhere"});
    field(p.drag_coefficient, Field{"drag_coefficient", "", 0, 10, "C_D"});
    field(p.solar_pressure, Field{"solar_pressure", "N/m^2", 0, 1, "P, of sunlight; 0: none"});
  }
  std::string check() const;
};

using Disturbance = std::variant<ConstantTorque, PeriodicTorque, GravityGradient, RatePhaseTorque, RateScaledTorque,
                                 ResidualDipole, Plates>;

const char* name_of(const Disturbance& disturbance) noexcept;
std::string check(const Disturbance& disturbance);

/// All disturbances of a run, on one smooth piece at a time.
class Disturbances {
 public:
  /// @param J_total_B  inertia of body and wheels together, kg m^2
  /// @throws std::invalid_argument
  Disturbances(std::vector<Disturbance> list, const Mat3<double>& J_total_B, double orbit_rate,
               std::optional<Orbit> orbit = {});

  double next_switch(double t) const noexcept;
  /// Begins the smooth piece that contains `branch`.
  void enter(double branch) noexcept;

  /// Where the vehicle flies; null without an orbit.
  const Orbit* orbit() const noexcept { return orbit_ ? &*orbit_ : nullptr; }

  /// N m, a torque from outside, from now on.
  void hold(const Vec3<double>& torque_B) noexcept {
    constant_B_ += torque_B - outside_B_;
    outside_B_ = torque_B;
  }
  const Vec3<double>& outside_B() const noexcept { return outside_B_; }

  /// Something depends on time or state on this piece.
  bool varies() const noexcept { return !varying_.empty(); }
  /// N m, the part that is constant on this piece.
  const Vec3<double>& constant_B() const noexcept { return constant_B_; }
  /// N m, all of it.
  Vec3<double> torque_B(double t, const Quat<double>& q_NB, const Vec3<double>& omega_BN_B) const noexcept;

 private:
  std::vector<Disturbance> list_;
  std::vector<std::size_t> varying_;  ///< which of them vary on this piece
  Mat3<double> J_total_B_;
  double orbit_rate_, branch_ = 0;
  std::optional<Orbit> orbit_;
  bool shaded_ = false;  ///< something depends on the shadow
  bool dark_ = false;    ///< on this piece
  Vec3<double> constant_B_ = Vec3<double>::Zero(), outside_B_ = Vec3<double>::Zero();
};

}  // namespace gyrostat::truth
