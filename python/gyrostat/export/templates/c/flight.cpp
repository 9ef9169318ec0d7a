// SPDX-License-Identifier: MIT
// Written by gyrostat @version@ from the scenario '@title@': the C functions of @name@.h over the stack of @name@.hpp.
#include "@name@.h"

#include "@name@.hpp"
#include "gyrostat/flight/facade.hpp"

namespace {

using S = @name @_real;
using Flight = @name @_flight::Flight<S>;
using Memory = gyrostat::CallerMemory<Flight::Stack>;
static_assert(sizeof(@name @) >= Memory::bytes, "compile everything with a larger @NAME@_BYTES");
static_assert(Flight::Stack::cannot_throw);
static_assert(@NAME @_BREACH == static_cast<int>(gyrostat::Flag::breach));

}  // namespace

extern "C" int @name @_init(@name @* self) {
  const Flight::Parameters parameters = Flight::parameters();
  if (!Flight::check(parameters).ok()) return @NAME @_REFUSED;
  return Memory::make(self, Flight::make(parameters)) != nullptr ? @NAME @_OK : @NAME @_NOT_READY;
}

extern "C" int @name @_step(@name @* self, const @name @_measurement* measurement, const @name @_reference* reference,
                            @name @_command* command) {
  Flight::Stack* stack = Memory::get(self);
  if (stack == nullptr || measurement == nullptr || reference == nullptr || command == nullptr)
    return @NAME @_NOT_READY;
  gyrostat::to_plain(stack->step(gyrostat::measurement_from<S>(*measurement), gyrostat::reference_from<S>(*reference)),
                     *command);
  return @NAME @_OK;
}

extern "C" int @name @_status(const @name @* self, @name @_state* state) {
  const Flight::Stack* stack = Memory::get(self);
  if (stack == nullptr || state == nullptr) return @NAME @_NOT_READY;
  gyrostat::to_plain(stack->estimate(), stack->detection(), *state);
  return @NAME @_OK;
}
