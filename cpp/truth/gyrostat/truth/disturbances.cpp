// SPDX-License-Identifier: MIT
#include "gyrostat/truth/disturbances.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gyrostat::truth {
namespace {

using Waves = std::vector<Waveform>;

std::string check_axes(const char* what, const Waves& waves) {
  if (waves.size() != 3) return std::string(what) + " needs three waveforms, one a body axis";
  for (const Waveform& wave : waves) {
    if (const std::string error = wave.check(); !error.empty()) return std::string(what) + ": " + error;
  }
  return {};
}

Vec3<double> value(const Waves& waves, double t, double branch) noexcept {
  return {waves[0](t, branch), waves[1](t, branch), waves[2](t, branch)};
}

double first_switch(const Waves& waves, double t) noexcept {
  double next = infinity;
  for (const Waveform& wave : waves) next = std::min(next, wave.next_switch(t));
  return next;
}

double next(const PeriodicTorque& d, double t) noexcept { return first_switch(d.torque_B, t); }
double next(const RateScaledTorque& d, double t) noexcept { return first_switch(d.wave_B, t); }
double next(const auto&, double) noexcept { return infinity; }

bool constant(const ConstantTorque&) noexcept { return true; }
bool constant(const PeriodicTorque& d) noexcept {
  return std::all_of(d.torque_B.begin(), d.torque_B.end(), [](const Waveform& w) { return w.piecewise_constant(); });
}
bool constant(const auto&) noexcept { return false; }

Vec3<double> vector(const std::vector<double>& row) noexcept { return {row[0], row[1], row[2]}; }

/// What a torque may depend on.
struct Circumstances {
  double t, branch;
  const Quat<double>& q_NB;
  const Vec3<double>& omega_BN_B;
  const Mat3<double>& J_total_B;
  double orbit_rate;
  const Orbit* orbit = nullptr;
  bool dark = false;

  Vec3<double> operator()(const ConstantTorque& d) const noexcept { return d.torque_B; }
  Vec3<double> operator()(const PeriodicTorque& d) const noexcept { return value(d.torque_B, t, branch); }
  Vec3<double> operator()(const GravityGradient&) const noexcept {
    if (orbit != nullptr) {
      const Vec3<double> r_B = q_NB.conjugate() * orbit->r_N(t);
      const double r = r_B.norm();
      return 3 * earth::mu / (r * r * r) * (r_B / r).cross(J_total_B * (r_B / r));
    }
    const double angle = orbit_rate * t;
    const Vec3<double> nadir_N{-std::sin(angle), 0, std::cos(angle)};
    const Vec3<double> nadir_B = q_NB.conjugate() * nadir_N;
    return 3 * orbit_rate * orbit_rate * nadir_B.cross(J_total_B * nadir_B);
  }
  Vec3<double> operator()(const ResidualDipole& d) const noexcept {
    return d.dipole_B.cross(q_NB.conjugate() * orbit->field(t).B_N);
  }
  Vec3<double> operator()(const Plates& d) const noexcept {
    const Quat<double> q_BN = q_NB.conjugate();
    const Vec3<double> s = q_BN * orbit->sun_N();
    Vec3<double> v = Vec3<double>::Zero();
    double flow = 0;
    if (d.density > 0) {
      const Orbit::Point p = orbit->at(t);
      v = q_BN * (p.v_N - earth::rate * Vec3<double>::UnitZ().cross(p.r_N));
      const double height = p.r_N.norm() - earth::radius;
      flow = 0.5 * d.density * std::exp((d.altitude - height) / d.scale_height) * d.drag_coefficient;
    }
    Vec3<double> torque_B = Vec3<double>::Zero();
    for (std::size_t k = 0; k < d.area.size(); ++k) {
      const Vec3<double> n = vector(d.normal_B[k]);
      Vec3<double> force = -flow * std::max(n.dot(v), 0.0) * v;
      const double facing = n.dot(s);
      if (!dark && facing > 0) {
        const double mirror = d.specular.empty() ? 0 : d.specular[k], scatter = d.diffuse.empty() ? 0 : d.diffuse[k];
        force -= d.solar_pressure * facing * ((1 - mirror) * s + 2 * (mirror * facing + scatter / 3) * n);
      }
      torque_B += d.area[k] * vector(d.centre_B[k]).cross(force);
    }
    return torque_B;
  }
  Vec3<double> operator()(const RatePhaseTorque& d) const noexcept {
    const double angle = d.gain * omega_BN_B.norm() * t;
    Vec3<double> torque_B = d.offset_B;
    for (std::size_t j = 0; j < d.axis.size(); ++j) {
      torque_B[static_cast<int>(d.axis[j])] += d.amplitude[j] * std::sin(d.multiple[j] * angle + d.phase[j]);
    }
    return torque_B;
  }
  Vec3<double> operator()(const RateScaledTorque& d) const noexcept {
    return (d.at_rest + d.growth * omega_BN_B.squaredNorm()) * value(d.wave_B, t, branch);
  }
};

}  // namespace

std::string PeriodicTorque::check() const { return check_axes("torque_B", torque_B); }
std::string RateScaledTorque::check() const { return check_axes("wave_B", wave_B); }
std::string RatePhaseTorque::check() const {
  if (amplitude.size() != axis.size() || multiple.size() != axis.size() || phase.size() != axis.size()) {
    return "axis, amplitude, multiple and phase must have one element a term each";
  }
  for (const double a : axis) {
    if (a != 0 && a != 1 && a != 2) return "axis must be 0, 1 or 2";
  }
  return {};
}

std::string Plates::check() const {
  const std::size_t n = area.size();
  if (n == 0) return "area is missing: one number a plate";
  if (normal_B.size() != n || centre_B.size() != n) return "normal_B and centre_B must have a row a plate";
  for (const auto* share : {&specular, &diffuse}) {
    if (!share->empty() && share->size() != n) return "specular and diffuse must have one number a plate";
  }
  for (std::size_t k = 0; k < n; ++k) {
    const std::string plate = "plate " + std::to_string(k);
    if (normal_B[k].size() != 3 || centre_B[k].size() != 3)
      return plate + ": normal_B and centre_B have 3 numbers a row";
    if (std::abs(vector(normal_B[k]).norm() - 1) > 1e-6) return plate + ": normal_B must be a unit vector";
    const double both = (specular.empty() ? 0 : specular[k]) + (diffuse.empty() ? 0 : diffuse[k]);
    if (both > 1) return plate + ": specular and diffuse are more than all light together";
  }
  return {};
}

const char* name_of(const Disturbance& disturbance) noexcept {
  return std::visit([](const auto& d) { return d.name; }, disturbance);
}

std::string check(const Disturbance& disturbance) {
  const std::string error = std::visit([](const auto& d) { return d.check(); }, disturbance);
  return error.empty() ? error : "disturbance " + std::string(name_of(disturbance)) + ": " + error;
}

Disturbances::Disturbances(std::vector<Disturbance> list, const Mat3<double>& J_total_B, double orbit_rate,
                           std::optional<Orbit> orbit)
    : list_(std::move(list)), J_total_B_(J_total_B), orbit_rate_(orbit_rate), orbit_(std::move(orbit)) {
  for (const Disturbance& d : list_) {
    if (const std::string error = check(d); !error.empty()) throw std::invalid_argument(error);
    if (std::holds_alternative<GravityGradient>(d) && orbit_rate_ == 0 && !orbit_) {
      throw std::invalid_argument("disturbance gravity_gradient needs an orbit, or the vehicle's orbit_rate");
    }
    const auto* plates = std::get_if<Plates>(&d);
    if ((plates != nullptr || std::holds_alternative<ResidualDipole>(d)) && !orbit_) {
      throw std::invalid_argument("disturbance " + std::string(name_of(d)) + " needs an orbit");
    }
    shaded_ = shaded_ || (plates != nullptr && plates->solar_pressure > 0);
  }
  varying_.reserve(list_.size());
}

double Disturbances::next_switch(double t) const noexcept {
  double first = shaded_ ? orbit_->next_switch(t) : infinity;
  for (const Disturbance& d : list_) {
    first = std::min(first, std::visit([&](const auto& law) { return next(law, t); }, d));
  }
  return first;
}

void Disturbances::enter(double branch) noexcept {
  branch_ = branch;
  dark_ = shaded_ && orbit_->dark(branch);
  constant_B_ = outside_B_;
  varying_.clear();
  for (std::size_t i = 0; i < list_.size(); ++i) {
    const Disturbance& d = list_[i];
    if (std::visit([](const auto& law) { return constant(law); }, d)) {
      const Quat<double> any_attitude = Quat<double>::Identity();
      const Vec3<double> any_rate = Vec3<double>::Zero();
      constant_B_ += std::visit(Circumstances{branch, branch, any_attitude, any_rate, J_total_B_, orbit_rate_}, d);
    } else {
      varying_.push_back(i);  // never beyond the capacity reserved at construction
    }
  }
}

Vec3<double> Disturbances::torque_B(double t, const Quat<double>& q_NB, const Vec3<double>& omega_BN_B) const noexcept {
  Vec3<double> sum = constant_B_;
  for (const std::size_t i : varying_) {
    sum += std::visit(Circumstances{t, branch_, q_NB, omega_BN_B, J_total_B_, orbit_rate_, orbit(), dark_}, list_[i]);
  }
  return sum;
}

}  // namespace gyrostat::truth
