#include "run/jobs/memory_words.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <fstream>
#include <limits>
#include <string>

#include "noiseloom/core/quantity_text.h"

namespace noiseloom {
namespace {

// Bytes that a line like "VmRSS:   1234 kB" of a file under /proc names; 0 where there is none.
double kilobytes_line(const char* file, const std::string& key) {
  std::ifstream lines(file);
  std::string word;
  while (lines >> word) {
    double value = 0;
    if (word == key && lines >> value) return 1024 * value;
    lines.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return 0;
}

}  // namespace

std::string out_of_memory_text(const std::string& doing) {
  std::string text = fmt::format("out of memory while {}: this process holds {}", doing,
                                 bytes_text(kilobytes_line("/proc/self/status", "VmRSS:")));
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    text += fmt::format(", its address space is limited to {} (ulimit -v) and {} of that is used",
                        bytes_text(static_cast<double>(limit.rlim_cur)),
                        bytes_text(kilobytes_line("/proc/self/status", "VmSize:")));
  } else {
    text += fmt::format(", and the machine has {} left", bytes_text(kilobytes_line("/proc/meminfo", "MemAvailable:")));
  }
  return text + "; noiseloom plan says what a config needs with any number of ranks";
}

std::string no_threads_text(const std::string& doing, const std::string& system_words) {
  return fmt::format("while {}: {}; are there too many threads (--threads), or too little memory?", doing,
                     system_words);
}

}  // namespace noiseloom
