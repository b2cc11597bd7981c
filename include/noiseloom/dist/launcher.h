// What the environment tells of the program that started this process (mpirun, srun), without MPI.
#pragma once

namespace noiseloom {

// True where a launcher that speaks one of the process interfaces (PMI, PMIx) started this process.
bool has_launcher();

// How many processes the launcher says that it started as one job; 0 where there is none or it does not say. More than
// the ranks that MPI sees means that the launcher and the MPI library do not understand each other: every process then
// takes itself for the only one.
int num_launched_processes();

}  // namespace noiseloom
