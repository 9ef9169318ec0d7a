// SPDX-License-Identifier: MIT
// Effectors of one's own, in a list of one's own: each against an independent form of its equations of motion.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <cstring>

#include "gyrostat/truth/rigid_plant_definitions.hpp"
#include "support.hpp"

namespace gyrostat::truth::test_effectors {
namespace {

using namespace test;

/// Dipole (A m^2) along a body axis in a field that is constant in inertial space: torque axis x B_B.
struct Coil {
  static constexpr const char* name = "coil";
  static constexpr int states = 0;
  static constexpr bool along_axis = false;
  static constexpr Storage storage = Storage::outer;
  int channel = -1;
  Vec3<double> axis_B = Vec3<double>::Zero(), field_N = Vec3<double>::Zero();

  Vec3<double> field_B(const Scene& s) const noexcept { return s.q_NB.conjugate() * field_N; }
  Mat3<double> inertia_B() const { return Mat3<double>::Zero(); }
  Vec3<double> momentum_B(const Scene& s, double P, const double*) const noexcept {
    return P * axis_B.cross(field_B(s));
  }
  Vec3<double> torque_B(const Scene& s, double P, const double*) const noexcept {
    return P * axis_B.cross(field_B(s).cross(s.omega_BN_B));
  }
  Vec3<double> momentum_rate_B(const Scene& s, double P, double Pdot, const double*, const double*) const noexcept {
    return Pdot * axis_B.cross(field_B(s)) + P * axis_B.cross(field_B(s).cross(s.omega_BN_B));
  }
  void rates(const Scene&, double, const double*, double*) const noexcept {}
};

// Half a kind is refused: states that do not move, an impulse beside its axis without a momentum, a torque that is missing.
struct Stateful : Torquer {
  static constexpr int states = 1;
};
struct Astray : Torquer {
  static constexpr bool along_axis = false;
};
struct Leaking : FlexibleMode {
  static constexpr Storage storage = Storage::outer;
};
static_assert(Effector<FlexibleMode> && Effector<Coil> && Effector<Wheel> && Effector<Torquer>);
static_assert(!Effector<Stateful> && !Effector<Astray> && !Effector<Leaking>);

using MyEffectors = EffectorList<Wheel, FrictionWheel, Torquer, FlexibleMode, Coil>;
using MyPlant = RigidPlantOf<MyEffectors>;
static_assert(Plant<MyPlant>);

template <int n, class F>
void classical_step(Eigen::Matrix<double, n, 1>& y, double h, const F& f) {
  using Y = Eigen::Matrix<double, n, 1>;
  const Y k1 = f(y), k2 = f(y + 0.5 * h * k1), k3 = f(y + 0.5 * h * k2), k4 = f(y + h * k3);
  y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
}

Eigen::Vector4d quaternion_rate(const Eigen::Vector4d& q, const Vec3<double>& w) {  // scalar first
  const Quat<double> rate = Quat<double>(q[0], q[1], q[2], q[3]) * Quat<double>(0, w[0], w[1], w[2]);
  return 0.5 * Eigen::Vector4d(rate.w(), rate.x(), rate.y(), rate.z());
}

const Integrator precise[] = {Rk4{4}, Cvode{.rtol = 1e-12, .atol = 1e-14}, Auto{.rtol = 1e-12}};

// J w' + c eta'' = D u - w x (J w + c eta' + D h_w),  c . w' + eta'' = -2 zeta W eta' - W^2 eta,  J with the mode's share.
TEST(Effectors, AFlexibleModeMovesAsItsAccelerationFormSays) {
  const FlexibleMode mode{{0.9, -0.4, 0.3}, 1.5, 0.02, 0.1, -0.05};
  const auto command = [](int k) {
    return vec({0.1 * std::sin(0.3 * k), -0.05, 0.02 * (k % 7), 0.1 * std::cos(0.2 * k)});
  };
  Eigen::Matrix<double, 10, 1> y;  // w, h_w, eta, eta', in this order, and 1 to spare
  const InitialState start = driven_start();
  y << start.omega_BN_B, start.h_w, mode.eta, mode.eta_rate, 0;
  const PlantModel base = wheels();
  const Mat3<double> J = base.J_B;
  VecN<double> u;
  const auto rate = [&](const Eigen::Matrix<double, 10, 1>& s) {
    const Vec3<double> w = s.head<3>();
    Eigen::Matrix4d M;
    M << J, mode.delta_B, mode.delta_B.transpose(), 1;
    Eigen::Vector4d right;
    right << base.D_B * u - w.cross(J * w + mode.delta_B * s[8] + base.D_B * s.segment<4>(3)),
        -2 * mode.xi * mode.omega * s[8] - mode.omega * mode.omega * s[7];
    const Eigen::Vector4d turn = M.inverse() * right;
    Eigen::Matrix<double, 10, 1> out;
    out << turn.head<3>(), -u, s[8], turn[3], 0;
    return out;
  };
  for (int k = 0; k < 2000; ++k) {
    u = command(k);
    for (int j = 0; j < 8; ++j) classical_step<10>(y, 0.00125, rate);
  }
  for (const Integrator& integrator : precise) {
    PlantModel m = base;
    m.integrator = integrator;
    m.J_B -= mode.inertia_B();
    MyEffectors others;
    others.add(mode);
    MyPlant plant(m, start, 0.01, others);
    Vec3<double> before = plant.omega_BN_B();
    for (int k = 0; k < 2000; ++k) {
      if (k == 1999) before = plant.omega_BN_B();
      plant.advance(command(k));
    }
    EXPECT_LE((plant.omega_BN_B() - y.head<3>()).norm(), 1e-10);  // of both: 2.5 ms steps of order four, or rtol 1e-12
    EXPECT_LE((plant.h_w() - y.segment<4>(3)).norm(), 1e-12);
    const Vec3<double> now = plant.sample().omegadot_BN_B;
    EXPECT_LE((now - rate(y).head<3>()).norm(), 1e-10);
    EXPECT_GT(now.norm(), 1e-4);
  }
}

// Rate form J w' = sum u a x B_B - w x J w, with dipoles that jump at every sample.
TEST(Effectors, CoilsTurnTheBodyAsTheirRateFormSaysAndCvodeKeepsItsHistory) {
  const Vec3<double> field_N{2e-5, -1e-5, 3e-5};
  const auto command = [](int k) { return vec({k % 2 ? 30.0 : -30.0, k % 3 ? 10.0 : -25.0, k % 5 ? -30.0 : 30.0}); };
  PlantModel base;
  base.J_B = Vec3<double>{1.0, 1.4, 0.8}.asDiagonal();
  base.D_B = Mat3<double>::Identity();
  base.actuators = Actuators::ideal(3);
  const InitialState start{quat_from_mrp(sigma_0), {0.02, -0.01, 0.03}, {}};
  Eigen::Matrix<double, 7, 1> y;
  y << start.q_NB.w(), start.q_NB.vec(), start.omega_BN_B;
  VecN<double> u;
  const auto rate = [&](const Eigen::Matrix<double, 7, 1>& s) {
    const Quat<double> q(s[0], s[1], s[2], s[3]);
    const Vec3<double> w = s.tail<3>(), dipole = u;
    const Vec3<double> moment = dipole.cross(q.conjugate() * field_N) - w.cross(base.J_B * w);
    Eigen::Matrix<double, 7, 1> out;
    out << quaternion_rate(s.head<4>(), w), base.J_B.inverse() * moment;
    return out;
  };
  for (int k = 0; k < 1000; ++k) {
    u = command(k);
    for (int j = 0; j < 4; ++j) classical_step<7>(y, 0.025, rate);
  }
  for (const Integrator& integrator : precise) {
    PlantModel m = base;
    m.integrator = integrator;
    MyEffectors others;
    for (int i = 0; i < 3; ++i) others.add(Coil{i, Vec3<double>::Unit(i), field_N});
    MyPlant plant(m, start, 0.1, others);
    for (int k = 0; k < 1000; ++k) plant.advance(command(k));
    EXPECT_LE((plant.omega_BN_B() - y.tail<3>()).norm(), 1e-10);  // 25 ms steps of order four on 0.05 rad/s, 100 s
    EXPECT_LE((plant.sample().omegadot_BN_B - rate(y).tail<3>()).norm(), 1e-10);
    const bool kept = plant.statistics().restarts == 1;
    EXPECT_EQ(kept, std::holds_alternative<Cvode>(integrator));
  }
}

TEST(Effectors, EachNeedsAChannelOfItsOwn) {
  MyEffectors twice, beyond;
  twice.add(Coil{1});
  twice.add(Coil{1});
  beyond.add(Coil{4});
  EXPECT_THROW(MyPlant(torquers(Rk4{}), {}, 0.01, twice), std::invalid_argument);
  EXPECT_THROW(MyPlant(torquers(Rk4{}), {}, 0.01, beyond), std::invalid_argument);
}

TEST(Effectors, KindsThatNobodyUsesChangeNoBit) {
  for (const Integrator& integrator : {Integrator(Rk4{}), Integrator(Cvode{})}) {
    PlantModel m = driven_model(integrator);
    m.actuators.viscous_friction.setConstant(1e-3);
    m.actuators.coulomb_friction.setConstant(1e-3);
    RigidPlant a(m, driven_start(), 0.01);
    MyPlant b(m, driven_start(), 0.01);
    for (int k = 0; k < 500; ++k) {
      a.advance(driven_command(true));
      b.advance(driven_command(true));
      if (k == 200) b = MyPlant(std::move(b));  // nor does it matter where the plant is
    }
    EXPECT_EQ(a.omega_BN_B(), b.omega_BN_B());
    EXPECT_EQ(a.h_w(), b.h_w());
    EXPECT_EQ(a.sample().omegadot_BN_B, b.sample().omegadot_BN_B);
  }
}

}  // namespace
}  // namespace gyrostat::truth::test_effectors
