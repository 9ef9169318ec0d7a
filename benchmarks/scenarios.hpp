// SPDX-License-Identifier: MIT
/// @file  The scenarios that benchmarks fly, as the host reads them.
#pragma once
#include <numbers>

#include "gyrostat/host/value.hpp"

namespace gyrostat::bench {

using host::List;
using host::Table;
using host::Value;

inline List row(std::initializer_list<double> numbers) { return List(numbers.begin(), numbers.end()); }

inline Table pyramid_vehicle(double u_max, double wheel_inertia, const List& x, const List& y, const List& z) {
  return {{"J_B", List{row({20, 0, 0.9}), row({0, 17, 0}), row({0.9, 0, 15})}},
          {"D_B", List{x, y, z}},
          {"u_max", u_max},
          {"wheel_inertia", wheel_inertia}};
}

/// FTC-4RW: four wheels, plain MRP feedback (K = 1, P = 5), constant disturbance, 200 s at 100 Hz.
inline Table ftc_4rw(const char* integrator) {
  const double s = 1 / std::numbers::sqrt3;
  return {{"duration", 200.0},
          {"dt", 0.01},
          {"vehicle", pyramid_vehicle(0.2, 0.05, row({s, s, -s, -s}), row({s, -s, -s, s}), row({s, s, s, s}))},
          {"initial", Table{{"mrp", row({0.1, 0.2, -0.3})}, {"omega_BN_B", row({0.01, -0.02, 0.03})}}},
          {"observer", Table{{"type", "passthrough"}}},
          {"controller", Table{{"type", "mrp_feedback"}, {"K", 1.0}, {"P", 5.0}}},
          {"allocator", Table{{"type", "pseudo_inverse"}}},
          {"disturbances", List{Table{{"type", "constant"}, {"torque_B", row({1e-3, -2e-3, 1.5e-3})}}}},
          {"integrator", Table{{"type", integrator}}}};
}

/// FTC-4RW with the joint filter and the integral law, a wheel at 40 % from 50 s.
inline Table joint() {
  Table out = ftc_4rw("rk4");
  out.set("observer", Table{{"type", "joint_kalman"}});
  out.set("controller", Table{{"type", "integral_sliding_mode"}});
  out.set("faults",
          List{Table{{"type", "loss_of_effectiveness"}, {"actuator", 2}, {"t_on", 50.0}, {"remaining", 0.4}}});
  return out;
}

/// The same with the whole recommended stack.
inline Table recommended() {
  Table out = joint();
  out.set("detector", Table{{"type", "evidence"}, {"drop", false}});
  out.set("allocator", Table{{"type", "lexicographic"}});
  return out;
}

/// Li et al. 2018, Table 1: degraded wheels, disturbance observer and integral sliding mode, at 1 kHz.
inline Table li2018_table1(double duration) {
  const double s = 1 / std::numbers::sqrt3, half_pi = std::numbers::pi / 2;
  const auto fault = [](const char* type, int actuator, const char* key, Value value, double t_on = 0) {
    return Table{{"type", type}, {"actuator", actuator}, {"t_on", t_on}, {key, std::move(value)}};
  };
  const auto sine = [](double offset, double amplitude, double omega) {
    return Table{{"type", "sine"}, {"offset", offset}, {"amplitude", amplitude}, {"omega", omega}};
  };
  return {{"duration", duration},
          {"dt", 0.001},
          {"vehicle", pyramid_vehicle(0.25, 0, row({s, -s, -s, s}), row({s, s, -s, -s}), row({s, s, s, s}))},
          {"initial", Table{{"mrp", row({-0.1579, 0.1368, 0.0947})}}},
          {"observer", Table{{"type", "finite_time_disturbance"}, {"alpha1", 0.6}, {"lambda1", 1.0}, {"lambda2", 0.6}}},
          {"controller", Table{{"type", "integral_sliding_mode"},
                               {"k1", 4.9},
                               {"k2", 3.0},
                               {"beta1", 0.9},
                               {"K3", row({6.5, 6.7, 7.2})},
                               {"K4", row({4, 4.22, 4})},
                               {"gamma", 0.88},
                               {"zeta1", 0.2},
                               {"zeta2", 0.2},
                               {"mu", 0.1},
                               {"gain_0", row({0.15, 0.15, 0.15})},
                               {"eps", 0.01},
                               {"s_lim", 0.05}}},
          {"allocator", Table{{"type", "pseudo_inverse"}}},
          {"integrator", Table{{"type", "rk4"}}},
          {"faults", List{fault("loss_of_effectiveness", 0, "remaining", 0.5, 10.0),
                          fault("loss_of_effectiveness", 1, "remaining",
                                Table{{"type", "square"}, {"high", 0.85}, {"low", 0.6}, {"period", 100.0}}),
                          fault("loss_of_effectiveness", 2, "remaining", sine(0.9, 0.07, 0.2)),
                          fault("loss_of_effectiveness", 3, "remaining", 0.2, 10.0), fault("bias", 1, "torque", 0.008),
                          fault("bias", 2, "torque", sine(0, 0.05, 1.0)), fault("bias", 3, "torque", 0.005)}},
          {"disturbances", List{Table{{"type", "rate_phase"},
                                      {"gain", 10.0},
                                      {"offset_B", row({-2e-3, 3e-3, 2.25e-3})},
                                      {"axis", row({0, 0, 1, 1, 2, 2})},
                                      {"amplitude", row({5e-4, 7.5e-4, -3.75e-4, 7.5e-4, 7.5e-4, -1.5e-3})},
                                      {"multiple", row({10, 3, 2, 5, 10, 4})},
                                      {"phase", row({half_pi, 0, 0, half_pi, 0, 0})}}}}};
}

/// Wang, Jia, Yu 2023, Tables 1 and 2: three torquers, mixed learning observer and sliding mode, at 1 kHz.
inline Table wang2023(double duration) {
  return {{"duration", duration},
          {"dt", 0.001},
          {"vehicle", Table{{"J_B", List{row({18.73, 1, 0.09}), row({1, 20.77, 0.092}), row({0.09, 0.092, 23.63})}},
                            {"D_B", List{row({1, 0, 0}), row({0, 1, 0}), row({0, 0, 1})}}}},
          {"initial", Table{{"q_NB", row({0.515, 0.7221, 0.376, 0.2681})}, {"omega_BN_B", row({0.16, 0.12, 0.1})}}},
          {"observer",
           Table{{"type", "mixed_learning_disturbance"},
                 {"K1", List{row({0.2159, 0.0062, 0.0006}), row({0.0062, 0.2285, 0.0006}), row({6e-4, 6e-4, 0.2462})}},
                 {"K2", List{row({4.8176, -0.2319, -0.0174}), row({-0.2319, 4.3444, -0.016}),
                             row({-0.0174, -0.016, 3.8088})}},
                 {"theta1", 0.005},
                 {"theta2", 0.99}}},
          {"controller", Table{{"type", "mixed_learning_sliding_mode"},
                               {"delta", 0.1},
                               {"k_lin", 3.0},
                               {"k_sgn", 0.01},
                               {"width", 0.0},
                               {"K3", List{row({1, 0, 0}), row({0, 1, 0}), row({0, 0, 1})}},
                               {"theta3", 0.99}}},
          {"allocator", Table{{"type", "pseudo_inverse"}}},
          {"integrator", Table{{"type", "rk4"}}},
          {"faults", List{Table{{"type", "bias"}, {"actuator", 0}, {"t_on", 5.0}, {"torque", 0.1}}}}};
}

/// Cao, Gong, Xue, Wen 2023: four thrusters at 1 kHz, memory of ten samples, T = 5 s; the printed Euler-angle model or a body.
inline Table cao2023(const char* coordinates) {
  return {
      {"duration", 10.0},
      {"dt", 0.001},
      {"vehicle", Table{{"coordinates", coordinates},
                        {"J_B", row({200, 400, 200})},
                        {"D_B", List{row({134, 134, 134, 134}), row({276, -276, -276, 276}), row({56, 56, -56, -56})}},
                        {"orbit_rate", 0.0010312}}},
      {"initial", Table{{"euler", row({-0.7, -0.07, 1.5})}, {"omega_BN_B", row({0.5, 1.3, -0.2})}}},
      {"reference", Table{{"type", "euler_sine"},
                          {"offset", row({2, 0, 0})},
                          {"amplitude", row({0, 0, 0.5})},
                          {"frequency", row({0, 0, 2})},
                          {"phase", row({0, 0, std::numbers::pi / 2})}}},
      {"observer", Table{{"type", "learning_disturbance"},
                         {"form", "rolling"},
                         {"interval", 0.01},
                         {"M", 18.0},
                         {"k1", 0.98},
                         {"k2", 15.0},
                         {"k3", 5.0}}},
      {"controller", Table{{"type", "preassigned_time_sliding_mode"},
                           {"T", 5.0},
                           {"c", 10.0},
                           {"b", 2.0},
                           {"eta", 5.5},
                           {"layer", 0.1},
                           {"stretch", 0.0}}},
      {"allocator", Table{{"type", "pseudo_inverse"}}},
      {"integrator", Table{{"type", "rk4"}, {"substeps", 2}}},
      {"faults", List{Table{{"type", "bias"}, {"actuator", 0}, {"torque", 2.0}},
                      Table{{"type", "bias"}, {"actuator", 2}, {"torque", 5.0}}}}};
}

/// Cao, Gong, Han 2022, Table 1 with a boundary layer, following a moving reference: repaired learning observer and
/// predefined-time law, three wheels, at 100 Hz.
inline Table cao2022(double duration) {
  const auto fault = [](int actuator, double t_on, double remaining) {
    return Table{{"type", "loss_of_effectiveness"}, {"actuator", actuator}, {"t_on", t_on}, {"remaining", remaining}};
  };
  return {{"duration", duration},
          {"dt", 0.01},
          {"allow_unstable", true},
          {"vehicle", Table{{"J_B", row({36, 17, 26})},
                            {"D_B", List{row({1, 0, 0}), row({0, 1, 0}), row({0, 0, 1})}},
                            {"u_max", 20.0}}},
          {"initial", Table{{"mrp", row({0.3, -0.2, 0.2})}}},
          {"reference", Table{{"type", "mrp_sine"},
                              {"amplitude", row({0.1, 0.1, 0.1})},
                              {"frequency", row({0.8, 0.6, 0.7})},
                              {"phase", row({0, 1, 2})}}},
          {"observer", Table{{"type", "learning_effectiveness"},
                             {"kappa", 0.03},
                             {"u0", 0.3},
                             {"u_exc", 0.3},
                             {"M", row({80, 50, 60})},
                             {"n", 2.5},
                             {"torque_error", 0.02},
                             {"memory", 30.0}}},
          {"controller", Table{{"type", "predefined_time"},
                               {"h1", 0.5},
                               {"T1", 10.0},
                               {"h2", 0.3},
                               {"T2", 10.0},
                               {"k_s", 5.0},
                               {"phi", 0.01},
                               {"floor1", 1.25e-3},
                               {"floor2", 1e-12}}},
          {"allocator", Table{{"type", "pseudo_inverse"}}},
          {"integrator", Table{{"type", "rk4"}}},
          {"faults", List{fault(0, 5.0, 0.8), fault(1, 8.0, 0.6), fault(2, 10.0, 0.4)}}};
}

/// Yang et al. 2023: one slew of three axes and a spare at 100 Hz, actuator 0 at 60 % from 4 s, so that all four are in use;
/// robust allocation.
inline Table yang2023_slew(double duration) {
  const double s = 1 / std::numbers::sqrt3;
  return {
      {"duration", duration},
      {"dt", 0.01},
      {"vehicle", Table{{"J_B", List{row({43, 0.3, 1.2}), row({0.3, 52, -0.5}), row({1.2, -0.5, 40})}},
                        {"D_B", List{row({1, 0, 0, s}), row({0, 1, 0, s}), row({0, 0, 1, s})}},
                        {"u_max", 0.25},
                        {"spare", row({3})}}},
      {"initial", Table{{"euler", row({0.35, -0.26, 0.1})}}},
      {"observer", Table{{"type", "adaptive_iterative_learning"}}},
      {"detector", Table{{"type", "threshold"}}},
      {"controller", Table{{"type", "prescribed_performance"}}},
      {"allocator", Table{{"type", "robust_socp"}, {"residual_weight", 1e3}}},
      {"sensors", List{Table{{"type", "gyro"}, {"noise", 1.745e-5}}}},
      {"faults", List{Table{{"type", "loss_of_effectiveness"}, {"actuator", 0}, {"t_on", 4.0}, {"remaining", 0.6}}}},
      {"integrator", Table{{"type", "rk4"}}}};
}

}  // namespace gyrostat::bench
