// Prints benchmarks as they come, and at the end a table of the pairs PROBLEM/float and PROBLEM/double: items per
// second of both (the best repetition), and their ratio.
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
    }
  }

  void Finalize() override {
    std::printf("\n%-28s %16s %16s %8s\n", "candidates/s", "fast (float)", "plain (double)", "ratio");
    for (const auto& [problem, rates] : problems_) {
      if (rates.fast == 0 || rates.plain == 0) continue;
      std::printf("%-28s %14.3f M %14.3f M %7.1fx\n", problem.c_str(), rates.fast / 1e6, rates.plain / 1e6,
                  rates.fast / rates.plain);
    }
  }

 private:
  struct Rates {
    double fast = 0;
    double plain = 0;
  };
  std::map<std::string, Rates> problems_;
};

}  // namespace noiseloom
