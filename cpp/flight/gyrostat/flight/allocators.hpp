// SPDX-License-Identifier: MIT
/// @file  Every allocator of the library, in the order of the catalogue.
#pragma once
#include "gyrostat/core/components.hpp"
#include "gyrostat/flight/allocators/lexicographic.hpp"
#include "gyrostat/flight/allocators/lexicographic_scaled.hpp"
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/allocators/robust_socp.hpp"
#include "gyrostat/flight/allocators/singularity_robust.hpp"
#include "gyrostat/flight/allocators/weighted_least_squares.hpp"

namespace gyrostat {

using Allocators =
    Components<Lexicographic, LexicographicScaled, PseudoInverse, RobustSocp, SingularityRobust, WeightedLeastSquares>;

}  // namespace gyrostat
