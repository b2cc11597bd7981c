#include "noiseloom/dist/launcher.h"

#include <charconv>
#include <cstdlib>
#include <string_view>

namespace noiseloom {
namespace {

int number_of(const char* name) {
  const char* text = std::getenv(name);
  if (text == nullptr) return 0;
  const std::string_view digits = text;
  int number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc() && end == digits.data() + digits.size() && number > 0 ? number : 0;
}

}  // namespace

bool has_launcher() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "PMI_SIZE"}) {
    if (std::getenv(name) != nullptr) return true;
  }
  return false;
}

int num_launched_processes() {
  // The nearest launcher first. Slurm's variables come last, as an mpirun inside a Slurm job hands them on, where they
  // count its own daemons.
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE", "SLURM_STEP_NUM_TASKS"}) {
    if (const int number = number_of(name); number > 0) return number;
  }
  return 0;
}

}  // namespace noiseloom
