// SPDX-License-Identifier: MIT
/// @file  CVODE, and all that differs between SUNDIALS 6.4 and 7.x. Private to the truth layer.
#pragma once
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sundials/sundials_context.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#if SUNDIALS_VERSION_MAJOR < 6 || (SUNDIALS_VERSION_MAJOR == 6 && SUNDIALS_VERSION_MINOR < 4)
#error "gyrostat needs SUNDIALS 6.4 or later"
#endif

// Open MPI's null communicator is an address; weak, it is null in a program without MPI, here as in the archive.
#ifdef OPEN_MPI
#pragma weak ompi_mpi_comm_null
#endif

namespace gyrostat::truth {

/// A context without a communicator; null when there is none to be had.
inline SUNContext make_context() {
  SUNContext context = nullptr;
#if SUNDIALS_VERSION_MAJOR >= 7
  if (SUNContext_Create(SUN_COMM_NULL, &context) != SUN_SUCCESS) return nullptr;
  SUNContext_ClearErrHandlers(context);
#else
  if (SUNContext_Create(nullptr, &context) != 0) return nullptr;
#endif
  return context;
}

/// Errors come back as flags, nothing is printed.
inline void silence([[maybe_unused]] void* cvode) {
#if SUNDIALS_VERSION_MAJOR < 7
  CVodeSetErrHandlerFn(cvode, [](int, const char*, const char*, char*, void*) {}, nullptr);
#endif
}

}  // namespace gyrostat::truth
