// SPDX-License-Identifier: MIT
#include "python_component.hpp"

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>

#include <cmath>
#include <memory>
#include <stdexcept>

namespace gyrostat::bindings {
namespace {

namespace py = pybind11;

/// Owns the object; takes the GIL to let go of it.
struct Release {
  void operator()(py::object* object) const {
    const py::gil_scoped_acquire gil;
    delete object;
  }
};
using Held = std::unique_ptr<py::object, Release>;

Held hold(const py::object& object) { return Held(new py::object(object)); }

std::string class_name(const py::object& object) {
  return py::cast<std::string>(py::type::handle_of(object).attr("__name__"));
}

/// An array-like of n finite or non-finite numbers; the stack's guard judges their values.
template <class Vector>
void copy_numbers(const py::object& from, Eigen::Index n, Vector& out, const std::string& who) {
  if (from.is_none())
    throw std::invalid_argument(who + " returned nothing (None); " + std::to_string(n) + " numbers belong there");
  py::array_t<double, py::array::c_style | py::array::forcecast> array;
  try {
    array = py::array_t < double, py::array::c_style | py::array::forcecast > (from);
  } catch (const py::error_already_set&) {
    throw std::invalid_argument(who + " returned a " + class_name(from) + "; " + std::to_string(n) +
                                " numbers belong there");
  }
  if (array.size() != n) {
    throw std::invalid_argument(who + " returned " + std::to_string(array.size()) + " numbers; " + std::to_string(n) +
                                " belong there");
  }
  if constexpr (Vector::SizeAtCompileTime == Eigen::Dynamic) out.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) out[i] = array.data()[i];
}

/// An attribute of the wrong length is the component's mistake, said with its name and both numbers.
template <class Vector>
void check_size(const Vector& v, Eigen::Index n, const std::string& who, const char* name, bool may_be_empty = false) {
  if (v.size() == n || (may_be_empty && v.size() == 0)) return;
  throw std::invalid_argument(who + " returned " + std::to_string(v.size()) + " numbers as " + name + "; " +
                              std::to_string(n) + " belong there, one an actuator" + (may_be_empty ? ", or none" : ""));
}

/// Common half: the object, its `setup`, and whether it has a `start` of its own.
template <class Base>
class PythonModel : public Base {
 public:
  PythonModel(const py::object& object, const Setup<double>& setup, const char* role, Use use)
      : setup_(setup), who_(std::string(role) + " " + class_name(object) + ".step"), object_(hold(object)) {
    if (!py::hasattr(object, "step"))
      throw std::invalid_argument(std::string(role) + ": " + class_name(object) + " has no step(...)");
    if (use == Use::fly && py::hasattr(object, "setup")) object.attr("setup")(setup);
    step_ = hold(object.attr("step"));
    start_ = py::hasattr(object, "start") ? hold(object.attr("start")) : nullptr;
  }
  void entries(std::vector<host::TelemetryEntry>&) const final {}
  double* values(double* row) const final { return row; }

 protected:
  int actuators() const { return setup_.vehicle.actuators(); }

  Setup<double> setup_;
  std::string who_;
  Held object_, step_, start_;
};

class PythonObserver final : public PythonModel<host::ObserverBase> {
 public:
  PythonObserver(const py::object& object, const Setup<double>& setup, const char* role, Use use)
      : PythonModel(object, setup, role, use),
        skip_(py::hasattr(object, "skip") ? hold(object.attr("skip")) : nullptr) {}
  Estimate<double> start(const Measurement<double>& y) final {
    const py::gil_scoped_acquire gil;
    return start_ ? result((*start_)(y), y) : result((*step_)(y, Allocation<double>::idle(actuators())), y);
  }
  Estimate<double> step(const Measurement<double>& y, const Allocation<double>& last) final {
    const py::gil_scoped_acquire gil;
    return result((*step_)(y, last), y);
  }
  Estimate<double> skip(const Measurement<double>& y, const Allocation<double>& last) final {
    const py::gil_scoped_acquire gil;
    return result((skip_ ? *skip_ : *step_)(y, last), y);
  }

 private:
  Estimate<double> result(const py::object& out, const Measurement<double>& y) const {
    if (!py::isinstance<Estimate<double>>(out)) {
      throw std::invalid_argument(who_ + " returned a " + class_name(out) +
                                  "; an Estimate belongs there (Estimate.healthy(y) makes one)");
    }
    Estimate<double> x = py::cast<Estimate<double>>(out);
    check_size(x.h_w, actuators(), who_, "h_w");
    check_size(x.effectiveness, actuators(), who_, "effectiveness");
    check_size(x.effectiveness_bound, actuators(), who_, "effectiveness_bound");
    x.tick = y.tick;
    return x;
  }

  Held skip_;
};

class PythonDetector final : public PythonModel<host::DetectorBase> {
 public:
  using PythonModel::PythonModel;
  Detection<double> start(const Estimate<double>& x) final {
    const py::gil_scoped_acquire gil;
    return result(start_ ? (*start_)(x) : (*step_)(x, Allocation<double>::idle(actuators())));
  }
  Detection<double> step(const Estimate<double>& x, const Allocation<double>& last) final {
    const py::gil_scoped_acquire gil;
    return result((*step_)(x, last));
  }

 private:
  Detection<double> result(const py::object& out) const {
    if (!py::isinstance<Detection<double>>(out))
      throw std::invalid_argument(who_ + " returned a " + class_name(out) + "; a Detection belongs there");
    const Detection<double> det = py::cast<Detection<double>>(out);
    check_size(det.u_probe, actuators(), who_, "u_probe", true);
    return det;
  }
};

class PythonController final : public PythonModel<host::ControllerBase> {
 public:
  using PythonModel::PythonModel;
  Demand<double> start(const Estimate<double>& x, const Detection<double>& det, const Reference<double>& ref) final {
    const py::gil_scoped_acquire gil;
    return result(start_ ? (*start_)(x, det, ref) : (*step_)(x, det, ref, Allocation<double>::idle(actuators())));
  }
  Demand<double> step(const Estimate<double>& x, const Detection<double>& det, const Reference<double>& ref,
                      const Allocation<double>& last) final {
    const py::gil_scoped_acquire gil;
    return result((*step_)(x, det, ref, last));
  }

 private:
  Demand<double> result(const py::object& out) const {
    Demand<double> demand;
    if (py::isinstance<Demand<double>>(out)) {
      demand = py::cast<Demand<double>>(out);
      check_size(demand.u_pref, actuators(), who_, "u_pref", true);
    } else {
      copy_numbers(out, 3, demand.tau_B, who_);
    }
    return demand;
  }
};

class PythonAllocator final : public PythonModel<host::AllocatorBase> {
 public:
  PythonAllocator(const py::object& object, const Setup<double>& setup, const char* role, Use use)
      : PythonModel(object, setup, role, use) {
    reset_ = py::hasattr(object, "reset") ? hold(object.attr("reset")) : nullptr;
  }
  void reset() final {
    if (!reset_) return;
    const py::gil_scoped_acquire gil;
    (*reset_)();
  }
  Allocation<double> step(const Demand<double>& demand, const Estimate<double>& x, const Detection<double>& det) final {
    const py::gil_scoped_acquire gil;
    const py::object out = (*step_)(demand, x, det);
    if (py::isinstance<Allocation<double>>(out)) {
      const Allocation<double> a = py::cast<Allocation<double>>(out);
      check_size(a.u, actuators(), who_, "u");
      return a;
    }
    Allocation<double> a;
    copy_numbers(out, actuators(), a.u, who_);
    a.demand_B = demand.tau_B;
    a.achieved_B = torque<double>(setup_.vehicle.D_B, x.effectiveness.cwiseProduct(a.u));
    return a;
  }

 private:
  Held reset_;
};

template <class Model, class Base>
std::function<std::unique_ptr<Base>(const Setup<double>&)> factory(const py::dict& objects, const char* role, Use use) {
  if (!objects.contains(role)) return {};
  const std::shared_ptr<py::object> object(new py::object(objects[role]), Release{});
  return [object, role, use](const Setup<double>& setup) -> std::unique_ptr<Base> {
    const py::gil_scoped_acquire gil;
    return std::make_unique<Model>(*object, setup, role, use);
  };
}

}  // namespace

host::ExternalComponents python_components(const py::dict& objects, Use use) {
  for (const auto& [key, value] : objects) {
    const std::string role = py::cast<std::string>(key);
    if (role != "observer" && role != "detector" && role != "controller" && role != "allocator") {
      throw std::invalid_argument("components: no role '" + role +
                                  "'; there are: observer, detector, controller, allocator");
    }
  }
  return {factory<PythonObserver, host::ObserverBase>(objects, "observer", use),
          factory<PythonDetector, host::DetectorBase>(objects, "detector", use),
          factory<PythonController, host::ControllerBase>(objects, "controller", use),
          factory<PythonAllocator, host::AllocatorBase>(objects, "allocator", use)};
}

}  // namespace gyrostat::bindings
