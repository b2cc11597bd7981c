// The commands of the MPI program. Each takes the arguments after its name and returns the exit status; UserError and
// EnvironmentError are turned into 2 and 1 by main.
#pragma once

#include <string>
#include <vector>

namespace noiseloom {

inline constexpr int exit_done = 0;
inline constexpr int exit_environment = 1;
inline constexpr int exit_user = 2;
inline constexpr int exit_stopped = 75;

int run_generate(int& argc, char**& argv);
int run_bank(int& argc, char**& argv);
int run_plan(int argc, char** argv);
int run_info(int argc, char** argv);

// What stands after "generate" in messages about faults.
void print_faults(const std::string& faults);

}  // namespace noiseloom
