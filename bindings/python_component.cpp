// SPDX-License-Identifier: MIT
#include "python_component.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <stdexcept>

#include <pybind11/eigen.h>

#include "gyrostat/host/value.hpp"
#include "numbers.hpp"

namespace gyrostat::bindings {
namespace {

namespace py = pybind11;

/// Owns the object; takes the GIL to let go of it.
struct Release {
  template <class Object>
  void operator()(Object* object) const {
    const py::gil_scoped_acquire gil;
    delete object;
  }
};
using Held = std::unique_ptr<py::object, Release>;

Held hold(const py::object& object) { return Held(new py::object(object)); }

/// Tells each object once what it flies on, whatever roles it plays.
class Begin {
 public:
  explicit Begin(Use use) : use_(use), told_(std::make_shared<std::set<const PyObject*>>()) {}
  bool flies() const noexcept { return use_ == Use::fly; }
  void operator()(const py::object& object, const Setup<double>& setup) const {
    if (flies() && py::hasattr(object, "setup") && told_->insert(object.ptr()).second) object.attr("setup")(setup);
  }

 private:
  Use use_;
  std::shared_ptr<std::set<const PyObject*>> told_;
};

/// "at t = 1.2 s"
std::string at_time(double t) { return "at t = " + host::number_text(t) + " s"; }

/// What is raised gets a note of where and when it was; its type and its text stay as they are.
/// @param where  says it, when asked
template <class... Args>
py::object called(const py::object& function, const auto& where, double t, Args&&... args) {
  try {
    return function(std::forward<Args>(args)...);
  } catch (const py::error_already_set& raised) {
    raised.value().attr("add_note")("in " + where() + " " + at_time(t));
    throw;
  }
}

/// What an object publishes: `telemetry()` gives a dictionary of numbers and vectors, of the same names and sizes at every sample.
class Telemetry final : public host::Reporting {
 public:
  /// Asks once, after `setup`: names and sizes are those of now.
  Telemetry(const py::object& object, const std::string& who, int actuators, const Begin& begin)
      : where_(who + ".telemetry") {
    if (!begin.flies() || !py::hasattr(object, "telemetry")) return;
    function_ = hold(object.attr("telemetry"));
    for (const auto& [key, value] : dictionary()) {
      if (!py::isinstance<py::str>(key) || !py::cast<bool>(key.attr("isidentifier")()))
        throw std::invalid_argument(where_ + " returned the name " + py::cast<std::string>(py::repr(key)) +
                                    "; the name of a signal is a text like those of variables");
      const std::string name = py::cast<std::string>(key);
      const Numbers array = vector(name, value);
      const auto n = static_cast<int>(array.size());
      if (n == 0) throw std::invalid_argument(where_ + " returned no number as '" + name + "'");
      const bool scalar = array.ndim() == 0;
      entries_.push_back({name, n, false, scalar ? "" : n == 3 ? "axis" : n == actuators ? "actuator" : ""});
    }
  }

  bool any() const noexcept { return !entries_.empty(); }
  void entries(std::vector<host::TelemetryEntry>& out) const final {
    out.insert(out.end(), entries_.begin(), entries_.end());
  }
  double* values(double* row) const final {
    if (entries_.empty()) return row;
    const py::gil_scoped_acquire gil;
    const py::dict now = dictionary();
    if (now.size() != entries_.size()) refuse_change(std::to_string(now.size()) + " signals", entries_.size());
    for (const host::TelemetryEntry& e : entries_) {
      const py::str key(e.name);
      if (!now.contains(key)) throw std::invalid_argument(where_ + " returned no '" + e.name + "' any more" + when());
      const Numbers array = vector(e.name, now[key]);
      if (array.size() != e.width)
        refuse_change(std::to_string(array.size()) + " numbers as '" + e.name + "'", static_cast<std::size_t>(e.width));
      row = std::copy_n(array.data(), e.width, row);
    }
    return row;
  }
  /// The object was called at t: what it publishes is of that time.
  void see(double t) noexcept { t_ = t; }

 private:
  std::string when() const { return " (" + at_time(t_) + ")"; }
  [[noreturn]] void refuse_change(const std::string& what, std::size_t before) const {
    throw std::invalid_argument(where_ + " returned " + what + ", and " + std::to_string(before) + " at the start" +
                                when());
  }
  py::dict dictionary() const {
    const py::object out = called(*function_, [this] { return where_; }, t_);
    if (py::isinstance<py::dict>(out)) return py::reinterpret_borrow<py::dict>(out);
    throw std::invalid_argument(where_ + " returned" + (out.is_none() ? " nothing (None)" : " a " + class_name(out)) +
                                "; a dictionary of numbers and vectors belongs there");
  }
  Numbers vector(const std::string& name, const py::handle& value) const {
    const auto refuse = [&](const std::string& what) {
      throw std::invalid_argument(where_ + " returned " + what + " as '" + name +
                                  "'; a number or a vector belongs there");
    };
    const auto object = py::reinterpret_borrow<py::object>(value);
    if (object.is_none()) refuse("nothing (None)");
    Numbers array;
    try {
      array = Numbers(object);
    } catch (const py::error_already_set&) {
      refuse("a " + class_name(object));
    }
    if (array.ndim() > 1) refuse("an array of " + std::to_string(array.ndim()) + " dimensions");
    return array;
  }

  std::string where_;
  Held function_;
  std::vector<host::TelemetryEntry> entries_;
  double t_ = 0;  ///< s, of the last call
};

/// A role that is no flight component: the object with one function, and what it says of a mistake.
struct PythonFunction {
  PythonFunction(const py::object& object, const Setup<double>& setup, const std::string& role, const char* name,
                 const Begin& begin)
      : who(role + " " + class_name(object)), where(who + "." + name), returned(where + " returned") {
    if (!py::hasattr(object, name)) throw std::invalid_argument(who + " has no " + name + "(...)");
    begin(object, setup);
    function = hold(object.attr(name));
    telemetry = std::make_shared<Telemetry>(object, who, setup.vehicle.actuators(), begin);
  }
  template <class... Args>
  py::object operator()(double t, Args&&... args) const {
    telemetry->see(t);
    return called(*function, [this] { return where; }, t, std::forward<Args>(args)...);
  }
  std::string who, where, returned;
  Held function;
  std::shared_ptr<Telemetry> telemetry;
};

/// Of a reference: `at(t)` gives q_NR, or (q_NR, omega_RN_R, omegadot_RN_R), or a Reference.
class PythonReference {
 public:
  explicit PythonReference(std::shared_ptr<PythonFunction> model) : model_(std::move(model)) {}

  Reference<double> operator()(Tick, double t) const {
    const py::gil_scoped_acquire gil;
    const py::object out = (*model_)(t, t);
    if (py::isinstance<Reference<double>>(out)) return py::cast<Reference<double>>(out);
    Reference<double> r;
    if (py::isinstance<py::tuple>(out) && py::len(out) == 3) {
      const py::tuple parts(out);
      attitude(parts[0], r);
      copy_numbers(parts[1], 3, r.omega_RN_R, model_->returned);
      copy_numbers(parts[2], 3, r.omegadot_RN_R, model_->returned);
    } else {
      attitude(out, r);
    }
    return r;
  }

 private:
  void attitude(const py::object& out, Reference<double>& r) const {
    Eigen::Vector4d q;
    copy_numbers(out, 4, q, model_->returned);
    r.q_NR = Quat<double>(q[0], q[1], q[2], q[3]);
  }
  std::shared_ptr<PythonFunction> model_;
};

/// Common half: the object with its functions, and what it says of a mistake.
template <class Base>
class PythonModel : public Base {
 public:
  PythonModel(const py::object& object, const Setup<double>& setup, const char* role, const Begin& begin)
      : setup_(setup), who_(std::string(role) + " " + class_name(object)), object_(hold(object)) {
    if (!py::hasattr(object, "step"))
      throw std::invalid_argument(std::string(role) + ": " + class_name(object) + " has no step(...)");
    begin(object, setup);
    step_ = function("step");
    start_ = function("start");
    telemetry_ = std::make_unique<Telemetry>(object, who_, actuators(), begin);
  }
  void entries(std::vector<host::TelemetryEntry>& out) const final { telemetry_->entries(out); }
  double* values(double* row) const final { return telemetry_->values(row); }

 protected:
  int actuators() const { return setup_.vehicle.actuators(); }
  Allocation<double> idle() const { return Allocation<double>::idle(actuators()); }

  /// Null where the object has none.
  Held function(const char* name) const { return py::hasattr(*object_, name) ? hold(object_->attr(name)) : nullptr; }

  std::string returned(const char* from) const { return who_ + "." + from + " returned"; }

  /// Of `from` at this tick.
  template <class... Args>
  py::object call(const Held& function, const char* from, Tick tick, const Args&... args) const {
    const double t = static_cast<double>(tick) * setup_.dt;
    telemetry_->see(t);
    return called(*function, [&] { return who_ + "." + from; }, t, args...);
  }

  /// What a function gave, when it is a signal of this kind.
  template <class Signal>
  Signal signal(const py::object& out, const char* from, const char* wanted) const {
    if (py::isinstance<Signal>(out)) return py::cast<Signal>(out);
    throw std::invalid_argument(returned(from) + (out.is_none() ? " nothing (None)" : " a " + class_name(out)) + "; " +
                                wanted + " belongs there");
  }

  void check_size(const VecN<double>& v, const char* from, const char* name, bool may_be_empty = false) const {
    if (v.size() == actuators() || (may_be_empty && v.size() == 0)) return;
    throw std::invalid_argument(returned(from) + " " + std::to_string(v.size()) + " numbers as " + name + "; " +
                                std::to_string(actuators()) + " belong there, one an actuator" +
                                (may_be_empty ? ", or none" : ""));
  }

  void check_members(Mask mask, const char* from, const char* name) const {
    for (int i = actuators(); i < max_actuators; ++i) {
      if (mask.test(i))
        throw std::invalid_argument(returned(from) + " actuator " + std::to_string(i) + " as " + name +
                                    "; the vehicle has 0 to " + std::to_string(actuators() - 1));
    }
  }

  Setup<double> setup_;
  std::string who_;
  Held object_, step_, start_;
  std::unique_ptr<Telemetry> telemetry_;
};

class PythonNavigator final : public PythonModel<host::NavigatorBase> {
 public:
  using PythonModel::PythonModel;
  Measurement<double> start(const Vehicle<double>&, const Measurement<double>& y) final {
    const py::gil_scoped_acquire gil;
    return start_ ? result(call(start_, "start", y.tick, y), "start", y) : stepped(y);
  }
  Measurement<double> step(const Vehicle<double>&, const Measurement<double>& y) final {
    const py::gil_scoped_acquire gil;
    return stepped(y);
  }

 private:
  Measurement<double> stepped(const Measurement<double>& y) const {
    return result(call(step_, "step", y.tick, y), "step", y);
  }
  Measurement<double> result(const py::object& out, const char* from, const Measurement<double>& sensed) const {
    Measurement<double> y = signal<Measurement<double>>(out, from, "a Measurement (the one it was given, changed)");
    check_size(y.h_w, from, "h_w");
    y.tick = sensed.tick;
    return y;
  }
};

class PythonObserver final : public PythonModel<host::ObserverBase> {
 public:
  PythonObserver(const py::object& object, const Setup<double>& setup, const char* role, const Begin& begin)
      : PythonModel(object, setup, role, begin), skip_(function("skip")), shift_rate_(function("shift_rate")) {}
  Estimate<double> start(const Vehicle<double>&, const Measurement<double>& y) final {
    const py::gil_scoped_acquire gil;
    return start_ ? result(call(start_, "start", y.tick, y), "start", y) : stepped(y, idle());
  }
  Estimate<double> step(const Vehicle<double>&, const Measurement<double>& y, const Allocation<double>& last) final {
    const py::gil_scoped_acquire gil;
    return stepped(y, last);
  }
  Estimate<double> skip(const Vehicle<double>&, const Measurement<double>& y, const Allocation<double>& last) final {
    const py::gil_scoped_acquire gil;
    return skip_ ? result(call(skip_, "skip", y.tick, y, last), "skip", y) : stepped(y, last);
  }
  void shift_rate(const Vec3<double>& step) final {
    if (!shift_rate_) return;
    const py::gil_scoped_acquire gil;
    (*shift_rate_)(Eigen::Vector3d(step));
  }

 private:
  Estimate<double> stepped(const Measurement<double>& y, const Allocation<double>& last) const {
    return result(call(step_, "step", y.tick, y, last), "step", y);
  }
  Estimate<double> result(const py::object& out, const char* from, const Measurement<double>& y) const {
    Estimate<double> x = signal<Estimate<double>>(out, from, "an Estimate (Estimate.healthy(y) makes one)");
    check_size(x.h_w, from, "h_w");
    check_size(x.effectiveness, from, "effectiveness");
    check_size(x.effectiveness_bound, from, "effectiveness_bound");
    x.tick = y.tick;
    return x;
  }

  Held skip_, shift_rate_;
};

class PythonDetector final : public PythonModel<host::DetectorBase> {
 public:
  using PythonModel::PythonModel;
  Detection<double> start(const Vehicle<double>&, const Estimate<double>& x) final {
    const py::gil_scoped_acquire gil;
    return start_ ? result(call(start_, "start", x.tick, x), "start") : stepped(x, idle());
  }
  Detection<double> step(const Vehicle<double>&, const Estimate<double>& x, const Allocation<double>& last) final {
    const py::gil_scoped_acquire gil;
    return stepped(x, last);
  }

 private:
  Detection<double> stepped(const Estimate<double>& x, const Allocation<double>& last) const {
    return result(call(step_, "step", x.tick, x, last), "step");
  }
  Detection<double> result(const py::object& out, const char* from) const {
    const auto det = signal<Detection<double>>(out, from, "a Detection (Detection.none(vehicle) makes one)");
    check_size(det.u_probe, from, "u_probe", true);
    check_size(det.gain, from, "gain", true);
    check_size(det.bias, from, "bias", true);
    check_members(det.changed, from, "changed");
    check_members(det.failed, from, "failed");
    check_members(det.enabled, from, "enabled");
    return det;
  }
};

class PythonController final : public PythonModel<host::ControllerBase> {
 public:
  using PythonModel::PythonModel;
  Demand<double> start(const Vehicle<double>&, const Estimate<double>& x, const Detection<double>& det,
                       const Reference<double>& ref) final {
    const py::gil_scoped_acquire gil;
    return start_ ? result(call(start_, "start", x.tick, x, det, ref), "start") : stepped(x, det, ref, idle());
  }
  Demand<double> step(const Vehicle<double>&, const Estimate<double>& x, const Detection<double>& det,
                      const Reference<double>& ref, const Allocation<double>& last) final {
    const py::gil_scoped_acquire gil;
    return stepped(x, det, ref, last);
  }

 private:
  Demand<double> stepped(const Estimate<double>& x, const Detection<double>& det, const Reference<double>& ref,
                         const Allocation<double>& last) const {
    return result(call(step_, "step", x.tick, x, det, ref, last), "step");
  }
  Demand<double> result(const py::object& out, const char* from) const {
    Demand<double> demand;
    if (py::isinstance<Demand<double>>(out)) {
      demand = py::cast<Demand<double>>(out);
      check_size(demand.u_pref, from, "u_pref", true);
    } else {
      copy_numbers(out, 3, demand.tau_B, returned(from));
    }
    return demand;
  }
};

class PythonAllocator final : public PythonModel<host::AllocatorBase> {
 public:
  PythonAllocator(const py::object& object, const Setup<double>& setup, const char* role, const Begin& begin)
      : PythonModel(object, setup, role, begin), reset_(function("reset")) {}
  void reset(const Vehicle<double>&) final {
    if (!reset_) return;
    const py::gil_scoped_acquire gil;
    (*reset_)();
  }
  Allocation<double> step(const Vehicle<double>&, const Demand<double>& demand, const Estimate<double>& x,
                          const Detection<double>& det) final {
    const py::gil_scoped_acquire gil;
    const py::object out = call(step_, "step", x.tick, demand, x, det);
    if (py::isinstance<Allocation<double>>(out)) {
      const Allocation<double> a = py::cast<Allocation<double>>(out);
      check_size(a.u, "step", "u");
      check_members(a.saturated, "step", "saturated");
      return a;
    }
    Allocation<double> a;
    copy_numbers(out, actuators(), a.u, returned("step"));
    a.demand_B = demand.tau_B;
    a.achieved_B = torque<double>(x.axes.of(setup_.vehicle.D_B), x.effectiveness.cwiseProduct(a.u));
    return a;
  }

 private:
  Held reset_;
};

template <class Model, class Base>
std::function<std::unique_ptr<Base>(const Setup<double>&)> factory(const py::dict& objects, const char* role,
                                                                   const Begin& begin) {
  if (!objects.contains(role)) return {};
  const std::shared_ptr<py::object> object(new py::object(objects[role]), Release{});
  return [object, role, begin](const Setup<double>& setup) -> std::unique_ptr<Base> {
    const py::gil_scoped_acquire gil;
    return std::make_unique<Model>(*object, setup, role, begin);
  };
}

using Functions = std::vector<std::shared_ptr<PythonFunction>>;

/// One role of what is no flight component, as it is made; what its objects publish is collected.
class Maker {
 public:
  Maker(const py::dict& objects, const Setup<double>& setup, const Begin& begin, host::Outside& outside)
      : objects_(objects), setup_(setup), begin_(begin), outside_(outside) {}

  std::shared_ptr<PythonFunction> one(const py::handle& object, const std::string& role, const char* name,
                                      const std::string& published_as) const {
    auto made =
        std::make_shared<PythonFunction>(py::reinterpret_borrow<py::object>(object), setup_, role, name, begin_);
    if (made->telemetry->any()) outside_.reports.emplace_back(published_as, made->telemetry);
    return made;
  }
  /// One after the other as they are listed.
  Functions list(const char* list, const std::string& role, const char* name) const {
    Functions all;
    if (!objects_.contains(list)) return all;
    for (const py::handle& object : py::cast<py::sequence>(objects_[list]))
      all.push_back(one(object, role, name, role + std::to_string(all.size())));
    return all;
  }

 private:
  const py::dict& objects_;
  const Setup<double>& setup_;
  const Begin& begin_;
  host::Outside& outside_;
};

/// What the sensors show, as Python sensors change it.
auto sensed_by(Functions sensors, const Setup<double>& setup) {
  return [sensors = std::move(sensors), n = setup.vehicle.actuators(), dt = setup.dt](Measurement<double>& y) {
    const py::gil_scoped_acquire gil;
    const Tick tick = y.tick;
    for (const auto& sensor : sensors) {
      const py::object out = (*sensor)(static_cast<double>(tick) * dt, y);
      if (!py::isinstance<Measurement<double>>(out)) {
        throw std::invalid_argument(sensor->returned + (out.is_none() ? " nothing (None)" : " a " + class_name(out)) +
                                    "; a Measurement (the one it was given, changed) belongs there");
      }
      y = py::cast<Measurement<double>>(out);
      y.tick = tick;
      if (y.h_w.size() == n) continue;
      throw std::invalid_argument(sensor->returned + " " + std::to_string(y.h_w.size()) + " numbers as h_w; " +
                                  std::to_string(n) + " belong there, one an actuator");
    }
  };
}

auto changed_by(Functions faults) {
  return [faults = std::move(faults)](double t, VecN<double>& u) {
    const py::gil_scoped_acquire gil;
    for (const auto& fault : faults) {
      const Eigen::VectorXd given = u;
      copy_numbers((*fault)(t, t, given), given.size(), u, fault->returned);
      if (!u.allFinite()) throw std::invalid_argument(fault->returned + " a number that is not finite " + at_time(t));
    }
  };
}

auto pushed_by(Functions disturbances) {
  return [disturbances = std::move(disturbances)](double t, const Quat<double>& q, const Vec3<double>& omega_BN_B) {
    const py::gil_scoped_acquire gil;
    const Eigen::Vector4d q_NB(q.w(), q.x(), q.y(), q.z());
    Vec3<double> sum = Vec3<double>::Zero();
    for (const auto& disturbance : disturbances) {
      Vec3<double> torque_B;
      copy_numbers((*disturbance)(t, t, q_NB, Eigen::Vector3d(omega_BN_B)), 3, torque_B, disturbance->returned);
      if (!torque_B.allFinite())
        throw std::invalid_argument(disturbance->returned + " a torque that is not finite " + at_time(t));
      sum += torque_B;
    }
    return sum;
  };
}

/// What a drive returned: a number that is held, or rows (seconds from now, what it gives from then on).
void read_steps(const py::object& out, const PythonFunction& drive, double t, double dt,
                std::vector<truth::DriveStep>& steps) {
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(drive.returned + " " + what + " " + at_time(t));
  };
  const std::string wanted = "a number, or rows (seconds from now, what it gives from then on)";
  const Numbers array = numbers(out, drive.returned, wanted);
  const bool rows = array.ndim() == 2 && array.shape(0) > 0 && array.shape(1) == 2;
  if (!rows && array.size() != 1) refuse(std::to_string(array.size()) + " numbers; " + wanted + " belong there");
  steps.clear();
  if (!rows) {
    steps.push_back({t, array.data()[0]});
  } else {
    for (py::ssize_t i = 0; i < array.shape(0); ++i) {
      const double after = array.at(i, 0);
      if (i == 0 ? after != 0 : !(t + after > steps.back().t))
        refuse("the time " + host::number_text(after) + " s in row " + std::to_string(i) +
               "; rows begin at 0 and go on in order of time");
      if (!(after < dt))
        refuse("the time " + host::number_text(after) + " s in row " + std::to_string(i) +
               ", when the next command has come; less than " + host::number_text(dt) + " s belongs there");
      steps.push_back({t + after, array.at(i, 1)});
    }
  }
  for (const truth::DriveStep& step : steps) {
    if (!std::isfinite(step.value)) refuse("a number that is not finite");
  }
}

host::Drive driven_by(int actuator, std::shared_ptr<PythonFunction> drive, const Setup<double>& setup) {
  return {actuator,
          [drive = std::move(drive), dt = setup.dt](double t, double u, double h_w, const Vec3<double>& omega_BN_B,
                                                    std::vector<truth::DriveStep>& steps) {
            const py::gil_scoped_acquire gil;
            read_steps((*drive)(t, t, u, h_w, Eigen::Vector3d(omega_BN_B)), *drive, t, dt, steps);
          }};
}

/// What takes part beside the flight components.
host::Outside outside_of(const py::dict& objects, const Setup<double>& setup, const Begin& begin) {
  host::Outside outside;
  const Maker make(objects, setup, begin, outside);
  if (objects.contains("reference"))
    outside.reference = PythonReference(make.one(objects["reference"], "reference", "at", "reference"));
  if (Functions all = make.list("sensors", "sensor", "measure"); !all.empty())
    outside.sensor = sensed_by(std::move(all), setup);
  if (Functions all = make.list("faults", "fault", "apply"); !all.empty()) outside.fault = changed_by(std::move(all));
  if (objects.contains("drives")) {
    const int n = setup.vehicle.actuators();
    for (const auto& [key, object] : py::cast<py::dict>(objects["drives"])) {
      const int i = py::cast<int>(key);
      if (i < 0 || i >= n)
        throw std::invalid_argument("drives: actuator " + std::to_string(i) + " is not there; the vehicle has " +
                                    std::to_string(n) + " (0 to " + std::to_string(n - 1) + ")");
      const std::string role = "drive" + std::to_string(i);
      outside.drives.push_back(driven_by(i, make.one(object, role, "deliver", role), setup));
    }
  }
  if (Functions all = make.list("disturbances", "disturbance", "torque_B"); !all.empty())
    outside.torque_B = pushed_by(std::move(all));
  return outside;
}

std::function<host::Outside(const Setup<double>&)> outside(const py::dict& objects, const Begin& begin) {
  const std::shared_ptr<py::dict> held(new py::dict(objects), Release{});
  return [held, begin](const Setup<double>& setup) {
    const py::gil_scoped_acquire gil;
    return outside_of(*held, setup, begin);
  };
}

}  // namespace

host::ExternalComponents python_components(const py::dict& objects, Use use) {
  for (const auto& [key, value] : objects) {
    const std::string role = py::cast<std::string>(key);
    static const std::set<std::string> roles = {"navigator", "observer", "detector", "controller", "allocator",
                                                "reference", "sensors",  "faults",   "drives",     "disturbances"};
    if (!roles.contains(role)) {
      throw std::invalid_argument("components: no role '" + role +
                                  "'; there are: navigator, observer, detector, controller, allocator, reference, "
                                  "sensors, faults, drives, disturbances");
    }
  }
  const Begin begin(use);
  return {factory<PythonNavigator, host::NavigatorBase>(objects, "navigator", begin),
          factory<PythonObserver, host::ObserverBase>(objects, "observer", begin),
          factory<PythonDetector, host::DetectorBase>(objects, "detector", begin),
          factory<PythonController, host::ControllerBase>(objects, "controller", begin),
          factory<PythonAllocator, host::AllocatorBase>(objects, "allocator", begin),
          outside(objects, begin)};
}

}  // namespace gyrostat::bindings
