// SPDX-License-Identifier: MIT
// Catalogue, simulation and metrics. No component is named here.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <optional>
#include <type_traits>
#include <utility>

#include "gyrostat/flight/compensation_margin.hpp"
#include "gyrostat/host/catalogue.hpp"
#include "gyrostat/host/experiment.hpp"
#include "gyrostat/host/flight_model.hpp"
#include "gyrostat/host/metrics.hpp"
#include "gyrostat/host/simulate.hpp"
#include "python_component.hpp"
#include "python_value.hpp"

namespace gyrostat::bindings {
namespace {

namespace py = pybind11;
using namespace py::literals;

py::list parameters(const std::vector<host::ParamInfo>& described) {
  py::list params;
  for (const host::ParamInfo& p : described) {
    params.append(py::dict("name"_a = p.name, "kind"_a = p.kind, "unit"_a = p.unit, "lo"_a = p.lo, "hi"_a = p.hi,
                           "meaning"_a = p.meaning, "options"_a = p.options, "default"_a = to_python(p.default_value),
                           "required"_a = p.required, "scales"_a = p.scales));
  }
  return params;
}

py::list names_of(const Estimates& e) {
  py::list names;
  if (e.d_B) names.append("d_B");
  if (e.effectiveness) names.append("effectiveness");
  return names;
}

py::dict describe(const std::string& family, const std::string& name) {
  const host::Description d = host::describe(family, name);
  return py::dict(
      "family"_a = d.family, "name"_a = d.name,
      "traits"_a = py::dict("axiswise"_a = d.traits.axiswise, "switching"_a = d.traits.switching,
                            "regulates"_a = d.traits.regulates, "estimates"_a = names_of(d.traits.estimates)),
      "params"_a = parameters(d.params));
}

/// A scenario read and cross-checked once, for whatever is asked of it.
struct Compiled {
  host::Table scenario;
  host::Assembly assembly;

  explicit Compiled(const py::dict& tables) : scenario(to_table(tables)), assembly(host::assemble(scenario)) {}
};

py::dict flight_model(const Compiled& c) {
  const host::FlightModel m = host::flight_model(c.assembly);
  const Vehicle<double>& v = m.setup.vehicle;
  py::list components;
  for (const host::FlightComponent& part : m.components) {
    components.append(py::dict("role"_a = part.role, "name"_a = part.name, "cpp"_a = part.cpp.name,
                               "params"_a = parameters(part.params)));
  }
  py::list gyros;
  for (const truth::ControlMomentGyro& g : m.gyros) {
    gyros.append(py::dict("actuator"_a = g.channel, "gimbal_axis_B"_a = to_python(host::write(g.gimbal_axis_B)),
                          "spin_axis_B"_a = to_python(host::write(g.spin_axis_B)),
                          "rotor_momentum"_a = g.rotor_momentum));
  }
  const py::dict vehicle("J_B"_a = to_python(host::write(v.J_B)), "D_B"_a = to_python(host::write(v.D_B)),
                         "u_lo"_a = to_python(host::write(v.u_lo)), "u_up"_a = to_python(host::write(v.u_up)),
                         "u_rate"_a = to_python(host::write(v.u_rate)), "h_max"_a = to_python(host::write(v.h_max)),
                         "u_quantum"_a = to_python(host::write(v.u_quantum)),
                         "u_dead"_a = to_python(host::write(v.u_dead)), "u_gap"_a = to_python(host::write(v.u_gap)),
                         "spare"_a = to_python(host::write(v.spare)), "wheels"_a = to_python(host::write(v.wheels)),
                         "magnetorquers"_a = to_python(host::write(v.magnetorquers)), "orbit_rate"_a = v.orbit_rate,
                         "coordinates"_a = v.coordinates == Coordinates::body ? "body" : "euler_angles");
  return py::dict("dt"_a = m.setup.dt, "vehicle"_a = vehicle, "allow_unstable"_a = m.allow_unstable,
                  "components"_a = components, "gyros"_a = gyros, "dipole_B"_a = to_python(host::write(m.dipole_B)),
                  "capacity"_a = m.capacity,
                  "bytes"_a = py::dict("double"_a = m.bytes_double, "float"_a = m.bytes_float));
}

const char* code_name(Status<double>::Code code) {
  static constexpr const char* names[] = {"ok", "refused", "unstable", "wrong_chart"};
  return names[static_cast<int>(code)];
}

py::list check(const Compiled& c, const py::dict& components) {
  py::list rows;
  for (const host::CheckRow& r : host::check(c.assembly, python_components(components, Use::look))) {
    rows.append(py::dict("where"_a = r.where, "name"_a = r.name, "ok"_a = r.status.ok(),
                         "code"_a = code_name(r.status.code), "quantity"_a = r.status.quantity,
                         "value"_a = r.status.value, "limit"_a = r.status.limit, "relation"_a = r.status.relation));
  }
  return rows;
}

py::dict channel(const host::ChannelInfo& c) {
  return py::dict("name"_a = c.name, "size"_a = c.size, "unit"_a = c.unit, "meaning"_a = c.meaning,
                  "dimension"_a = c.dimension);
}

py::dict inner_rates(const Compiled& c) {
  using truth::InnerRates;
  const InnerRates r = host::inner_rates(c.assembly);
  return py::dict("turning"_a = r.turning, "bending"_a = r.bending, "friction"_a = r.friction,
                  "longest_step"_a = InnerRates::longest_step, "most_in_a_sample"_a = InnerRates::most_in_a_sample);
}

py::list channel_names(const Compiled& c, const py::dict& components) {
  py::list rows;
  for (const host::ChannelInfo& info : host::channels(c.assembly, python_components(components, Use::look)))
    rows.append(channel(info));
  return rows;
}

/// A numpy array that owns the vector; read-only.
py::array_t<double> array_of(std::vector<double>&& data, std::vector<py::ssize_t> shape) {
  auto* owned = new std::vector<double>(std::move(data));
  const py::capsule owner(owned, [](void* p) { delete static_cast<std::vector<double>*>(p); });
  py::array_t<double> out(std::move(shape), owned->data(), owner);
  out.attr("setflags")("write"_a = false);
  return out;
}

constexpr const char* end_names[] = {"completed",          "singular",   "non_finite",
                                     "integration_failed", "no_command", "refused"};

const char* end_name(host::RunEnd::Code code) { return end_names[static_cast<int>(code)]; }

py::dict simulate(const Compiled& c, const py::dict& components,
                  const std::optional<std::vector<std::string>>& channels, std::size_t every,
                  const py::object& progress, double memory, bool record) {
  const host::ExternalComponents external = python_components(components, Use::fly);
  host::RunOptions options;
  options.every = every;
  options.record = record;
  options.memory = memory;
  if (channels) options.channels = *channels;
  options.progress = [&progress](double fraction) {
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!progress.is_none()) progress(fraction);
  };
  host::RunResult result;
  {
    const py::gil_scoped_release no_gil;
    result = host::simulate(c.assembly, external, options);
  }
  py::dict arrays;
  py::list meta;
  const py::ssize_t rows = static_cast<py::ssize_t>(result.t.size());
  for (host::Recorder::Channel& recorded : result.channels) {
    std::vector<py::ssize_t> shape{rows};
    if (recorded.info.size != 1) shape.push_back(recorded.info.size);
    arrays[py::str(recorded.info.name)] = array_of(std::move(recorded.data), shape);
    meta.append(channel(recorded.info));
  }
  py::list events;
  for (const host::Event& e : result.events)
    events.append(py::dict("t"_a = e.t, "name"_a = e.name, "count"_a = e.count, "what"_a = e.what));
  return py::dict(
      "t"_a = array_of(std::move(result.t), {rows}), "channels"_a = arrays, "meta"_a = meta, "events"_a = events,
      "status"_a = end_name(result.end.code), "cause"_a = result.end.cause, "end_time"_a = result.end.time,
      "statistics"_a =
          py::dict("steps"_a = result.statistics.steps, "rhs_evaluations"_a = result.statistics.rhs_evaluations,
                   "restarts"_a = result.statistics.restarts, "pieces"_a = result.statistics.pieces,
                   "samples"_a = result.end.samples, "held_samples"_a = result.end.held));
}

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::span<const double> numbers(const Array& x) { return {x.data(), static_cast<std::size_t>(x.size())}; }

/// `copies` gives fresh Python components for every flight; None: there are none.
std::unique_ptr<host::Experiment> experiment(const py::dict& scenario, const std::vector<std::string>& vary,
                                             const py::dict& measures, const py::object& copies) {
  host::ExternalSource external;
  if (!copies.is_none()) {
    external = [copies] {
      const py::gil_scoped_acquire gil;
      return python_components(copies(), Use::fly);
    };
  }
  return std::make_unique<host::Experiment>(to_table(scenario), vary, to_table(measures), std::move(external));
}

py::dict fly(const host::Experiment& e, std::uint64_t first, const Array& values, unsigned threads,
             const py::object& progress) {
  if (values.ndim() != 2) throw std::invalid_argument("values: rows of one number a column belong there");
  const std::size_t flights = static_cast<std::size_t>(values.shape(0));
  host::FlyOptions options;
  options.threads = threads;
  options.progress = [&](std::size_t done) {
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!progress.is_none()) progress(static_cast<double>(done) / static_cast<double>(flights));
  };
  std::vector<host::Flight> flown;
  {
    const py::gil_scoped_release no_gil;
    flown = e.fly(first, flights, numbers(values), options);
  }
  const std::size_t width = e.metrics().size();
  std::vector<double> metrics, end_time, held;
  py::list status;
  py::dict causes;
  for (std::size_t i = 0; i < flights; ++i) {
    const host::Flight& f = flown[i];
    metrics.insert(metrics.end(), f.metrics.begin(), f.metrics.end());
    end_time.push_back(f.end.time);
    held.push_back(f.end.held_fraction());
    status.append(end_name(f.end.code));
    if (!f.end.cause.empty()) causes[py::int_(first + i)] = f.end.cause;
  }
  const py::ssize_t n = static_cast<py::ssize_t>(flights);
  return py::dict("status"_a = status, "causes"_a = causes, "end_time"_a = array_of(std::move(end_time), {n}),
                  "held_fraction"_a = array_of(std::move(held), {n}),
                  "metrics"_a = array_of(std::move(metrics), {n, static_cast<py::ssize_t>(width)}));
}

void bind_experiment(py::module_& m) {
  py::class_<host::Experiment>(m, "Experiment", "A scenario flown many times with other numbers in it.")
      .def(py::init(&experiment), "scenario"_a, "vary"_a, "measures"_a, "copies"_a = py::none())
      .def_property_readonly("columns", &host::Experiment::columns)
      .def_property_readonly("metrics", &host::Experiment::metrics)
      .def(
          "scenario",
          [](const host::Experiment& e, std::uint64_t number, const Array& values) {
            if (static_cast<std::size_t>(values.size()) != e.columns().size())
              throw std::invalid_argument("values: one number a column belongs there");
            return to_python(e.scenario(number, numbers(values)));
          },
          "number"_a, "values"_a, "The tables of the scenario that one flight is.")
      .def("fly", &fly, "first"_a, "values"_a, "threads"_a = 1, "progress"_a = py::none(),
           "Flies one row of `values` after the other, numbered from `first`. Releases the GIL.");
}

host::Series series(const Array& t, const Array& x) {
  return {{t.data(), static_cast<std::size_t>(t.size())}, {x.data(), static_cast<std::size_t>(x.size())}};
}

/// The numbers that a metric takes: name, and default, which is NaN for one that must be given.
template <class T>
constexpr auto numbers_of() {
  constexpr auto count = [] {
    T metric{};
    std::size_t n = 0;
    T::describe(metric, [&](const double&, const Field&) { ++n; });
    return n;
  };
  std::array<std::pair<const char*, double>, count()> out{};
  T metric{};
  std::size_t i = 0;
  T::describe(metric, [&](const double& x, const Field& f) { out[i++] = {f.name, x}; });
  return out;
}

/// A function of time, samples and the numbers that the metric takes.
template <class T, std::size_t... i>
void bind_metric(py::module_& m, std::index_sequence<i...>) {
  static constexpr auto numbers = numbers_of<T>();
  [[maybe_unused]] const auto argument = []<std::size_t k>() {
    if constexpr (numbers[k].second != numbers[k].second) {
      return py::arg(numbers[k].first);
    } else {
      return py::arg_v(numbers[k].first, numbers[k].second);
    }
  };
  m.def(
      T::name,
      [](const Array& t, const Array& x, decltype(static_cast<void>(i), 0.0)... given) {
        T metric;
        [[maybe_unused]] const std::array<double, sizeof...(i)> values{given...};
        [[maybe_unused]] std::size_t next = 0;
        T::describe(metric, [&](double& member, const Field&) { member = values[next++]; });
        return host::measured(metric, series(t, x));
      },
      "t"_a, "x"_a, argument.template operator()<i>()..., T::meaning);
}

template <class... T>
void bind_metrics(py::module_& m, std::type_identity<std::variant<T...>>) {
  (bind_metric<T>(m, std::make_index_sequence<numbers_of<T>().size()>()), ...);
}

}  // namespace

void bind_host(py::module_& m) {
  m.def(
      "catalogue",
      [] {
        py::dict out;
        for (const auto& [family, names] : host::families()) out[py::str(family)] = names;
        return out;
      },
      "Every family of the catalogue with its names.");
  m.def(
      "endings",
      [] {
        py::list out;
        for (const char* name : end_names) out.append(name);
        return out;
      },
      "How a run can end: every status of a result.");
  m.def("describe", &describe, "family"_a, "name"_a,
        "Parameters of a component: name, kind, unit, range, default, meaning.");
  m.def(
      "check_params",
      [](const std::string& family, const std::string& name, const py::dict& params, const std::string& where) {
        host::check_params(family, name, to_table(params, where), where);
      },
      "family"_a, "name"_a, "params"_a, "where"_a,
      "Raises ValueError, one line, when a parameter is unknown, of the wrong type or out of range.");
  py::class_<Compiled>(m, "Compiled", "A scenario of plain tables, read and cross-checked once.")
      .def(py::init<const py::dict&>(), "scenario"_a)
      .def(py::pickle([](const Compiled& c) { return to_python(c.scenario); },
                      [](const py::dict& tables) { return Compiled(tables); }))
      .def("check", &check, "components"_a = py::dict(),
           "Builds everything without running; one row a component that has something to check.")
      .def(
          "resolve", [](const Compiled& c) { return to_python(host::resolve(c.scenario, c.assembly)); },
          "The scenario with every default filled in.")
      .def(
          "estimate_flow",
          [](const Compiled& c) {
            py::dict out;
            for (const auto& [role, estimates] : host::estimate_flow(c.assembly))
              out[py::str(role)] = names_of(estimates);
            return out;
          },
          "By role, the estimates (d_B, effectiveness) that the observer makes and the others use; a Python component "
          "is left out.")
      .def(
          "free_frequencies", [](const Compiled& c) { return host::free_frequencies(c.assembly); },
          "rad/s, ascending, of the modes of its appendages on the body that is free to turn.")
      .def(
          "orbit_rate", [](const Compiled& c) { return c.assembly.setup.vehicle.orbit_rate; },
          "rad/s, of its orbit; 0 without one.")
      .def("inner_rates", &inner_rates,
           "Rates of the truth's own motion at the start, 1/s, and what integrators allow for them.")
      .def("channel_names", &channel_names, "components"_a = py::dict(), "Channels that a run of this scenario offers.")
      .def("flight_model", &flight_model,
           "The flight half of a scenario: nominal vehicle as flight has it, period, components with their C++ class "
           "and every parameter as `default`, size of the stack.")
      .def("simulate", &simulate, "components"_a = py::dict(), "channels"_a = py::none(), "every"_a = 0,
           "progress"_a = py::none(), "memory"_a = unbounded, "record"_a = true,
           "Runs one closed loop. Releases the GIL; Python components take it back for their own step only.");
  bind_experiment(m);
  m.def("critical_effectiveness", &critical_effectiveness<double>, "lambda1"_a, "lambda2"_a,
        "Effectiveness above which feeding the estimate of a finite-time observer forward is stable.");
  bind_metrics(m, std::type_identity<host::Metric>());
}

}  // namespace gyrostat::bindings
