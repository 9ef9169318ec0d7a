/* SPDX-License-Identifier: MIT */
/* Written by gyrostat @version@ from the scenario '@title@':
   @stack@.
   C99. SI units and radians; quaternions scalar first; N inertial, B body, R reference frame. Call step once every
   @NAME@_PERIOD seconds. No heap, no static state: everything is in memory that you own. */
#ifndef @NAME@_H
#define @NAME@_H
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define @NAME@_ACTUATORS @actuators@
#define @NAME@_PERIOD @dt@ /* s */

typedef @scalar@ @name@_real;

/* Size of the memory, checked where the library is compiled. Compile everything with a larger number where that says so
   (wide vector units pad more). */
#ifndef @NAME@_BYTES
#define @NAME@_BYTES @bytes@
#endif

/* The stack. Yours to place (static, in a task's block, ...), of any alignment; a copy or a moved one has to be initialised
   again. What is inside is nobody's business. */
typedef struct {
  union {
    double alignment;
    unsigned char bytes[@NAME@_BYTES];
  } memory;
} @name@;

typedef struct {
  uint64_t tick;                        /* number of this sample, from 0 */
  @name@_real q_NB[4];                  /* attitude, sign continuous from sample to sample */
  @name@_real omega_BN_B[3];            /* rad/s */
  @name@_real h_w[@NAME@_ACTUATORS]; /* N m s, axial momentum of each wheel in inertial space; 0 for ideal torquers */
} @name@_measurement;

typedef struct {
  @name@_real q_NR[4];          /* attitude to follow */
  @name@_real omega_RN_R[3];    /* rad/s */
  @name@_real omegadot_RN_R[3]; /* rad/s^2 */
  uint32_t event;                      /* counts the jumps of the reference */
} @name@_reference;

typedef struct {
  @name@_real u[@NAME@_ACTUATORS]; /* N m, to be held until the next sample */
  @name@_real demand_B[3];         /* N m, torque that the controller asked for */
  @name@_real achieved_B[3];       /* N m, torque on the body that flight expects of u */
  uint16_t saturated;                     /* bit i: actuator i is at a limit */
  uint16_t status;                        /* @NAME@_INPUT_HELD, ...; 0: nothing to report */
} @name@_command;

typedef struct {
  @name@_real q_NB[4];                             /* estimated attitude */
  @name@_real omega_BN_B[3];                       /* rad/s */
  @name@_real d_B[3];                              /* N m, estimated torque that effectiveness does not explain */
  @name@_real effectiveness[@NAME@_ACTUATORS];       /* delivered / commanded */
  @name@_real effectiveness_bound[@NAME@_ACTUATORS]; /* relative half-width; infinity: never excited */
  uint16_t changed, failed, enabled;                      /* bit masks of actuators */
  uint32_t events;                                        /* declarations of the detector */
} @name@_state;

/* Bits of status. */
enum {
  @NAME@_INPUT_HELD = 1,       /* a non-finite input was replaced by the last valid one */
  @NAME@_COMPONENT_RESET = 2,  /* a non-finite output: its component was started again */
  @NAME@_COMMAND_HELD = 4,     /* the previous command was issued again */
  @NAME@_DEMAND_NOT_MET = 8,   /* the demanded torque could not be delivered */
  @NAME@_CAP_REACHED = 16,     /* an iteration limit ended a solve: best so far was used */
  @NAME@_BAD_INPUT = 32,       /* the allocator refused its input */
  @NAME@_RANK_LOST = 64,       /* an axis of torque cannot be produced and was dropped */
  @NAME@_SINGULAR = 128,       /* near a singularity of the chart in use */
  @NAME@_BREACH = 256          /* a promised bound was left */
};

/* What the functions return. */
enum {
  @NAME@_OK = 0,
  @NAME@_REFUSED = 1,     /* init: the components do not accept the parameters */
  @NAME@_NOT_READY = 2,   /* a null pointer, or memory that init has not seen */
};

/* Makes the stack; the first step starts its components. Again: as new. */
int @name@_init(@name@* self);

/* One sample. @NAME@_NOT_READY leaves command as it was. */
int @name@_step(@name@* self, const @name@_measurement* measurement, const @name@_reference* reference,
           @name@_command* command);

/* What the stack makes of the vehicle since the last step. */
int @name@_status(const @name@* self, @name@_state* state);

#ifdef __cplusplus
}
#endif
#endif
