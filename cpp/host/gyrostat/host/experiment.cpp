// SPDX-License-Identifier: MIT
#include "gyrostat/host/experiment.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>

#include "gyrostat/host/alternatives.hpp"
#include "gyrostat/host/run_parts.hpp"

namespace gyrostat::host {
namespace {

/// Ends a flight that nobody waits for any more.
struct Stopped {};

constexpr Tick between_looks = 64;  // samples

/// Onset of the last fault that begins before the end, s; 0 without faults.
double last_fault(const Assembly& a) {
  double last = 0;
  for (const truth::Fault& fault : a.plant.faults) {
    const double t_on = truth::window_of(fault).t_on;
    if (t_on < a.run.duration) last = std::max(last, t_on);
  }
  return last;
}

std::size_t index_of(const ChannelReader& reader, const std::string& channel) {
  const auto& all = reader.channels();
  const auto found = std::find_if(all.begin(), all.end(), [&](const ChannelInfo& c) { return c.name == channel; });
  return static_cast<std::size_t>(found - all.begin());
}

/// Feeds the metrics of one flight.
template <truth::Plant Plant>
class Measuring {
 public:
  struct Meter {
    std::span<const double> x;  ///< where the reader puts it
    Metric metric;
  };

  Measuring(const Assembly& a, const Plant& plant, FlightParts& parts, ChannelReader& reader,
            std::vector<Meter>& meters, const std::atomic<bool>& stop)
      : plant_(plant),
        parts_(parts),
        reader_(reader),
        meters_(meters),
        stop_(stop),
        moments_(a, plant, parts.stack, reader.needs_previous()) {}

  void before(const Measurement<double>&, const Allocation<double>& last) {
    moments_.before(last);
    if (reader_.needs_shadows()) shadows_.before(parts_, last);
  }

  void after(Tick k, const Measurement<double>& y, const Reference<double>& ref) {
    if (k % between_looks == 0 && stop_.load(std::memory_order_relaxed)) throw Stopped();
    if (reader_.needs_shadows()) shadows_.after(parts_);
    const double t = plant_.time();
    reader_.read(moments_.now(t, y, ref));
    for (Meter& m : meters_) std::visit([&](auto& metric) { metric.add(t, m.x); }, m.metric);
    moments_.after();
  }

 private:
  const Plant& plant_;
  FlightParts& parts_;
  ChannelReader& reader_;
  std::vector<Meter>& meters_;
  const std::atomic<bool>& stop_;
  Moments moments_;
  ShadowFlight shadows_;
};

/// All that flies in one run.
struct Objects {
  Assembly a;
  AnyPlant plant;
  truth::Sensors sensors;
  FlightParts parts;
  ReferencePath reference;

  Objects(Assembly a_in, const ExternalComponents& external, std::uint64_t number,
          const std::vector<std::string>& channels)
      : a(std::move(a_in)),
        plant(make_plant(a)),
        sensors(a.sensors, a.run.seed, number, wants_euler(channels), a.setup.dt, a.setup.vehicle.wheels, a.plant.orbit,
                a.run.noise_versions),
        parts(a, external),
        reference(make_reference(a, parts.outside)) {}

  ChannelReader reader(const std::vector<std::string>& channels) const {
    return {channels, a.counts(), parts.components, parts.views, "measure"};
  }
};

double number_at(const Table& table, const char* key, const Place& place, double lo, double hi) {
  double x = 0;
  read(*table.find(key), Key{place, key, lo, hi}, x);
  return x;
}

std::string text_at(const Table& table, const char* key, const Place& place) {
  const Value* value = table.find(key);
  if (value == nullptr) place.refuse(std::string(key) + " is missing");
  std::string text;
  read(*value, Key{place, key}, text);
  return text;
}

}  // namespace

Experiment::Experiment(const Table& scenario, const std::vector<std::string>& vary, const Table& measures,
                       ExternalSource external)
    : external_(std::move(external)), nominal_(assemble(scenario)), slots_(scenario, nominal_, vary) {
  for (const auto& [name, entry] : measures.entries()) {
    meters_.push_back(meter_of(name, entry, nominal_.run.duration));
    const std::string& channel = meters_.back().channel;
    if (std::find(channels_.begin(), channels_.end(), channel) == channels_.end()) channels_.push_back(channel);
  }
  Objects objects(nominal_, external_ ? external_() : ExternalComponents{}, 0, channels_);  // refuses what they refuse
  const ChannelReader reader = objects.reader(channels_);
  for (const Meter& m : meters_) {
    const int size = reader.channels()[index_of(reader, m.channel)].size;
    if (m.column < size) continue;
    throw std::invalid_argument("measure '" + m.name + "': column = " + std::to_string(m.column) + "; " + m.channel +
                                " has " + std::to_string(size) + " (0 to " + std::to_string(size - 1) + ")");
  }
}

Experiment::Meter Experiment::meter_of(const std::string& name, const Value& entry, double duration) {
  const Place place{"measure '" + name + "'"};
  const Table* given = entry.as<Table>();
  if (given == nullptr)
    place.refuse("is " + std::string(entry.kind()) + "; a table with metric and signal belongs here");
  Meter m{name, text_at(*given, "signal", place), -1, {}, {}};
  if (m.channel.ends_with(".*")) place.refuse("signal = '" + m.channel + "' names several channels; one belongs here");
  const std::string metric = text_at(*given, "metric", place);
  if (given->find("column") != nullptr)
    m.column = static_cast<int>(number_at(*given, "column", place, 0, max_actuators));
  Table numbers;
  for (const auto& [key, value] : given->entries()) {
    if (key == "metric" || key == "signal" || key == "column") continue;
    if (key == "last") {
      numbers.set("t0", duration - number_at(*given, "last", place, 0, duration));
    } else if (const auto* text = value.as<std::string>(); text != nullptr && *text == "last_fault") {
      numbers.set(key, 0.0);
      m.at_last_fault.push_back(key);
    } else {
      numbers.set(key, value);
    }
  }
  m.metric = Alternatives<Metric>::read("metric", metric, numbers, place);
  return m;
}

std::vector<std::string> Experiment::metrics() const {
  std::vector<std::string> names;
  for (const Meter& m : meters_) names.push_back(m.name);
  return names;
}

/// One thread's copy of the scenario.
class Experiment::Worker {
 public:
  Worker(const Experiment& e, const std::atomic<bool>& stop) : e_(e), stop_(stop), copy_(e.slots_) {}

  /// @throws Stopped, and what a component from outside throws
  Flight fly(std::uint64_t number, std::span<const double> values) {
    Flight out{{}, std::vector<double>(e_.meters_.size(), measure::never)};
    std::optional<Objects> objects;
    try {
      objects.emplace(assemble(copy_.with(values)), e_.external_ ? e_.external_() : ExternalComponents{}, number,
                      e_.channels_);
    } catch (const std::invalid_argument& refusal) {
      out.end.code = RunEnd::Code::refused;
      out.end.cause = refusal.what();
      return out;
    }
    ChannelReader reader = objects->reader(e_.channels_);
    std::visit([&](auto& plant) { fly(*objects, plant, reader, out); }, objects->plant);
    return out;
  }

 private:
  template <truth::Plant Plant>
  void fly(Objects& o, Plant& plant, ChannelReader& reader, Flight& out) {
    std::vector<typename Measuring<Plant>::Meter> meters;
    const double onset = last_fault(o.a);
    for (const Meter& m : e_.meters_) {
      const std::span<const double> channel = reader[index_of(reader, m.channel)];
      meters.push_back({m.column < 0 ? channel : channel.subspan(static_cast<std::size_t>(m.column), 1), m.metric});
      const auto is_onset = [&](const Field& f) {
        return std::find(m.at_last_fault.begin(), m.at_last_fault.end(), f.name) != m.at_last_fault.end();
      };
      const auto set = [&]<class M>(M& metric) {
        M::describe(metric, [&](double& x, const Field& f) { x = is_onset(f) ? onset : x; });
      };
      std::visit(set, meters.back().metric);
    }
    Measuring<Plant> measuring(o.a, plant, o.parts, reader, meters, stop_);
    out.end = host::fly(plant, o.sensors, o.reference, o.parts.stack, o.a.ticks, measuring, o.parts.outside);
    for (std::size_t i = 0; i < meters.size(); ++i) {
      out.metrics[i] = std::visit([](const auto& metric) { return metric.value(); }, meters[i].metric);
    }
  }

  const Experiment& e_;
  const std::atomic<bool>& stop_;
  Slots::Copy copy_;
};

Table Experiment::scenario(std::uint64_t number, std::span<const double> values) const {
  Table table = Slots::Copy(slots_).with(values);
  table.set("run_number", static_cast<std::int64_t>(number));
  return table;
}

std::vector<Flight> Experiment::fly(std::uint64_t first, std::size_t flights, std::span<const double> values,
                                    const FlyOptions& options) const {
  const std::size_t width = columns().size();
  if (values.size() != flights * width)
    throw std::invalid_argument("values: " + std::to_string(values.size()) + " numbers; " + std::to_string(flights) +
                                " flights of " + std::to_string(width) + " belong there");
  std::vector<Flight> out(flights);
  std::atomic<std::size_t> next = 0, done = 0;
  std::atomic<bool> stop = false;
  std::mutex mutex;
  std::condition_variable ended;
  std::exception_ptr trouble;
  unsigned working = external_ ? 1U : std::max(1U, options.threads);
  const auto work = [&] {
    try {
      Worker worker(*this, stop);
      for (std::size_t i; !stop && (i = next.fetch_add(1)) < flights; ++done)
        out[i] = worker.fly(first + i, values.subspan(i * width, width));
    } catch (const Stopped&) {
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!trouble) trouble = std::current_exception();
      stop = true;
    }
    const std::lock_guard lock(mutex);
    --working;
    ended.notify_all();
  };
  std::vector<std::jthread> pool;
  for (unsigned i = 0, n = working; i < n; ++i) pool.emplace_back(work);
  try {
    std::unique_lock lock(mutex);
    while (!ended.wait_for(lock, std::chrono::milliseconds(200), [&] { return working == 0; })) {
      lock.unlock();
      if (options.progress) options.progress(done);
      lock.lock();
    }
  } catch (...) {
    stop = true;
    pool.clear();
    throw;
  }
  pool.clear();
  if (trouble) std::rethrow_exception(trouble);
  return out;
}

}  // namespace gyrostat::host
