// SPDX-License-Identifier: MIT
/// @file  From a scenario (a table of plain values) to a run. What Python and the command line call.
///
/// The layout of the table stands in docs/scenario.md. Bad input throws std::invalid_argument with one line that says
/// what, where, and what is allowed, before anything runs.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "gyrostat/host/assembly.hpp"
#include "gyrostat/host/loop.hpp"
#include "gyrostat/host/recorder.hpp"

namespace gyrostat::host {

/// A dated event: a counter of a component, the detector or the reference went up, and to what. Of what the guard did
/// (guard.rate, guard.controller, ...): the first time, and at how many samples in all. Of detection: detector.event when
/// actuators are declared, detector.class when one is of another class than before, detector.recovered.
struct Event {
  double t;
  std::string name;
  int count;
  std::string what = {};  ///< of detection: "actuator 2 stuck", one after the other; else ""
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
std::vector<CheckRow> check(const Assembly& a, const ExternalComponents& external = {});

/// How quick the truth is at the start, against the period.
truth::InnerRates inner_rates(const Assembly& a);
/// rad/s, ascending, of the modes of its appendages on the body that is free to turn.
std::vector<double> free_frequencies(const Assembly& a);

/// The scenario that `a` was made from, with every default filled in.
Table resolve(const Table& scenario, const Assembly& a);

/// Channels that a run of this scenario offers.
std::vector<ChannelInfo> channels(const Assembly& a, const ExternalComponents& external = {});

/// Runs the scenario. A failing integration, a singularity, a non-finite state or a stack without a command of its own is no
/// error: the result says so.
RunResult simulate(const Assembly& a, const ExternalComponents& external = {}, const RunOptions& options = {});
RunResult simulate(const Table& scenario, const ExternalComponents& external = {}, const RunOptions& options = {});

}  // namespace gyrostat::host
