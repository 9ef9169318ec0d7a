// SPDX-License-Identifier: MIT
/// @file  From a scenario (a table of plain values) to a run. What Python and the command line call.
///
/// The layout of the table stands in docs/scenario.md. Bad input throws std::invalid_argument with one line that says
/// what, where, and what is allowed, before anything runs.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "gyrostat/host/any.hpp"
#include "gyrostat/host/loop.hpp"
#include "gyrostat/host/recorder.hpp"
#include "gyrostat/host/value.hpp"

namespace gyrostat::host {

/// Components that come from outside the catalogue, for roles whose entry has type = "python".
struct ExternalComponents {
  std::function<std::unique_ptr<ObserverBase>(const Setup<double>&)> observer;
  std::function<std::unique_ptr<DetectorBase>(const Setup<double>&)> detector;
  std::function<std::unique_ptr<ControllerBase>(const Setup<double>&)> controller;
  std::function<std::unique_ptr<AllocatorBase>(const Setup<double>&)> allocator;
};

/// One line of `gyrostat check`.
struct CheckRow {
  std::string where, name;
  Status<double> status;
};

/// A dated event: a counter of a component, the detector or the reference went up, and to what. Of what the guard did
/// (guard.rate, guard.controller, ...): the first time, and at how many samples in all.
struct Event {
  double t;
  std::string name;
  int count;
};

struct RunOptions {
  std::vector<std::string> channels;  ///< empty: as [record] says, or the usual ones
  bool record = true;
  std::size_t every = 0;                 ///< record every so many samples, the last one always; 0: as [record] says
  std::function<void(double)> progress;  ///< called with the fraction done about five times a second; may throw
  double memory = unbounded;             ///< bytes that the record may take; a run that needs more is refused
};

struct RunResult {
  std::vector<double> t;
  std::vector<Recorder::Channel> channels;
  std::vector<Event> events;
  RunEnd end;
  truth::IntegratorStatistics statistics;
};

/// Builds everything without running and asks each component whether it fits.
std::vector<CheckRow> check(const Table& scenario, const ExternalComponents& external = {});

/// Estimates by role: those that the observer makes and those that the others use. Nothing is known of a component from
/// outside the catalogue: its role is left out.
std::vector<std::pair<std::string, Estimates>> estimate_flow(const Table& scenario);

/// How quick the truth is at the start, against the period.
truth::InnerRates inner_rates(const Table& scenario);

/// The scenario with every default filled in.
Table resolve(const Table& scenario, const ExternalComponents& external = {});

/// Channels that a run of this scenario offers.
std::vector<ChannelInfo> channels(const Table& scenario, const ExternalComponents& external = {});

/// Runs the scenario. A failing integration, a singularity, a non-finite state or a stack without a command of its own is no
/// error: the result says so.
RunResult simulate(const Table& scenario, const ExternalComponents& external = {}, const RunOptions& options = {});

}  // namespace gyrostat::host
