// SPDX-License-Identifier: MIT
#include "gyrostat/truth/rigid_plant_definitions.hpp"

namespace gyrostat::truth {

template class RigidPlantOf<Effectors>;
static_assert(Plant<RigidPlant>);

}  // namespace gyrostat::truth
