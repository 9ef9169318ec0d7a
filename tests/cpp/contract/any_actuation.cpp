// SPDX-License-Identifier: MIT
#include "contract/any_components_of_roles.hpp"

namespace gyrostat::test {
template std::span<const Maker<NavigatorRole<GYROSTAT_TEST_SCALAR>>> makers();
template std::span<const Maker<ControllerRole<GYROSTAT_TEST_SCALAR>>> makers();
template std::span<const Maker<AllocatorRole<GYROSTAT_TEST_SCALAR>>> makers();
template class AnyStack<GYROSTAT_TEST_SCALAR>;
template class AnyStack<GYROSTAT_TEST_SCALAR, AnyNavigator<GYROSTAT_TEST_SCALAR>>;
}  // namespace gyrostat::test
