#include "noiseloom/dist/launcher.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <string>

namespace noiseloom {
namespace {

constexpr const char* all_names[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE", "SLURM_STEP_NUM_TASKS"};

int processes_with(const std::map<std::string, std::string>& environment) {
  std::map<std::string, std::string> before;
  for (const char* name : all_names) {
    if (const char* value = std::getenv(name)) before[name] = value;
    ::unsetenv(name);
  }
  for (const auto& [name, value] : environment) ::setenv(name.c_str(), value.c_str(), 1);
  const int number = num_launched_processes();
  for (const char* name : all_names) ::unsetenv(name);
  for (const auto& [name, value] : before) ::setenv(name.c_str(), value.c_str(), 1);
  return number;
}

TEST(Launcher, SaysHowManyProcessesItStarted) {
  EXPECT_EQ(processes_with({}), 0);
  EXPECT_EQ(processes_with({{"OMPI_COMM_WORLD_SIZE", "6"}}), 6);
  EXPECT_EQ(processes_with({{"PMI_SIZE", "4"}}), 4);
  EXPECT_EQ(processes_with({{"SLURM_STEP_NUM_TASKS", "12"}}), 12);
}

TEST(Launcher, TheNearestOneCounts) {
  // One rank under an mpirun whose four daemons Slurm started.
  EXPECT_EQ(processes_with({{"OMPI_COMM_WORLD_SIZE", "1"}, {"SLURM_STEP_NUM_TASKS", "4"}}), 1);
}

TEST(Launcher, WordsThatAreNoNumbersSayNothing) {
  EXPECT_EQ(processes_with({{"PMI_SIZE", "many"}}), 0);
  EXPECT_EQ(processes_with({{"PMI_SIZE", "-3"}}), 0);
  EXPECT_EQ(processes_with({{"PMI_SIZE", ""}}), 0);
}

}  // namespace
}  // namespace noiseloom
