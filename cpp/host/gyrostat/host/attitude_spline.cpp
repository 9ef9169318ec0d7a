// SPDX-License-Identifier: MIT
#include "gyrostat/host/attitude_spline.hpp"

#include <cmath>
#include <utility>

#include "gyrostat/core/attitude.hpp"

namespace gyrostat::host {

RotationVectorMotion RotationVectorMotion::of(const Vec3<double>& p, const Vec3<double>& v, const Vec3<double>& a) {
  const double n2 = p.squaredNorm(), n = std::sqrt(n2), k = p.dot(v);
  double A, B, A1, B1;  // A1 = A'/k, B1 = B'/k
  if (n < 0.05) {
    A = 1.0 / 2 - n2 * (1.0 / 24 - n2 / 720);
    B = 1.0 / 6 - n2 * (1.0 / 120 - n2 / 5040);
    A1 = -1.0 / 12 + n2 * (1.0 / 180 - n2 / 6720);
    B1 = -1.0 / 60 + n2 * (1.0 / 1260 - n2 / 60480);
  } else {
    const double s = std::sin(n), c = std::cos(n);
    A = (1 - c) / n2;
    B = (n - s) / (n2 * n);
    A1 = (n * s - 2 * (1 - c)) / (n2 * n2);
    B1 = (3 * s - n * (2 + c)) / (n2 * n2 * n);
  }
  const Vec3<double> pv = p.cross(v), pa = p.cross(a), ppv = p.cross(pv);
  return {v - A * pv + B * ppv, a - A * pa - k * A1 * pv + B * (v.cross(pv) + p.cross(pa)) + k * B1 * ppv};
}

Vec3<double> RotationVectorMotion::rate_of(const Vec3<double>& p, const Vec3<double>& w) {
  const double n2 = p.squaredNorm(), n = std::sqrt(n2);
  const double k = n < 0.05 ? 1.0 / 12 + n2 * (1.0 / 720 + n2 / 30240) : (1 - n / 2 / std::tan(n / 2)) / n2;
  return w + p.cross(w) / 2 + k * p.cross(p.cross(w));
}

AttitudeSpline::AttitudeSpline(std::vector<double> times, std::vector<Quat<double>> rows,
                               std::vector<Vec3<double>> rates)
    : times_(std::move(times)), q_(std::move(rows)), omega_(std::move(rates)) {
  for (std::size_t i = 1; i < q_.size(); ++i) {
    if (q_[i].dot(q_[i - 1]) < 0) q_[i].coeffs() = -q_[i].coeffs();
    turns_.push_back(quat_log<double>(q_[i - 1].conjugate() * q_[i]));
  }
  if (!omega_.empty()) return;
  omega_.push_back(turns_.front() / span(0));
  for (std::size_t i = 1; i < turns_.size(); ++i) {
    const double before = span(i - 1), after = span(i);
    omega_.emplace_back((turns_[i - 1] / before * after + turns_[i] / after * before) / (before + after));
  }
  omega_.push_back(turns_.back() / span(turns_.size() - 1));
}

double AttitudeSpline::turn(std::size_t i) const { return turns_[i].norm(); }

Reference<double> AttitudeSpline::at(double t) const {
  Reference<double> r;
  const bool before = t < times_.front() - 1e-9;
  if (before || t >= times_.back() - 1e-9) {
    r.q_NR = before ? q_.front() : q_.back();
    return r;
  }
  std::size_t i = 0;
  while (times_[i + 1] <= t + 1e-9) ++i;
  const double h = span(i), u = (t - times_[i]) / h;
  const Vec3<double>&w = omega_[i], &L = turns_[i], end = RotationVectorMotion::rate_of(L, omega_[i + 1]);
  const Vec3<double> p = (u * (1 - u) * (1 - u) * h) * w + (u * u * (3 - 2 * u)) * L + (u * u * (u - 1) * h) * end;
  const Vec3<double> v = ((1 - u) * (1 - 3 * u)) * w + (6 * u * (1 - u) / h) * L + (u * (3 * u - 2)) * end;
  const Vec3<double> a = ((6 * u - 4) / h) * w + ((6 - 12 * u) / (h * h)) * L + ((6 * u - 2) / h) * end;
  const RotationVectorMotion m = RotationVectorMotion::of(p, v, a);
  r.q_NR = q_[i] * quat_exp<double>(p);
  r.omega_RN_R = m.omega;
  r.omegadot_RN_R = m.omegadot;
  return r;
}

}  // namespace gyrostat::host
