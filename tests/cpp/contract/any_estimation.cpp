// SPDX-License-Identifier: MIT
#include "contract/any_components_of_roles.hpp"

namespace gyrostat::test {
template std::span<const Maker<ObserverRole<GYROSTAT_TEST_SCALAR>>> makers();
template std::span<const Maker<DetectorRole<GYROSTAT_TEST_SCALAR>>> makers();
}  // namespace gyrostat::test
