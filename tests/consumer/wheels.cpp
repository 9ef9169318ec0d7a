// SPDX-License-Identifier: MIT
/// @file  A C facade by hand, over gyrostat/flight/facade.hpp.
#include "wheels.h"

#include "four_wheels.hpp"
#include "gyrostat/flight/facade.hpp"

using Stack = consumer::FourWheels<float>;
using Memory = gyrostat::CallerMemory<Stack>;
static_assert(sizeof(wheels) >= Memory::bytes);

extern "C" int wheels_init(void* memory) {
  const gyrostat::Checked<Stack> stack = consumer::make_four_wheels<float>();
  return stack && Memory::make(memory, *stack) != nullptr ? 0 : 1;
}

extern "C" int wheels_step(void* memory, const wheels_measurement* y, const wheels_reference* ref,
                           wheels_command* command) {
  Stack* stack = Memory::get(memory);
  if (stack == nullptr || y == nullptr || ref == nullptr || command == nullptr) return 1;
  gyrostat::to_plain(stack->step(gyrostat::measurement_from<float>(*y), gyrostat::reference_from<float>(*ref)),
                     *command);
  return 0;
}

extern "C" int wheels_status(const void* memory, wheels_state* state) {
  const Stack* stack = Memory::get(memory);
  if (stack == nullptr || state == nullptr) return 1;
  gyrostat::to_plain(stack->estimate(), stack->detection(), *state);
  return 0;
}
