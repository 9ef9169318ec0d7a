// SPDX-License-Identifier: MIT
/// @file  The same law entered into the catalogue: the host loop flies it by name, its parameters are checked like ours.
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "gyrostat/host/catalogue.hpp"
#include "gyrostat/host/simulate.hpp"
#include "quaternion_law.hpp"

namespace {

namespace gh = gyrostat::host;

gh::Table scenario(double k_q) {
  return {{"duration", 60.0},
          {"dt", 0.01},
          {"vehicle",
           gh::Table{{"J_B", gh::List{20.0, 17.0, 15.0}},
                     {"D_B", gh::List{gh::List{1.0, 0.0, 0.0}, gh::List{0.0, 1.0, 0.0}, gh::List{0.0, 0.0, 1.0}}},
                     {"u_max", 0.5}}},
          {"initial", gh::Table{{"mrp", gh::List{0.1, 0.1, -0.1}}}},
          {"controller", gh::Table{{"type", "consumer_quaternion"}, {"k_q", k_q}}}};
}

bool refuses_negative_gain() {
  try {
    gh::simulate(scenario(-1.0));
  } catch (const std::invalid_argument& e) {
    std::printf("refused as it should: %s\n", e.what());
    return std::string(e.what()).find("k_q") != std::string::npos;
  }
  return false;
}

}  // namespace

int main() {
  gh::catalogue().add(gh::controller<consumer::QuaternionLaw>());
  gh::RunOptions options;
  options.channels = {"error.angle"};
  const gh::RunResult result = gh::simulate(scenario(2.0), {}, options);
  const double angle = result.channels.at(0).data.back();
  std::printf("pointing error after %.0f s: %.2e rad\n", result.end.time, angle);
  const bool flown = result.end.code == gh::RunEnd::Code::completed && angle < 1e-2;
  return flown && refuses_negative_gain() ? 0 : 1;
}
