/* SPDX-License-Identifier: MIT */
/* Flight software in C: two stacks at odd addresses, copies without a stack, a not-a-number, and the law of the stack itself. */
#include "wheels.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;

static void expect(int holds, const char* what) {
  if (!holds) {
    printf("not so: %s\n", what);
    ++failures;
  }
}

/* tau = -1.5 q_vec - 8 omega (quaternion_law.hpp) is what the four commands add up to about each axis. */
static int is_the_law(const wheels_measurement* y, const wheels_command* c) {
  static const float D[3][4] = {{1, 1, -1, -1}, {1, -1, -1, 1}, {1, 1, 1, 1}};
  int i, j;
  for (i = 0; i < 3; ++i) {
    const float law = -1.5f * y->q_NB[i + 1] - 8.0f * y->omega_BN_B[i];
    float torque = 0.0f;
    for (j = 0; j < 4; ++j) torque += D[i][j] * c->u[j] / sqrtf(3.0f);
    /* 1e-6: a few roundings of float at 0.1 N m */
    if (fabsf(torque - law) > 1e-6f || fabsf(c->demand_B[i] - c->achieved_B[i]) > 1e-6f) return 0;
  }
  return 1;
}

int main(void) {
  static unsigned char blocks[2][sizeof(wheels) + 64], copy[sizeof(wheels) + 64];
  static wheels_measurement y = {0, {0.999f, 0.03f, -0.02f, 0.01f}, {0.002f, -0.001f, 0.003f}, {0, 0, 0, 0}, 0, 0, 0};
  static wheels_reference ref = {{1, 0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0};
  wheels_command first, second;
  wheels_state state;
  int offset, i;
  expect(wheels_init(NULL) != 0, "null memory is refused");
  for (offset = 0; offset < 17; ++offset) { /* any alignment */
    unsigned char *one = blocks[0] + offset, *two = blocks[1] + 3 * offset % 17;
    memset(blocks, 0xA5, sizeof blocks);
    expect(wheels_step(one, &y, &ref, &first) != 0, "memory that was not initialised is refused");
    expect(wheels_init(one) == 0 && wheels_init(two) == 0, "init");
    expect(wheels_status(one, &state) == 0 && state.effectiveness[3] == 1.0f, "status before the first step");
    expect(wheels_step(one, NULL, &ref, &first) != 0, "a null measurement is refused");
    expect(wheels_step(one, &y, &ref, &first) == 0 && is_the_law(&y, &first), "the command is that of the law");
    expect(wheels_step(two, &y, &ref, &second) == 0 && memcmp(first.u, second.u, sizeof first.u) == 0, "two stacks");
    memcpy(copy, one, sizeof(wheels));
    expect(wheels_step(copy, &y, &ref, &second) != 0, "a copy is no stack");
  }
  expect(first.status == 0, "nothing to report");
  y.q_NB[1] = NAN;
  y.tick = 1;
  expect(wheels_step(blocks[0] + 16, &y, &ref, &second) == 0 && (second.status & 1) != 0, "a NaN is held and flagged");
  for (i = 0; i < 4; ++i)
    expect(fabsf(second.u[i] - first.u[i]) < 0.1f * 0.2f, "and the stack flies on: the command moves little");
  y.q_NB[1] = 0.11f; /* near enough to be flown, but nobody measured it */
  y.attitude_invalid = 1;
  y.tick = 2;
  expect(wheels_step(blocks[0] + 16, &y, &ref, &second) == 0 && second.status == 1, "an invalid attitude is flagged");
  for (i = 0; i < 4; ++i) expect(fabsf(second.u[i] - first.u[i]) < 0.1f * 0.2f, "and not flown");
  y.q_NB[1] = 0.03f;
  y.attitude_invalid = 0;
  y.tick = 3;
  expect(wheels_step(blocks[0] + 16, &y, &ref, &second) == 0 && second.status == 0, "measured again");
  expect(wheels_status(blocks[0] + 16, &state) == 0 && state.enabled == 15, "four actuators may be used");
  printf("C facade: %d failures\n", failures);
  return failures == 0 ? 0 : 1;
}
