// SPDX-License-Identifier: MIT
/// @file  Linear sliding mode of rate and quaternion error, alone or with an adaptive radial-basis network.
///
///   s = w_e + delta q
///   tau_B = equivalent - k_lin s - k_sgn sat(s / width) - W' phi(q, w_e)
///   W' = rate (phi s' - leak |s| W)
///
/// Source: Zou 2016 as Wang, Jia, Yu 2023 use it for comparison; the network is an approximation of the cited one.
/// Page: docs/components/sliding_mode.md
#pragma once
#include <array>
#include <cmath>

#include "gyrostat/flight/controllers/parts/rate_attitude_surface.hpp"
#include "gyrostat/flight/parts/chart.hpp"

namespace gyrostat {

/// The comparison of the publication knows of no fault: `compensate = false`.
template <class S>
class SlidingMode {
 public:
  using Scalar = S;
  static constexpr const char* name = "sliding_mode";
  static constexpr bool axiswise = true;
  static constexpr bool switching = true;
  static constexpr bool regulates = true;
  static constexpr int nodes = 13;  ///< the origin, and one each way along each of the six inputs

  struct Params : SurfaceGains<S> {
    bool compensate = true;
    S network_rate = S(0);
    S network_leak = S(0.05);
    S network_reach = S(0.5);

    static constexpr void describe(auto& p, auto&& field) {
      SurfaceGains<S>::describe(p, field);
      field(p.compensate, Switch{"compensate", "subtract the observer's d_B"});
      field(p.network_rate, Field{"network_rate", "N m/rad", 0, 1e9, "adaptation of the network; 0: none"});
      field(p.network_leak, Field{"network_leak", "rad/(N m s)", 0, 1e9, "forgetting, per |s|"});
      field(p.network_reach, Field{"network_reach", "", 1e-3, 1e3, "distance of the nodes, and their width"});
    }

    /// `SurfaceGains`, no network.
    explicit Params(const Setup<S>& setup) noexcept : SurfaceGains<S>(setup) {}
  };

  static constexpr Estimates uses(const Params& p) noexcept { return {.d_B = p.compensate}; }

  /// The sampled slope must be stable about the smallest inertia.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const S J = smallest_inertia(setup.vehicle.J_B), slope = p.k_lin + p.slope();
    return needs_body_coordinates(setup) &&
           Status<S>::require(slope * setup.dt < S(2) * J, "(k_lin + k_sgn / width) * dt", slope * setup.dt, S(2) * J,
                              "<", Status<S>::Code::unstable);
  }

  SlidingMode(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : dt_(setup.dt), params_(params), surface_({params.delta}) {}

  [[nodiscard]] Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                                const Reference<S>& ref) noexcept {
    weights_.setZero();
    return demand(vehicle, x, ref);
  }
  [[nodiscard]] Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                               const Reference<S>& ref, const Allocation<S>&) noexcept {
    return demand(vehicle, x, ref);
  }

  void telemetry(auto&& log) const {
    log("s", s_);
    log("network", network_);
  }

 private:
  using Activation = Eigen::Matrix<S, nodes, 1>;

  Demand<S> demand(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) noexcept {
    const typename RateAttitudeSurface<S>::Value at = surface_(vehicle, x, ref);
    s_ = at.s;
    Demand<S> out;
    out.tau_B = at.equivalent_B + params_.reaching(s_);
    if (params_.network_rate > S(0)) out.tau_B -= network(vehicle, x, ref);
    if (params_.compensate) out.tau_B -= x.d_B;
    return out;
  }

  /// Torque of the network with the weights so far, which then make an Euler step. The forgetting is implicit: bounded for
  /// every s.
  const Vec3<S>& network(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) noexcept {
    const Tracking<S> error = track(vehicle, x, ref);
    const Vec3<S> q = quat_from_mrp(error.sigma_BR).vec();
    const Activation phi = activation(q, error.omega_BR_B);
    network_ = weights_.transpose() * phi;
    const S forget = dt_ * params_.network_rate * params_.network_leak * s_.norm();
    weights_ = (weights_ + dt_ * params_.network_rate * phi * s_.transpose()) / (S(1) + forget);
    return network_;
  }

  Activation activation(const Vec3<S>& q, const Vec3<S>& w) const noexcept {
    const S r = params_.network_reach;
    const S square = q.squaredNorm() + w.squaredNorm();
    Activation phi;
    phi[0] = std::exp(-square / (r * r));
    for (int i = 0; i < 3; ++i) {
      const std::array<S, 2> input{q[i], w[i]};
      for (int j = 0; j < 2; ++j) {
        const S in = input[static_cast<std::size_t>(j)];
        phi[1 + 4 * i + 2 * j] = std::exp(-(square - S(2) * r * in + r * r) / (r * r));
        phi[2 + 4 * i + 2 * j] = std::exp(-(square + S(2) * r * in + r * r) / (r * r));
      }
    }
    return phi;
  }

  S dt_;
  Params params_;
  RateAttitudeSurface<S> surface_;
  Eigen::Matrix<S, nodes, 3> weights_ = Eigen::Matrix<S, nodes, 3>::Zero();  ///< N m
  Vec3<S> s_ = Vec3<S>::Zero();                                              ///< rad/s
  Vec3<S> network_ = Vec3<S>::Zero();                                        ///< N m
};

}  // namespace gyrostat
