// SPDX-License-Identifier: MIT
/// @file  The faults there are. A new kind is its header and a word here.
#pragma once
#include "gyrostat/truth/faults/bias.hpp"
#include "gyrostat/truth/faults/dead.hpp"
#include "gyrostat/truth/faults/dead_zone.hpp"
#include "gyrostat/truth/faults/drift.hpp"
#include "gyrostat/truth/faults/hard_over.hpp"
#include "gyrostat/truth/faults/intermittent.hpp"
#include "gyrostat/truth/faults/leak.hpp"
#include "gyrostat/truth/faults/lock.hpp"
#include "gyrostat/truth/faults/loss_of_effectiveness.hpp"
#include "gyrostat/truth/faults/rotor_slow_down.hpp"
#include "gyrostat/truth/faults/slow_valve.hpp"
#include "gyrostat/truth/faults/stuck.hpp"

namespace gyrostat::truth {

using Fault = FaultList<LossOfEffectiveness, Bias, StuckOutput, HardOver, Dead, Lock, Drift, Intermittent, DeadZone,
                        Leak, SlowValve, RotorSlowDown>;

}  // namespace gyrostat::truth
