// SPDX-License-Identifier: MIT
// The allocation solver on arrays; `gyrostat.allocation` broadcasts to their full shapes.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "gyrostat/core/types.hpp"
#include "gyrostat/flight/allocators/parts/allocation_solver.hpp"
#include "gyrostat/flight/parts/served_geometry.hpp"

namespace gyrostat::bindings {
namespace {

namespace py = pybind11;
using namespace py::literals;
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Integers = py::array_t<int>;

/// What is the same for all problems of a batch.
struct Settings {
  AllocationMode mode;
  WorstCase worst_case;
  double residual_weight, margin, effectiveness_min, rank_tolerance;
  int max_newton;
  bool warm;
};

/// One row a problem; D is one for all, or one a problem.
struct Inputs {
  Numbers D, row_weight, demand, effectiveness, lo, up, preferred, effort_weight, bound;
  Integers priority;
  py::ssize_t rows() const { return demand.shape(1); }
  py::ssize_t actuators() const { return lo.shape(1); }
  py::ssize_t count() const { return demand.shape(0); }
};

struct Outputs {
  Numbers command, achieved, residual, multiplier, infeasibility_direction;
  Numbers residual_norm, residual_excess, theta, scale, worst_case, primal, dual, gap, residual_weight, seconds;
  py::array_t<bool> saturated;
  Integers newton, outer, status, warnings, rank;

  Outputs(py::ssize_t count, py::ssize_t rows, py::ssize_t n)
      : command({count, n}),
        achieved({count, rows}),
        residual({count, rows}),
        multiplier({count, rows}),
        infeasibility_direction({count, rows}),
        residual_norm(count),
        residual_excess(count),
        theta(count),
        scale(count),
        worst_case(count),
        primal(count),
        dual(count),
        gap(count),
        residual_weight(count),
        seconds(count),
        saturated({count, n}),
        newton(count),
        outer(count),
        status(count),
        warnings(count),
        rank(count) {}

  py::dict dict() const {
    return py::dict("command"_a = command, "achieved"_a = achieved, "residual"_a = residual,
                    "multiplier"_a = multiplier, "infeasibility_direction"_a = infeasibility_direction,
                    "residual_norm"_a = residual_norm, "residual_excess"_a = residual_excess, "theta"_a = theta,
                    "scale"_a = scale, "worst_case"_a = worst_case, "primal"_a = primal, "dual"_a = dual, "gap"_a = gap,
                    "residual_weight"_a = residual_weight, "seconds"_a = seconds, "saturated"_a = saturated,
                    "newton"_a = newton, "outer"_a = outer, "status"_a = status, "warnings"_a = warnings,
                    "rank"_a = rank);
  }
};

template <class Vector>
void put(const Vector& from, Numbers& to, py::ssize_t k) {
  double* row = to.mutable_data(k, 0);
  for (Eigen::Index i = 0; i < from.size(); ++i) row[i] = from[i];
}

/// Solves the batch in order with one solver.
template <int M>
class Batch {
 public:
  using Solver = AllocationSolver<double, M, max_actuators>;

  Batch(const Inputs& in, const Settings& settings) : in_(in), rank_tolerance_(settings.rank_tolerance) {
    p_.mode = settings.mode;
    p_.worst_case = settings.worst_case;
    p_.residual_weight = settings.residual_weight;
    p_.margin = settings.margin;
    if (settings.effectiveness_min >= 0) p_.effectiveness_min = settings.effectiveness_min;
    p_.max_newton = settings.max_newton;
    for (int r = 0; r < M; ++r) p_.priority[std::size_t(r)] = static_cast<std::uint8_t>(in.priority.at(r));
    warm_ = settings.warm;
    geometry_ = ServedGeometry<double>(p_.effectiveness_min, rank_tolerance_);
  }

  void run(Outputs& out) {
    typename Solver::State state;
    for (py::ssize_t k = 0; k < in_.count(); ++k) {
      pose(k);
      if (!warm_) state.reset();
      if (!warm_ || in_.D.shape(0) > 1) geometry_.reset();
      const Torque demand = p_.demand;
      const int rank = configure(k);
      const auto before = std::chrono::steady_clock::now();
      typename Solver::Solution s = solver_.solve(p_, state);
      out.seconds.mutable_at(k) = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
      if (rank < 3 && s.status != AllocationStatus::bad_input) add_dropped(demand, s);
      out.rank.mutable_at(k) = rank;
      collect(s, k, out);
    }
  }

 private:
  using Torque = typename Solver::Torque;

  template <class Vector>
  static void get(const Numbers& from, py::ssize_t k, py::ssize_t size, Vector& to) {
    const double* row = from.data(k, 0);
    for (py::ssize_t i = 0; i < size; ++i) to[static_cast<Eigen::Index>(i)] = row[i];
  }

  PerActuator<double, max_actuators> per_actuator(const Numbers& from, py::ssize_t k) const {
    PerActuator<double, max_actuators> out(static_cast<Eigen::Index>(in_.actuators()));
    get(from, k, in_.actuators(), out);
    return out;
  }

  /// Hands the geometry to the solver, as far as its axes are served, and drops the others from the demand. A geometry that is
  /// none makes no problem: the solver then refuses it. @return axes that are served
  int configure(py::ssize_t k) {
    const Eigen::Index n = static_cast<Eigen::Index>(in_.actuators());
    const py::ssize_t at = in_.D.shape(0) > 1 ? k : 0;
    D_.resize(M, n);
    for (Eigen::Index r = 0; r < M; ++r)
      for (Eigen::Index i = 0; i < n; ++i) D_(r, i) = in_.D.at(at, r, i);
    Torque weight;
    get(in_.row_weight, 0, M, weight);
    if (!D_.allFinite()) {
      solver_.configure(Solver::Geometry::Zero(M, n), weight);
      p_.demand.setConstant(std::numeric_limits<double>::quiet_NaN());
      return M;
    }
    if constexpr (M == 3) {
      if (rank_tolerance_ > 0) {
        geometry_.update(D_, Mask::all(static_cast<int>(n)), p_.effectiveness.cwiseMin(1.0));
        if (geometry_.rank() < 3) {
          solver_.configure(geometry_.projector() * D_, weight);
          p_.demand = geometry_.served(p_.demand);
          return geometry_.rank();
        }
      }
    }
    solver_.configure(D_, weight);
    return M;
  }

  /// What the command does along the axes that were dropped, and what was asked there.
  void add_dropped(const Torque& demand, typename Solver::Solution& s) const {
    s.achieved.setZero();
    for (Eigen::Index i = 0; i < D_.cols(); ++i)
      s.achieved += D_.col(i) * (std::min(p_.effectiveness[i], 1.0) * s.command[i]);
    s.residual = demand - s.achieved;
    const bool asked = (demand - p_.demand).norm() > 64 * std::numeric_limits<double>::epsilon() * demand.norm();
    if (asked && s.status == AllocationStatus::optimal) s.status = AllocationStatus::optimal_reduced;
  }

  void pose(py::ssize_t k) {
    get(in_.demand, k, M, p_.demand);
    p_.effectiveness = per_actuator(in_.effectiveness, k);
    p_.lo = per_actuator(in_.lo, k);
    p_.up = per_actuator(in_.up, k);
    p_.preferred = per_actuator(in_.preferred, k);
    p_.effort_weight = per_actuator(in_.effort_weight, k);
    p_.bound = per_actuator(in_.bound, k);
  }

  void collect(const typename Solver::Solution& s, py::ssize_t k, Outputs& out) const {
    put(s.command, out.command, k);
    put(s.achieved, out.achieved, k);
    put(s.residual, out.residual, k);
    put(s.multiplier, out.multiplier, k);
    put(s.infeasibility_direction, out.infeasibility_direction, k);
    out.residual_norm.mutable_at(k) = s.residual_norm;
    out.residual_excess.mutable_at(k) = s.residual_excess;
    out.theta.mutable_at(k) = s.theta;
    out.scale.mutable_at(k) = s.scale;
    out.worst_case.mutable_at(k) = s.worst_case;
    out.primal.mutable_at(k) = s.primal;
    out.dual.mutable_at(k) = s.dual;
    out.gap.mutable_at(k) = s.gap;
    out.residual_weight.mutable_at(k) = s.residual_weight;
    for (py::ssize_t i = 0; i < in_.actuators(); ++i) out.saturated.mutable_at(k, i) = (s.saturated >> i & 1u) != 0u;
    out.newton.mutable_at(k) = s.newton;
    out.outer.mutable_at(k) = s.outer;
    out.status.mutable_at(k) = static_cast<int>(s.status);
    out.warnings.mutable_at(k) = s.warnings;
  }

  const Inputs& in_;
  double rank_tolerance_;
  Solver solver_;
  typename Solver::Geometry D_{M, 0};
  ServedGeometry<double> geometry_;
  typename Solver::Problem p_;
  bool warm_ = false;
};

void require(bool holds, const char* message) {
  if (!holds) throw std::invalid_argument(message);
}

void check_shapes(const Inputs& in) {
  require(in.demand.ndim() == 2 && in.lo.ndim() == 2 && in.D.ndim() == 3, "demand and lo must have two axes, D three");
  const py::ssize_t count = in.count(), rows = in.rows(), n = in.actuators();
  require(rows == 3 || rows == 6, "3 or 6 rows of torque");
  require(n >= 1 && n <= max_actuators, "1 to 16 actuators");
  require(in.D.shape(1) == rows && in.D.shape(2) == n && (in.D.shape(0) == count || in.D.shape(0) == 1),
          "D must be (1 or count, rows, actuators)");
  require(in.row_weight.ndim() == 2 && in.row_weight.shape(0) == 1 && in.row_weight.shape(1) == rows,
          "row_weight must be (1, rows)");
  for (py::ssize_t r = 0; r < rows; ++r)
    require(std::isfinite(in.row_weight.at(0, r)) && in.row_weight.at(0, r) > 0,
            "row_weight must be finite and positive");
  require(in.priority.size() == rows, "priority must have one number a row");
  for (const Numbers* a : {&in.effectiveness, &in.up, &in.preferred, &in.effort_weight, &in.bound, &in.lo})
    require(a->ndim() == 2 && a->shape(0) == count && a->shape(1) == n, "one row a problem, one column an actuator");
}

py::dict allocate(const Inputs& in, const Settings& settings) {
  check_shapes(in);
  Outputs out(in.count(), in.rows(), in.actuators());
  {
    const py::gil_scoped_release release;
    if (in.rows() == 6) {
      Batch<6>(in, settings).run(out);
    } else {
      Batch<3>(in, settings).run(out);
    }
  }
  return out.dict();
}

Numbers served_axes(const Numbers& A, double rank_tolerance) {
  require(A.ndim() == 2 && A.shape(0) == 3 && A.shape(1) <= max_actuators, "A must be (3, actuators), at most 16");
  const int n = static_cast<int>(A.shape(1));
  Mat3N<double> axes(3, n);
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index i = 0; i < n; ++i) axes(r, i) = A.at(r, i);
  ServedGeometry<double> geometry(0.0, rank_tolerance);
  geometry.update(axes, Mask::all(n), VecN<double>::Ones(n));
  Numbers out({3, 3});
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index c = 0; c < 3; ++c) out.mutable_at(r, c) = geometry.projector()(r, c);
  return out;
}

}  // namespace

void bind_allocation(py::module_& m) {
  m.def(
      "allocate",
      [](const Numbers& D, const Numbers& row_weight, const Numbers& demand, const Numbers& effectiveness,
         const Numbers& lo, const Numbers& up, const Numbers& preferred, const Numbers& effort_weight,
         const Numbers& bound, const Integers& priority, int mode, int worst_case, double residual_weight,
         double margin, double effectiveness_min, double rank_tolerance, int max_newton, bool warm) {
        require(mode >= 0 && mode <= 3 && worst_case >= 0 && worst_case <= 2, "no such mode or worst case");
        return allocate({D, row_weight, demand, effectiveness, lo, up, preferred, effort_weight, bound, priority},
                        {static_cast<AllocationMode>(mode), static_cast<WorstCase>(worst_case), residual_weight, margin,
                         effectiveness_min, rank_tolerance, max_newton, warm});
      },
      "D"_a, "row_weight"_a, "demand"_a, "effectiveness"_a, "lo"_a, "up"_a, "preferred"_a, "effort_weight"_a, "bound"_a,
      "priority"_a, "mode"_a, "worst_case"_a, "residual_weight"_a, "margin"_a, "effectiveness_min"_a,
      "rank_tolerance"_a, "max_newton"_a, "warm"_a,
      "Solve a batch of allocation problems; use gyrostat.allocation.solve. Arrays have one row a problem; releases "
      "the "
      "GIL.");
  m.def(
      "served_axes", &served_axes, "A"_a, "rank_tolerance"_a,
      "Projector (3, 3) onto the axes of torque that allocators serve with A = D diag(effectiveness), (3, actuators).");
  m.attr("default_rank_tolerance") = default_rank_tolerance<double>;
}

}  // namespace gyrostat::bindings
