// SPDX-License-Identifier: MIT
/// @file  Judges allocations from their numbers alone, in extended precision. Knows nothing of the library: no header of it is
///        included, and none of its formulas' code is shared.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

namespace certificate {

using Real = long double;
using Vector = std::vector<Real>;
using Matrix = std::vector<Vector>;  // a row each

/// minimise over lo <= t <= up: effort 1/2 sum p (t - preferred)^2 and |A t - u|. A and u carry the row weights.
struct Problem {
  Matrix A;  // weighted axes times effectiveness
  Matrix D;  // weighted axes of the actuators that can act
  Matrix A_unweighted;
  Vector demand, row_weight;  // demand: unweighted
  Vector u, lo, up, preferred, p;
  Vector g;  // bound times effectiveness
  std::size_t rows() const { return A.size(); }
  std::size_t actuators() const { return lo.size(); }
};

inline Real dot(const Vector& a, const Vector& b) {
  Real sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}
inline Real norm(const Vector& a) { return std::sqrt(dot(a, a)); }
inline Vector transposed_times(const Matrix& A, const Vector& y) {
  Vector out(A[0].size(), 0);
  for (std::size_t r = 0; r < A.size(); ++r)
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += A[r][i] * y[r];
  return out;
}
/// u - A t
inline Vector residual(const Problem& q, const Vector& t) {
  Vector r = q.u;
  for (std::size_t j = 0; j < r.size(); ++j) r[j] -= dot(q.A[j], t);
  return r;
}
inline Real effort(const Problem& q, const Vector& t) {
  Real sum = 0;
  for (std::size_t i = 0; i < t.size(); ++i) sum += q.p[i] * (t[i] - q.preferred[i]) * (t[i] - q.preferred[i]) / 2;
  return sum;
}
/// sum over actuators of  min over the box of  p/2 (t - preferred)^2 + slope t
inline Real box_minimum(const Problem& q, const Vector& slope) {
  Real sum = 0;
  for (std::size_t i = 0; i < slope.size(); ++i) {
    const Real t = std::min(std::max(q.preferred[i] - slope[i] / q.p[i], q.lo[i]), q.up[i]);
    sum += q.p[i] * (t - q.preferred[i]) * (t - q.preferred[i]) / 2 + slope[i] * t;
  }
  return sum;
}
/// max over the box of v'A t
inline Real support(const Problem& q, const Matrix& A, const Vector& v) {
  Real sum = 0;
  const Vector reach = transposed_times(A, v);
  for (std::size_t i = 0; i < reach.size(); ++i) sum += std::max(reach[i] * q.lo[i], reach[i] * q.up[i]);
  return sum;
}
inline Real box_violation(const Problem& q, const Vector& t) {
  Real worst = 0;
  for (std::size_t i = 0; i < t.size(); ++i) worst = std::max({worst, q.lo[i] - t[i], t[i] - q.up[i]});
  return worst;
}
/// Size of the torques in play: rounding is measured against it.
inline Real scale(const Problem& q) {
  Real sum = 0;
  for (std::size_t i = 0; i < q.lo.size(); ++i) {
    Real column = 0;
    for (const Vector& row : q.A) column = std::max(column, std::abs(row[i]));
    sum += column * std::max(std::abs(q.lo[i]), std::abs(q.up[i]));
  }
  for (const Real x : q.u) sum = std::max(sum, std::abs(x));
  return sum;
}

// Closest torque -------------------------------------------------------------------------------------------------------

/// |u - A t| less the bound that v proves: |u - A t'| >= (v'u - support(v)) / |v| for every t' in the box.
inline Real residual_excess(const Problem& q, const Vector& t, const Vector& v) {
  const Real bound = norm(v) > 0 ? (dot(v, q.u) - support(q, q.A, v)) / norm(v) : 0;
  return norm(residual(q, t)) - std::max<Real>(bound, 0);
}
/// The same from a direction in unweighted torque.
inline Real unweighted_excess(const Problem& q, const Vector& t, const Vector& direction) {
  Vector v = direction;
  for (std::size_t r = 0; r < v.size(); ++r) v[r] /= q.row_weight[r];
  return residual_excess(q, t, v);
}
/// Effort less its bound among all t' in the box with A t' = A t.
inline Real effort_gap(const Problem& q, const Vector& t, const Vector& y) {
  Vector slope = transposed_times(q.A, y);
  const Real at_target = dot(slope, t);
  for (Real& s : slope) s = -s;
  return effort(q, t) - (at_target + box_minimum(q, slope));
}

// Weighted least squares -----------------------------------------------------------------------------------------------

inline Real wls_primal(const Problem& q, const Vector& t, Real gamma) {
  const Vector r = residual(q, t);
  return effort(q, t) + gamma * dot(r, r) / 2;
}
inline Real wls_dual(const Problem& q, const Vector& y, Real gamma) {
  Vector slope = transposed_times(q.A, y);
  for (Real& s : slope) s = -s;
  return dot(y, q.u) - dot(y, y) / (2 * gamma) + box_minimum(q, slope);
}

// Worst case -----------------------------------------------------------------------------------------------------------

/// Eigenvalues and eigenvectors (in rows) of a symmetric matrix, by Jacobi rotations.
inline void jacobi(Matrix S, Vector& values, Matrix& axes) {
  const std::size_t m = S.size();
  axes.assign(m, Vector(m, 0));
  for (std::size_t i = 0; i < m; ++i) axes[i][i] = 1;
  for (int sweep = 0; sweep < 60; ++sweep)
    for (std::size_t p = 0; p < m; ++p)
      for (std::size_t r = p + 1; r < m; ++r) {
        if (S[p][r] == 0) continue;
        const Real angle = std::atan2(2 * S[p][r], S[r][r] - S[p][p]) / 2, c = std::cos(angle), s = std::sin(angle);
        for (std::size_t k = 0; k < m; ++k) {
          const Real x = S[k][p], y = S[k][r];
          S[k][p] = c * x - s * y;
          S[k][r] = s * x + c * y;
        }
        for (std::size_t k = 0; k < m; ++k) {
          const Real x = S[p][k], y = S[r][k], a = axes[p][k], b = axes[r][k];
          S[p][k] = c * x - s * y;
          S[r][k] = s * x + c * y;
          axes[p][k] = c * a - s * b;
          axes[r][k] = s * a + c * b;
        }
      }
  values.resize(m);
  for (std::size_t i = 0; i < m; ++i) values[i] = S[i][i];
}

struct Spread {
  Vector values;
  Matrix axes;
  Real top = 0;  // largest eigenvalue of D D'
  explicit Spread(const Matrix& D) {
    Matrix S(D.size(), Vector(D.size(), 0));
    for (std::size_t a = 0; a < D.size(); ++a)
      for (std::size_t b = 0; b < D.size(); ++b) S[a][b] = dot(D[a], D[b]);
    jacobi(S, values, axes);
    for (Real& v : values) v = std::max<Real>(v, 0);
    top = *std::max_element(values.begin(), values.end());
  }
};

inline Real uncertain_norm(const Problem& q, const Vector& t) {
  Real sum = 0;
  for (std::size_t i = 0; i < t.size(); ++i) sum += q.g[i] * t[i] * q.g[i] * t[i];
  return std::sqrt(sum);
}
inline Real worst_bound(const Problem& q, const Spread& s, const Vector& t) {
  return norm(residual(q, t)) + std::sqrt(s.top) * uncertain_norm(q, t);
}
/// max of |r - D x| over |x| <= rho, by ternary search of its convex dual in one variable.
inline Real worst_exact(const Problem& q, const Spread& s, const Vector& t) {
  const Vector r = residual(q, t);
  const Real rho = uncertain_norm(q, t);
  if (rho == 0) return norm(r);
  const auto value = [&](Real theta) {
    Real sum = s.top * rho * rho / theta;
    for (std::size_t j = 0; j < r.size(); ++j) {
      const Real along = dot(s.axes[j], r), keep = 1 - theta * s.values[j] / s.top;
      if (along != 0) sum += keep > 0 ? along * along / keep : HUGE_VALL;
    }
    return sum;
  };
  Real lo = 0, up = 1;
  for (int k = 0; k < 300; ++k) {
    const Real a = lo + (up - lo) / 3, b = up - (up - lo) / 3;
    (value(a) < value(b) ? up : lo) = value(a) < value(b) ? b : a;
  }
  return std::sqrt(std::min({value(lo), value((lo + up) / 2), value(up)}));  // a pole may sit at 1
}

enum class Shape { bound, exact, constant };

inline Real robust_primal(const Problem& q, const Spread& s, const Vector& t, Real h, Shape shape, Real margin) {
  const Real worst = shape == Shape::bound   ? worst_bound(q, s, t)
                     : shape == Shape::exact ? worst_exact(q, s, t)
                                             : norm(residual(q, t)) + margin;
  return effort(q, t) + h * worst * worst / 2;
}
/// Lower bound of the robust objective from y and theta; t only chooses which bound.
inline Real robust_dual(const Problem& q, const Spread& s, const Vector& t, const Vector& y, Real theta, Real h,
                        Shape shape, Real margin) {
  Vector z = y;
  for (Real& v : z) v = -v / h;
  Vector slope = transposed_times(q.A, z);
  Real kappa2 = dot(z, z), extra = 0;
  if (shape == Shape::constant) {
    const Real kappa = std::max(norm(z), margin);
    kappa2 = kappa * kappa;
    extra = kappa * margin;
  } else if (theta > 0) {
    Real sigma2 = 0;
    for (std::size_t i = 0; i < t.size(); ++i) {
      const Real sigma = s.top * q.g[i] * t[i] / theta;
      sigma2 += sigma * sigma;
      slope[i] += q.g[i] * sigma;
    }
    const Vector Dz = transposed_times(q.D, z);
    const Real covered = shape == Shape::exact ? dot(Dz, Dz) : s.top * dot(z, z);
    kappa2 += std::max<Real>(0, sigma2 - covered) / s.top;
  }
  for (Real& v : slope) v *= h;
  return h * (extra - dot(z, q.u) - kappa2 / 2) + box_minimum(q, slope);
}

}  // namespace certificate
