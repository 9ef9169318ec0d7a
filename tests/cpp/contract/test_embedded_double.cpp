// SPDX-License-Identifier: MIT
#define GYROSTAT_TEST_SCALAR double
#include "embedded.hpp"
