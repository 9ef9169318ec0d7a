// SPDX-License-Identifier: MIT
/// @file  FMI 2.0 co-simulation of a flight stack. The inputs are sampled when a step begins; the outputs hold from there to its
///        end. Parameters can be set until initialisation ends.
#include <cmath>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "fmi2.h"
#include "fmu_model.hpp"
#include "gyrostat/flight/facade.hpp"

#define FMI2_EXPORT extern "C" __attribute__((visibility("default")))

namespace {

using fmu_model::Flight;
using fmu_model::Parameter;
using fmu_model::Type;
using Memory = gyrostat::CallerMemory<Flight::Stack>;
constexpr int n = Flight::actuators;

enum class State { instantiated, initializing, stepping, terminated };

struct Instance {
  char name[256];
  fmi2CallbackFunctions callbacks;
  bool logging;
  State state;
  double start_time;   // s
  std::uint64_t tick;  // samples flown
  double values[fmu_model::variables];
  unsigned char memory[Memory::bytes];
};

struct Measured {
  std::uint64_t tick;
  double q_NB[4], omega_BN_B[3], h_w[n];
};
struct Wanted {
  double q_NR[4], omega_RN_R[3], omegadot_RN_R[3];
  std::uint32_t event;
};
struct Command {
  double u[n], demand_B[3], achieved_B[3];
  std::uint16_t saturated, status;
};
struct Known {
  double q_NB[4], omega_BN_B[3], d_B[3], effectiveness[n], effectiveness_bound[n];
  std::uint16_t changed, failed, enabled;
  std::uint32_t events;
};

/// Tells the master why; none of our texts has a per cent sign that it would take for a format.
fmi2Status refuse(const Instance& it, const char* format, ...) {
  char text[512];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  if (it.callbacks.logger != nullptr)
    it.callbacks.logger(it.callbacks.componentEnvironment, it.name, fmi2Error, "logStatusError", text);
  return fmi2Error;
}

/// Reads the values of one signal after another.
class Reader {
 public:
  explicit Reader(const double* at) : at_(at) {}
  template <std::size_t N>
  void operator()(double (&out)[N]) {
    for (double& x : out) x = *at_++;
  }
  double one() { return *at_++; }

 private:
  const double* at_;
};

/// Writes them.
class Writer {
 public:
  explicit Writer(double* at) : at_(at) {}
  template <std::size_t N>
  void operator()(const double (&in)[N]) {
    for (const double x : in) *at_++ = x;
  }
  void operator()(double x) { *at_++ = x; }

 private:
  double* at_;
};

void restart(Instance& it) {
  it.state = State::instantiated;
  it.start_time = 0.0;
  it.tick = 0;
  std::memcpy(it.values, fmu_model::start, sizeof it.values);
  std::memset(it.memory, 0, sizeof it.memory);
}

bool set_one(Flight::Parameters& p, const Parameter& what, const double* value) {
  switch (what.role) {
    case Parameter::observer:
      return gyrostat::set_parameter(p.observer, what.name, value, what.count);
    case Parameter::detector:
      return gyrostat::set_parameter(p.detector, what.name, value, what.count);
    case Parameter::controller:
      return gyrostat::set_parameter(p.controller, what.name, value, what.count);
    case Parameter::allocator:
      return gyrostat::set_parameter(p.allocator, what.name, value, what.count);
  }
  return false;
}

fmi2Status make_stack(Instance& it) {
  static constexpr const char* roles[] = {"observer", "detector", "controller", "allocator"};
  Flight::Parameters p = Flight::parameters();
  for (int i = 0; i < fmu_model::parameter_count; ++i) {
    const Parameter& what = fmu_model::parameters[i];
    if (!set_one(p, what, it.values + what.first))
      return refuse(it, "%s.%s = %.17g is outside its range", roles[what.role], what.name, it.values[what.first]);
  }
  const gyrostat::Status<double> status = Flight::check(p);
  if (!status.ok())
    return refuse(it, "%s = %.6g, must be %s %.6g", status.quantity, status.value, status.relation, status.limit);
  (void)Memory::make(it.memory, Flight::make(p));
  return fmi2OK;
}

void write_outputs(Instance& it, const Flight::Stack& stack) {
  Command c;
  Known k;
  gyrostat::to_plain(stack.last(), c);
  gyrostat::to_plain(stack.estimate(), stack.detection(), k);
  Writer out(it.values + fmu_model::first_output);
  out(c.u);
  out(c.achieved_B);
  out(c.saturated);
  out(c.status);
  out(c.demand_B);
  out(k.q_NB);
  out(k.omega_BN_B);
  out(k.d_B);
  out(k.effectiveness);
  out(k.effectiveness_bound);
  out(k.changed);
  out(k.failed);
  out(k.enabled);
  out(k.events);
}

void fly_one_sample(Instance& it, Flight::Stack& stack) {
  Measured y;
  Wanted ref;
  y.tick = it.tick++;
  Reader in(it.values + fmu_model::first_input);
  in(y.q_NB);
  in(y.omega_BN_B);
  in(y.h_w);
  in(ref.q_NR);
  in(ref.omega_RN_R);
  in(ref.omegadot_RN_R);
  ref.event = static_cast<std::uint32_t>(in.one());
  stack.step(gyrostat::measurement_from<double>(y), gyrostat::reference_from<double>(ref));
}

template <class T>
fmi2Status get(fmi2Component c, Type type, const fmi2ValueReference* which, std::size_t count, T* out) {
  const Instance& it = *static_cast<Instance*>(c);
  for (std::size_t i = 0; i < count; ++i) {
    if (which[i] >= fmu_model::variables || fmu_model::types[which[i]] != type)
      return refuse(it, "no variable of this type has value reference %u", which[i]);
    out[i] = static_cast<T>(it.values[which[i]]);
  }
  return fmi2OK;
}

template <class T>
fmi2Status set(fmi2Component c, Type type, const fmi2ValueReference* which, std::size_t count, const T* in) {
  Instance& it = *static_cast<Instance*>(c);
  for (std::size_t i = 0; i < count; ++i) {
    if (which[i] >= fmu_model::variables || fmu_model::types[which[i]] != type)
      return refuse(it, "no variable of this type has value reference %u", which[i]);
    if (which[i] >= fmu_model::first_output) return refuse(it, "value reference %u is an output", which[i]);
    if (which[i] < fmu_model::first_input && it.state != State::instantiated && it.state != State::initializing)
      return refuse(it, "a parameter (value reference %u) cannot change once initialisation has ended", which[i]);
    it.values[which[i]] = static_cast<double>(in[i]);
  }
  return fmi2OK;
}

fmi2Status move(fmi2Component c, State from, State to, const char* call) {
  Instance& it = *static_cast<Instance*>(c);
  if (it.state != from) return refuse(it, "%s: not allowed in this state", call);
  it.state = to;
  return fmi2OK;
}

fmi2Status unsupported(fmi2Component c, const char* what) {
  return refuse(*static_cast<Instance*>(c), "%s is not supported; modelDescription.xml says so", what);
}

}  // namespace

FMI2_EXPORT const char* fmi2GetTypesPlatform() { return "default"; }
FMI2_EXPORT const char* fmi2GetVersion() { return "2.0"; }

FMI2_EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String,
                                          const fmi2CallbackFunctions* callbacks, fmi2Boolean, fmi2Boolean logging) {
  if (callbacks == nullptr) return nullptr;
  void* memory = std::calloc(1, sizeof(Instance));
  if (memory == nullptr) return nullptr;
  Instance* it = static_cast<Instance*>(memory);
  std::snprintf(it->name, sizeof it->name, "%s", name != nullptr ? name : "");
  it->callbacks = *callbacks;
  it->logging = logging != fmi2False;
  const bool right_type = type == fmi2CoSimulation,
             right_guid = guid != nullptr && std::strcmp(guid, fmu_model::guid) == 0;
  if (!right_type || !right_guid) {
    refuse(*it, right_type ? "the guid is not that of this unit" : "this unit is for co-simulation only");
    std::free(it);
    return nullptr;
  }
  restart(*it);
  return it;
}
FMI2_EXPORT void fmi2FreeInstance(fmi2Component c) { std::free(c); }
FMI2_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, std::size_t, const fmi2String*) {
  static_cast<Instance*>(c)->logging = on != fmi2False;
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean, fmi2Real, fmi2Real start, fmi2Boolean,
                                           fmi2Real) {
  Instance& it = *static_cast<Instance*>(c);
  if (it.state != State::instantiated) return refuse(it, "fmi2SetupExperiment: not allowed in this state");
  it.start_time = start;
  return fmi2OK;
}
FMI2_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  return move(c, State::instantiated, State::initializing, "fmi2EnterInitializationMode");
}
FMI2_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  Instance& it = *static_cast<Instance*>(c);
  if (it.state != State::initializing) return refuse(it, "fmi2ExitInitializationMode: not allowed in this state");
  if (make_stack(it) != fmi2OK) return fmi2Error;
  write_outputs(it, *Memory::get(it.memory));
  it.state = State::stepping;
  return fmi2OK;
}
FMI2_EXPORT fmi2Status fmi2Terminate(fmi2Component c) {
  return move(c, State::stepping, State::terminated, "fmi2Terminate");
}
FMI2_EXPORT fmi2Status fmi2Reset(fmi2Component c) {
  restart(*static_cast<Instance*>(c));
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean) {
  Instance& it = *static_cast<Instance*>(c);
  Flight::Stack* stack = Memory::get(it.memory);
  if (it.state != State::stepping || stack == nullptr) return refuse(it, "fmi2DoStep: not initialised");
  const double dt = Flight::dt, periods = std::round(step / dt);
  // A master adds up its steps: what rounding leaves of a period is no mistake, a millionth of a period is.
  if (!(periods >= 1.0 && periods <= 1e9 && std::fabs(step - periods * dt) <= 1e-6 * dt))
    return refuse(it, "step size %.9g s is not a whole number of periods of %.9g s", step, dt);
  const double due = it.start_time + static_cast<double>(it.tick) * dt;
  if (!(std::fabs(time - due) <= 1e-3 * dt))
    return refuse(it, "a step from %.9g s; the next sample is due at %.9g s, and no step can be repeated", time, due);
  for (double left = periods; left > 0.0; left -= 1.0) fly_one_sample(it, *stack);
  write_outputs(it, *stack);
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference* which, std::size_t count, fmi2Real* out) {
  return get(c, Type::real, which, count, out);
}
FMI2_EXPORT fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference* which, std::size_t count,
                                      fmi2Integer* out) {
  return get(c, Type::integer, which, count, out);
}
FMI2_EXPORT fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference* which, std::size_t count,
                                      fmi2Boolean* out) {
  return get(c, Type::boolean, which, count, out);
}
FMI2_EXPORT fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference*, std::size_t count, fmi2String*) {
  return count == 0 ? fmi2OK : unsupported(c, "fmi2GetString");
}
FMI2_EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference* which, std::size_t count,
                                   const fmi2Real* in) {
  return set(c, Type::real, which, count, in);
}
FMI2_EXPORT fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference* which, std::size_t count,
                                      const fmi2Integer* in) {
  return set(c, Type::integer, which, count, in);
}
FMI2_EXPORT fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference* which, std::size_t count,
                                      const fmi2Boolean* in) {
  return set(c, Type::boolean, which, count, in);
}
FMI2_EXPORT fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference*, std::size_t count, const fmi2String*) {
  return count == 0 ? fmi2OK : unsupported(c, "fmi2SetString");
}

// Optional capabilities that this unit does not have.
FMI2_EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate*) { return unsupported(c, "fmi2GetFMUstate"); }
FMI2_EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate) { return unsupported(c, "fmi2SetFMUstate"); }
FMI2_EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate*) { return unsupported(c, "fmi2FreeFMUstate"); }
FMI2_EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate, std::size_t*) {
  return unsupported(c, "fmi2SerializedFMUstateSize");
}
FMI2_EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate, fmi2Byte*, std::size_t) {
  return unsupported(c, "fmi2SerializeFMUstate");
}
FMI2_EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte*, std::size_t, fmi2FMUstate*) {
  return unsupported(c, "fmi2DeSerializeFMUstate");
}
FMI2_EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference*, std::size_t,
                                                    const fmi2ValueReference*, std::size_t, const fmi2Real*,
                                                    fmi2Real*) {
  return unsupported(c, "fmi2GetDirectionalDerivative");
}
FMI2_EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference*, std::size_t,
                                                   const fmi2Integer*, const fmi2Real*) {
  return unsupported(c, "fmi2SetRealInputDerivatives");
}
FMI2_EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference*, std::size_t,
                                                    const fmi2Integer*, fmi2Real*) {
  return unsupported(c, "fmi2GetRealOutputDerivatives");
}
FMI2_EXPORT fmi2Status fmi2CancelStep(fmi2Component c) { return unsupported(c, "fmi2CancelStep"); }

// No step is ever pending.
FMI2_EXPORT fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind, fmi2Status*) {
  return unsupported(c, "fmi2GetStatus");
}
FMI2_EXPORT fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real* out) {
  const Instance& it = *static_cast<Instance*>(c);
  if (kind != fmi2LastSuccessfulTime) return unsupported(c, "fmi2GetRealStatus of this kind");
  *out = it.start_time + static_cast<double>(it.tick) * Flight::dt;
  return fmi2OK;
}
FMI2_EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind, fmi2Integer*) {
  return unsupported(c, "fmi2GetIntegerStatus");
}
FMI2_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean* out) {
  if (kind != fmi2Terminated) return unsupported(c, "fmi2GetBooleanStatus of this kind");
  *out = fmi2False;
  return fmi2OK;
}
FMI2_EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind, fmi2String*) {
  return unsupported(c, "fmi2GetStringStatus");
}
