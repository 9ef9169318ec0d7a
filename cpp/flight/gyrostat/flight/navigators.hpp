// SPDX-License-Identifier: MIT
/// @file  Every navigator of the library, in the order of the catalogue.
#pragma once
#include "gyrostat/core/components.hpp"
#include "gyrostat/flight/navigators/mekf.hpp"
#include "gyrostat/flight/navigators/none.hpp"

namespace gyrostat {

using Navigators = Components<NoNavigator, Mekf>;

}  // namespace gyrostat
