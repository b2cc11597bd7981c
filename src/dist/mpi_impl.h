// MPI behind Communicator, shared by the sources of this layer.
#pragma once

#include <mpi.h>

#include <string>

#include "noiseloom/dist/communicator.h"

namespace noiseloom {

struct Communicator::Impl {
  MPI_Comm comm = MPI_COMM_NULL;
  int rank = 0;
  int size = 1;
};

// Throws EnvironmentError with MPI's own words when `code` is not MPI_SUCCESS.
void check_mpi(int code, const char* what);

}  // namespace noiseloom
