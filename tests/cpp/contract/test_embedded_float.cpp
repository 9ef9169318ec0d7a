// SPDX-License-Identifier: MIT
#define GYROSTAT_TEST_SCALAR float
#include "embedded.hpp"
