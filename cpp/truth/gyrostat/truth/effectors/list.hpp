// SPDX-License-Identifier: MIT
/// @file  The effectors there are. A new kind is its header and a word here.
#pragma once
#include "gyrostat/truth/effectors/control_moment_gyro.hpp"
#include "gyrostat/truth/effectors/flexible_mode.hpp"
#include "gyrostat/truth/effectors/magnetorquer.hpp"
#include "gyrostat/truth/effectors/torquer.hpp"
#include "gyrostat/truth/effectors/wheel.hpp"

namespace gyrostat::truth {

using Effectors = EffectorList<Wheel, FrictionWheel, Torquer, FlexibleMode, ControlMomentGyro, Magnetorquer>;

}  // namespace gyrostat::truth
