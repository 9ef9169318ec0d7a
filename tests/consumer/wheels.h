/* SPDX-License-Identifier: MIT */
/* The stack of four_wheels.hpp for flight software in C: memory of the caller, plain structs, SI units. */
#ifndef WHEELS_H
#define WHEELS_H
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef union {
  double alignment;
  unsigned char bytes[8192]; /* checked in wheels.cpp */
} wheels;

typedef struct {
  uint64_t tick;
  float q_NB[4], omega_BN_B[3], h_w[4];
  uint8_t attitude_invalid, rate_invalid, momentum_invalid; /* 0: measured */
} wheels_measurement;

typedef struct {
  float q_NR[4], omega_RN_R[3], omegadot_RN_R[3];
  uint32_t event;
} wheels_reference;

typedef struct {
  float u[4], demand_B[3], achieved_B[3];
  uint16_t saturated, status;
} wheels_command;

typedef struct {
  float q_NB[4], omega_BN_B[3], d_B[3], effectiveness[4], effectiveness_bound[4];
  uint16_t changed, failed, enabled;
  uint32_t events;
} wheels_state;

/* 0: done. Anything else: nothing was done, because of a null pointer or memory without a stack. */
int wheels_init(void* memory);
int wheels_step(void* memory, const wheels_measurement* y, const wheels_reference* ref, wheels_command* command);
int wheels_status(const void* memory, wheels_state* state);

#ifdef __cplusplus
}
#endif
#endif
