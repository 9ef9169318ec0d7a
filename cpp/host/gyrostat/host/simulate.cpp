// SPDX-License-Identifier: MIT
#include "gyrostat/host/simulate.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>

#include "gyrostat/host/run_parts.hpp"

namespace gyrostat::host {
namespace {

/// What the guard may do: name of the event, and words for it.
struct Action {
  const char* name;
  const char* text;
  bool GuardActions::* done;
};
constexpr Action actions[] = {{"guard.attitude", "attitude not measured", &GuardActions::attitude},
                              {"guard.rate", "rate not measured", &GuardActions::rate},
                              {"guard.momentum", "wheel momentum not measured", &GuardActions::momentum},
                              {"guard.reference", "reference not usable", &GuardActions::reference},
                              {"guard.navigator", "navigator started again", &GuardActions::navigator},
                              {"guard.observer", "observer started again", &GuardActions::observer},
                              {"guard.detector", "detector started again", &GuardActions::detector},
                              {"guard.controller", "controller started again", &GuardActions::controller},
                              {"guard.allocator", "allocator started again", &GuardActions::allocator},
                              {"guard.command", "previous command issued again", &GuardActions::command}};

/// Counters of components, detector and reference, turned into events when they go up, and what the guard did.
class EventLog {
 public:
  explicit EventLog(const std::vector<Reported>& components) {
    for (const Reported& r : components) {
      std::vector<TelemetryEntry> entries;
      r.component->entries(entries);
      std::size_t offset = 0, counters = 0;
      for (const TelemetryEntry& e : entries) {
        if (e.counter) {
          counters_.push_back({r.role + "." + e.name, sources_.size(), offset, 0});
          ++counters;
        }
        offset += static_cast<std::size_t>(e.width);
      }
      if (counters > 0) sources_.push_back({r.component, std::vector<double>(offset)});
    }
  }

  void look(double t, const Detection<double>& det, const Reference<double>& ref, const GuardActions& did) {
    detections(t, det);
    count(t, "reference.event", static_cast<int>(ref.event), references_);
    for (Source& s : sources_) s.component->values(s.row.data());
    for (CounterView& c : counters_) count(t, c.name, static_cast<int>(sources_[c.source].row[c.offset]), c.seen);
    for (std::size_t i = 0; i < std::size(actions); ++i) {
      if (did.*actions[i].done) note(t, i);
    }
  }

  std::vector<Event> take() && { return std::move(events_); }

 private:
  struct Source {
    const Reporting* component;
    std::vector<double> row;
  };
  struct CounterView {
    std::string name;
    std::size_t source, offset;
    int seen;
  };

  void count(double t, const std::string& name, int now, int& seen) {
    if (now > seen) events_.push_back({t, name, now, {}});
    seen = now;
  }

  /// A count that goes up is a declaration, unless all that is new is that actuators have recovered.
  void detections(double t, const Detection<double>& det) {
    const Mask gone = changed_.without(det.changed), named = det.changed.without(changed_);
    const int now = static_cast<int>(det.event);
    if (now > detections_ && (named.any() || !gone.any()))
      events_.push_back({t, "detector.event", now, text_of(named.any() ? named : det.changed, det)});
    if (gone.any()) events_.push_back({t, "detector.recovered", now, text_of(gone, det)});
    Mask other;
    for (int i = 0; i < max_actuators; ++i) {
      const auto k = static_cast<std::size_t>(i);
      other.set(i, det.classes[k] != classes_[k] && !named.test(i) && !gone.test(i));
    }
    if (other.any()) events_.push_back({t, "detector.class", now, text_of(other, det)});
    detections_ = now;
    changed_ = det.changed;
    classes_ = det.classes;
  }

  static std::string text_of(Mask actuators, const Detection<double>& det) {
    std::string text;
    for (int i = 0; i < max_actuators; ++i) {
      if (!actuators.test(i)) continue;
      text += (text.empty() ? "actuator " : ", actuator ") + std::to_string(i) + " " +
              fault_class_names[static_cast<std::size_t>(det.classes[static_cast<std::size_t>(i)])];
    }
    return text;
  }

  /// One event for each thing that the guard does: a component that fails at every sample must not fill the list.
  void note(double t, std::size_t action) {
    std::size_t& at = noted_[action];
    if (at == 0) {
      events_.push_back({t, actions[action].name, 0, {}});
      at = events_.size();
    }
    ++events_[at - 1].count;
  }

  std::vector<Source> sources_;
  std::vector<CounterView> counters_;
  std::vector<Event> events_;
  std::array<std::size_t, std::size(actions)> noted_{};  ///< place in `events_`, from one
  int detections_ = 0, references_ = 0;
  Mask changed_;                                     ///< at the sample before
  std::array<FaultClass, max_actuators> classes_{};  ///< likewise
};

/// Calls `progress` about five times a second. The clock is read every so many samples, as many as take a few
/// milliseconds: a run of slow samples can be ended as soon as one of fast ones.
class ProgressClock {
  using Clock = std::chrono::steady_clock;

 public:
  ProgressClock(std::function<void(double)> progress, Tick ticks) : progress_(std::move(progress)), ticks_(ticks) {}

  void look(Tick k) {
    if (!progress_ || k < next_) return;
    const Clock::time_point now = Clock::now();
    stride_ = now - looked_ > std::chrono::milliseconds(10) ? std::max<Tick>(stride_ / 2, 1)
                                                            : std::min<Tick>(stride_ * 2, 256);
    looked_ = now;
    next_ = k + stride_;
    if (now - called_ < std::chrono::milliseconds(200)) return;
    called_ = now;
    progress_(ticks_ == 0 ? 1.0 : static_cast<double>(k) / static_cast<double>(ticks_));
  }

 private:
  std::function<void(double)> progress_;
  Tick ticks_, next_ = 0, stride_ = 1;
  Clock::time_point looked_ = Clock::now(), called_ = looked_;
};

/// Everything that looks on while the loop flies: shadows, recorder, events, progress.
template <truth::Plant Plant>
class Watcher {
 public:
  Watcher(const Assembly& a, const Plant& plant, FlightParts& parts, Recorder* recorder, const RunOptions& options)
      : plant_(plant),
        parts_(parts),
        recorder_(recorder),
        every_(options.every),
        ticks_(a.ticks),
        events_(parts.components),
        clock_(options.progress, a.ticks),
        moments_(a, plant, parts.stack, recorder != nullptr && recorder->needs_previous()) {}

  void before(const Measurement<double>&, const Allocation<double>& last) {
    moments_.before(last);
    shadows_.before(parts_, last);
  }

  void after(Tick k, const Measurement<double>& y, const Reference<double>& ref) {
    shadows_.after(parts_);
    events_.look(plant_.time(), parts_.stack.detection(), ref, parts_.stack.actions());
    if (recorder_ != nullptr && (k % every_ == 0 || k == ticks_))
      recorder_->record(moments_.now(plant_.time(), y, ref));
    moments_.after();
    clock_.look(k);
  }

  std::vector<Event> take_events() && { return std::move(events_).take(); }

 private:
  const Plant& plant_;
  FlightParts& parts_;
  Recorder* recorder_;
  std::size_t every_;
  Tick ticks_;
  EventLog events_;
  ProgressClock clock_;
  Moments moments_;
  ShadowFlight shadows_;
};

/// The [record] block; options of the call win.
RunOptions with_record_block(RunOptions options, const Table& record) {
  const Place place{"record"};
  detail::refuse_unknown(record, place, {"channels", "every"});
  if (options.every == 0) {
    int n = 1;
    if (const Value* every = record.find("every"); every != nullptr) read(*every, Key{place, "every", 1, 1e9}, n);
    options.every = static_cast<std::size_t>(n);
  }
  if (const Value* channels = record.find("channels"); channels != nullptr && options.channels.empty()) {
    const List* list = channels->as<List>();
    if (list == nullptr) Key{place, "channels"}.refuse(*channels, "must be a list of names");
    for (const Value& name : *list) {
      std::string text;
      read(name, Key{place, "channels"}, text);
      options.channels.push_back(text);
    }
  }
  return options;
}

/// The next of 1, 2, 5, 10, 20, ... that is not below x >= 1, as a user types it.
std::string round_above(double x) {
  double ten = 1;
  while (ten * 10 <= x) ten *= 10;
  const double leading = x / ten;
  char text[32];
  std::snprintf(text, sizeof text, "%.0f", ten * (leading <= 1 ? 1 : leading <= 2 ? 2 : leading <= 5 ? 5 : 10));
  return text;
}

/// Room for the rows of a run; what the memory cannot hold is refused with what would fit.
void reserve(Recorder& recorder, const Assembly& a, const RunOptions& options) {
  const Tick rows = a.ticks / options.every + 2;
  const double bytes = 8.0 * static_cast<double>(rows) * static_cast<double>(recorder.width());
  const auto refuse = [&](const std::string& held) {
    const double every = static_cast<double>(options.every) * std::max(2.0, bytes / options.memory);
    Place{"record"}.refuse(number_text(static_cast<double>(rows)) + " samples of " + std::to_string(recorder.width()) +
                           " numbers take " + number_text(bytes / 1e9) + " GB, " + held +
                           "; record fewer channels, or every " + round_above(every) +
                           " samples (--every, every =), or fly for less than " + number_text(a.run.duration) + " s");
  };
  if (!(bytes <= options.memory)) refuse("and " + number_text(options.memory / 1e9) + " GB are free");
  try {
    recorder.reserve(static_cast<std::size_t>(rows));
  } catch (const std::exception&) {  // bad_alloc or length_error: a limit that nobody told us
    refuse("more than the system gives");
  }
}

Table resolved(const std::vector<ParamInfo>& params, const Table& given, const std::string& type = "") {
  Table out;
  if (!type.empty()) out.set("type", type);
  for (const ParamInfo& p : params) {
    const Value* v = given.find(p.name);
    const Value& chosen = v != nullptr && !v->is_none() ? *v : p.default_value;
    if (!chosen.is_none()) out.set(p.name, chosen);
  }
  return out;
}

}  // namespace

std::string text_of(const GuardActions& did) {
  std::string text;
  for (const Action& action : actions) {
    if (did.*action.done) text += (text.empty() ? "" : ", ") + std::string(action.text);
  }
  return text;
}

std::vector<CheckRow> check(const Assembly& a, const ExternalComponents& external) {
  (void)make_plant(a);
  (void)make_reference(a, make_outside(a, external));
  return check_components(a, external);
}

truth::InnerRates inner_rates(const Assembly& a) {
  return std::visit([](const auto& plant) { return plant.inner_rates(); }, make_plant(a));
}

std::vector<double> free_frequencies(const Assembly& a) {
  Mat3<double> J_B = a.plant.J_B;
  for (const truth::FlexibleMode& mode : a.plant.modes) J_B += mode.inertia_B();
  return truth::free_frequencies(J_B, a.plant.modes);
}

std::vector<ChannelInfo> channels(const Assembly& a, const ExternalComponents& external) {
  const FlightParts parts(a, external);
  return ChannelReader::offered(a.counts(), parts.components, parts.views);
}

Table resolve(const Table& scenario, const Assembly& a) {
  Table out = scenario;
  const auto fill = [&](const char* key, const auto& family, const ComponentSpec& spec) {
    if (spec.type == "python") return;
    out.set(key, resolved(family.find(spec.type, spec.where).describe(a.setup), spec.params, spec.type));
  };
  const Catalogue& c = catalogue();
  fill("navigator", c.navigators, a.navigator);
  fill("observer", c.observers, a.observer);
  fill("detector", c.detectors, a.detector);
  fill("controller", c.controllers, a.controller);
  fill("allocator", c.allocators, a.allocator);
  const auto typed = [&](const char* key, const auto& variant) {
    std::visit([&](const auto& data) { out.set(key, resolved(describe_params(data), {}, data.name)); }, variant);
  };
  if (!a.reference_outside) typed("reference", a.reference);
  typed("integrator", a.plant.integrator);
  return out;
}

RunResult simulate(const Table& scenario, const ExternalComponents& external, const RunOptions& options) {
  return simulate(assemble(scenario), external, options);
}

namespace {

RunResult flown(const Assembly& a, truth::Plant auto& plant, const ExternalComponents& external,
                const RunOptions& options) {
  truth::Sensors sensors(a.sensors, a.run.seed, a.run.run_number, wants_euler(options.channels), a.setup.dt,
                         a.setup.vehicle.wheels, a.plant.orbit, a.run.noise_versions);
  FlightParts parts(a, external);
  ReferencePath reference = make_reference(a, parts.outside);
  std::optional<Recorder> recorder;
  if (options.record) {
    const std::vector<std::string> names =
        options.channels.empty() ? ChannelReader::usual(parts.components, parts.views) : options.channels;
    recorder.emplace(ChannelReader(names, a.counts(), parts.components, parts.views, "record"));
    reserve(*recorder, a, options);
  }
  Watcher watcher(a, plant, parts, recorder ? &*recorder : nullptr, options);
  RunResult result;
  result.end = fly(plant, sensors, reference, parts.stack, a.ticks, watcher, parts.outside);
  result.events = std::move(watcher).take_events();
  result.statistics = plant.statistics();
  if (recorder) {
    result.t = recorder->times();
    result.channels = std::move(*recorder).take();
  }
  return result;
}

}  // namespace

RunResult simulate(const Assembly& a, const ExternalComponents& external, const RunOptions& given) {
  const RunOptions options = with_record_block(given, a.record);
  AnyPlant plant = make_plant(a);
  return std::visit([&](auto& p) { return flown(a, p, external, options); }, plant);
}

}  // namespace gyrostat::host
