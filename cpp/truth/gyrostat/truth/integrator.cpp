// SPDX-License-Identifier: MIT
#include "gyrostat/truth/integrator.hpp"

#include <algorithm>

#include "sundials_compat.hpp"

namespace gyrostat::truth {
namespace {

constexpr long max_steps = 200'000;  // of one advance: ends a run that would creep for ever

/// The corrector iterates to this fraction of the error test. CVODE's own 0.1 lets the iteration's error add up over a
/// long free run: ours halves the error at the end and needs fewer steps.
constexpr double corrector_fraction = 0.01;

std::string stopped(int flag) { return "CVODE stopped (flag " + std::to_string(flag) + ")"; }

struct Call {
  Rhs rhs = nullptr;
  const void* context = nullptr;
};

}  // namespace

extern "C" {
static int gyrostat_cvode_rhs(sunrealtype t, N_Vector y, N_Vector ydot, void* user) {
  const Call* call = static_cast<const Call*>(user);
  call->rhs(t, NV_DATA_S(y), NV_DATA_S(ydot), call->context);
  return 0;
}
}

IntegrationError::IntegrationError(double time_in, const std::string& why)
    : std::runtime_error(why + " at t = " + std::to_string(time_in) + " s"), time(time_in) {}

struct CvodeSolver::Memory {
  SUNContext context = nullptr;
  N_Vector y = nullptr;
  SUNNonlinearSolver solver = nullptr;
  void* cvode = nullptr;
  int states = 0;
  double t = 0;
  Call call;
  IntegratorStatistics before_restart;

  Memory() = default;
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory() {
    CVodeFree(&cvode);
    SUNNonlinSolFree(solver);
    N_VDestroy(y);
    SUNContext_Free(&context);
  }

  IntegratorStatistics since_restart() const {
    long steps = 0, evaluations = 0;
    CVodeGetNumSteps(cvode, &steps);
    CVodeGetNumRhsEvals(cvode, &evaluations);
    return {static_cast<std::uint64_t>(steps), static_cast<std::uint64_t>(evaluations), 0, 0};
  }
};

CvodeSolver::CvodeSolver(const Cvode& options, int states) : memory_(std::make_unique<Memory>()) {
  Memory& m = *memory_;
  m.states = states;
  const auto require = [](bool ok, const char* what) {
    if (!ok) throw std::runtime_error(std::string("CVODE: cannot ") + what);
  };
  m.context = make_context();
  require(m.context != nullptr, "create a context");
  m.y = N_VNew_Serial(states, m.context);
  require(m.y != nullptr, "create a vector");
  N_VConst(0, m.y);
  m.cvode = CVodeCreate(CV_ADAMS, m.context);
  require(m.cvode != nullptr, "create its memory");
  silence(m.cvode);
  require(CVodeInit(m.cvode, gyrostat_cvode_rhs, 0, m.y) == CV_SUCCESS, "be initialised");
  require(CVodeSStolerances(m.cvode, options.rtol, options.atol) == CV_SUCCESS, "use these tolerances");
  require(CVodeSetUserData(m.cvode, &m.call) == CV_SUCCESS, "be told its user data");
  require(CVodeSetMaxNumSteps(m.cvode, max_steps) == CV_SUCCESS, "be told its step limit");
  require(CVodeSetNonlinConvCoef(m.cvode, corrector_fraction) == CV_SUCCESS, "be told its corrector's tolerance");
  m.solver = SUNNonlinSol_FixedPoint(m.y, 0, m.context);
  require(m.solver != nullptr && CVodeSetNonlinearSolver(m.cvode, m.solver) == CV_SUCCESS, "use a fixed-point solver");
}

CvodeSolver::~CvodeSolver() = default;
CvodeSolver::CvodeSolver(CvodeSolver&&) noexcept = default;
CvodeSolver& CvodeSolver::operator=(CvodeSolver&&) noexcept = default;

void CvodeSolver::restart(double t, const double* y) {
  Memory& m = *memory_;
  const IntegratorStatistics s = m.since_restart();
  m.before_restart.steps += s.steps;
  m.before_restart.rhs_evaluations += s.rhs_evaluations;
  ++m.before_restart.restarts;
  std::copy_n(y, m.states, NV_DATA_S(m.y));
  m.t = t;
  if (const int flag = CVodeReInit(m.cvode, t, m.y); flag != CV_SUCCESS) throw IntegrationError(t, stopped(flag));
}

void CvodeSolver::advance(Rhs rhs, const void* context, double t_end, double* y) {
  Memory& m = *memory_;
  m.call = {rhs, context};
  CVodeSetStopTime(m.cvode, t_end);
  double reached = m.t;
  const int flag = CVode(m.cvode, t_end, m.y, &reached, CV_NORMAL);
  if (flag < 0) throw IntegrationError(reached, stopped(flag));
  m.t = t_end;
  std::copy_n(NV_DATA_S(m.y), m.states, y);
}

std::uint64_t CvodeSolver::steps() const noexcept {
  long now = 0;
  CVodeGetNumSteps(memory_->cvode, &now);
  return memory_->before_restart.steps + static_cast<std::uint64_t>(now);
}

IntegratorStatistics CvodeSolver::statistics() const {
  const IntegratorStatistics now = memory_->since_restart(), before = memory_->before_restart;
  return {before.steps + now.steps, before.rhs_evaluations + now.rhs_evaluations, before.restarts, 0};
}

}  // namespace gyrostat::truth
