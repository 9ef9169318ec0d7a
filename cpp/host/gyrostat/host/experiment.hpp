// SPDX-License-Identifier: MIT
/// @file  One scenario flown many times with other numbers in it: on threads, in constant memory, every flight again alone.
///
/// A flight is a function of the scenario, its number and its values. The number keys the noise (`run_number` of the scenario),
/// so that flights may be flown in any order, on any thread, or alone: the same bits come out.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "gyrostat/host/loop.hpp"
#include "gyrostat/host/metrics.hpp"
#include "gyrostat/host/slots.hpp"

namespace gyrostat::host {

/// What became of one flight.
struct Flight {
  RunEnd end;  ///< with code `refused` and the reason, if the values fit no vehicle: then nothing flew
  std::vector<double> metrics;
};

/// Flies on behalf of `Experiment::fly`.
struct FlyOptions {
  unsigned threads = 1;
  /// Called with the number of finished flights about five times a second, on the calling thread; may throw, which stops all.
  std::function<void(std::size_t)> progress;
};

/// Components from outside the catalogue, made anew for every flight. They fly on one thread.
using ExternalSource = std::function<ExternalComponents()>;

class Experiment {
 public:
  /// @param vary  paths of the numbers that differ, see Slots
  /// @param measures  a table a metric: metric, signal (a channel), column (absent: all), and the metric's own numbers, of which
  ///                  instants may be "last_fault"; `last = 5` is a window of the last 5 s
  /// @throws std::invalid_argument, one line
  Experiment(const Table& scenario, const std::vector<std::string>& vary, const Table& measures,
             ExternalSource external = {});

  /// One name a value of a flight.
  const std::vector<std::string>& columns() const noexcept { return slots_.columns(); }
  /// Those of `measures`, in its order.
  std::vector<std::string> metrics() const;

  /// The scenario of one flight; `simulate` of it is that flight, with a record.
  Table scenario(std::uint64_t number, std::span<const double> values) const;

  /// Flights first, first + 1, ..., one a row of `values`, in this order.
  /// What a component from outside raises stops all and passes through.
  std::vector<Flight> fly(std::uint64_t first, std::size_t flights, std::span<const double> values,
                          const FlyOptions& options = {}) const;

 private:
  struct Meter {
    std::string name, channel;
    int column = -1;
    Metric metric;
    std::vector<std::string> at_last_fault;  ///< numbers of the metric that are the onset of the last fault
  };
  class Worker;

  static Meter meter_of(const std::string& name, const Value& entry, double duration);

  ExternalSource external_;
  Assembly nominal_;
  Slots slots_;
  std::vector<Meter> meters_;
  std::vector<std::string> channels_;  ///< that the meters read, each once
};

}  // namespace gyrostat::host
