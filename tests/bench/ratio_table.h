// Prints benchmarks as they come, and at the end a table of the pairs PROBLEM/float and PROBLEM/double: items per
// second of both (the best repetition), their ratio, and where they were counted the share of two limits of the
// machine.
#pragma once

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

namespace noiseloom {

class RatioTable : public benchmark::ConsoleReporter {
 public:
  RatioTable() : ConsoleReporter(isatty(STDOUT_FILENO) != 0 ? OO_Defaults : OO_None) {}

  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      const auto rate = run.counters.find("items_per_second");
      if (run.run_type != Run::RT_Iteration || rate == run.counters.end()) continue;
      const std::string name = run.run_name.function_name;
      const std::size_t slash = name.rfind('/');
      Rates& rates = problems_[name.substr(0, slash)];
      double& best = name.substr(slash + 1) == "float" ? rates.fast : rates.plain;
      best = std::max(best, rate->second.value);
      read(run, "arithmetic_limit", rates.arithmetic_limit);
      read(run, "cache_limit", rates.cache_limit);
    }
  }

  void Finalize() override {
    std::printf("\n%-28s %16s %16s %8s %18s %14s\n", "candidates/s", "fast (float)", "plain (double)", "ratio",
                "of the arithmetic", "of the cache");
    for (const auto& [problem, rates] : problems_) {
      if (rates.fast == 0) continue;
      std::printf("%-28s %14.3f M", problem.c_str(), rates.fast / 1e6);
      if (rates.plain > 0) std::printf(" %14.3f M %7.1fx", rates.plain / 1e6, rates.fast / rates.plain);
      if (rates.arithmetic_limit > 0) {
        std::printf(" %16.0f %% %12.0f %%", 100 * rates.fast / rates.arithmetic_limit,
                    100 * rates.fast / rates.cache_limit);
      }
      std::printf("\n");
    }
  }

 private:
  struct Rates {
    double fast = 0;
    double plain = 0;
    double arithmetic_limit = 0;  // 0: not counted
    double cache_limit = 0;
  };
  static void read(const Run& run, const char* counter, double& value) {
    const auto found = run.counters.find(counter);
    if (found != run.counters.end()) value = found->second.value;
  }
  std::map<std::string, Rates> problems_;
};

}  // namespace noiseloom
