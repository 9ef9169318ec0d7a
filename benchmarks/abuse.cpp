// SPDX-License-Identifier: MIT
// A million samples a component with spoilt inputs (NaN, infinite, huge, tiny, wrong, frozen, missing): what came out, and the
// slowest way back to normal flight. `bench_abuse [samples [component...]]` prints tests/golden/recovery.csv, which the docs show
// and a test holds; then a million more, over fifteen vehicles with limits of every kind. Exit status 1 for a command that was not
// finite or outside its limits, or a loop that did not recover.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "../tests/cpp/host/abuse.hpp"
#include "gyrostat/host/catalogue.hpp"

namespace {

using namespace gyrostat;

bool bad(const std::string& what, const test::Outcome& o) {
  if (o.not_finite + o.outside + o.unrecovered == 0) return false;
  std::fprintf(stderr, "%s: %ld commands not finite, %ld outside their limits, %ld times not recovered (%s)\n",
               what.c_str(), o.not_finite, o.outside, o.unrecovered, test::name_of(o.slowest_after));
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  const long samples = argc > 1 ? std::atol(argv[1]) : 1000000;
  int wrong = 0;
  std::printf("# FTC-4RW at 100 Hz, one component exchanged, %ld samples each with bursts of 1 to 500 spoilt inputs.\n",
              samples);
  std::printf("# stated: the slowest recovery with a quarter on top, in samples, rounded up.\n");
  std::printf("# slew: what a stack takes that is started where the slowest episode left the vehicle.\n");
  std::printf("role,component,stated,slowest,after,slew,episodes,input_held,restarted\n");
  for (const auto& [role, names] : host::families()) {
    if (role != "observer" && role != "detector" && role != "controller" && role != "allocator") continue;
    for (const std::string& name : names) {
      if (argc > 2 && std::find(argv + 2, argv + argc, name) == argv + argc) continue;
      const bool regulates = role != "controller" || host::describe(role, name).traits.regulates;
      const test::Outcome o = test::abuse(test::loop_with(role, name), regulates, samples, 20261124u);
      const long stated = (o.slowest + o.slowest / 4) / 100 * 100 + 100;
      std::printf("%s,%s,%ld,%ld,%s,%ld,%ld,%ld,%ld\n", role.c_str(), name.c_str(), stated, o.slowest,
                  o.slowest > 0 ? test::name_of(o.slowest_after) : "", o.slew, o.episodes, o.held, o.reset);
      std::fflush(stdout);
      wrong += bad(role + " " + name, o);
      for (int which = 0; which < test::vehicles; ++which) {
        const test::Outcome other = test::abuse(test::loop_on(which, role, name), regulates && test::can_point(which),
                                                samples / test::vehicles, 20261125u);
        wrong += bad(role + " " + name + " on vehicle " + std::to_string(which), other);
      }
    }
  }
  return wrong > 0 ? 1 : 0;
}
