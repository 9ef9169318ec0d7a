// SPDX-License-Identifier: MIT
/// @file  Every detector of the library, in the order of the catalogue.
#pragma once
#include "gyrostat/core/components.hpp"
#include "gyrostat/flight/detectors/evidence.hpp"
#include "gyrostat/flight/detectors/none.hpp"
#include "gyrostat/flight/detectors/threshold.hpp"

namespace gyrostat {

using Detectors = Components<NoDetector, ThresholdDetector, EvidenceDetector>;

}  // namespace gyrostat
