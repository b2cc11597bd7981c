// The command `accuracy`: runs `noiseloom generate` for one point of the ladder after another, with several seeds each,
// scores what it made and keeps DIR up to date after each.
//
// Each run is a process of its own, and has to be: the seconds that are compared are those of a whole program as a
// user starts it, a run that needs more memory than there is must not take the others with it, and MPI can be started
// only once in a process.
//
//   DIR/accuracy.csv   every point that has run (accuracy_table.h)
//   DIR/report.html    the page (accuracy_report.h)
//   DIR/config.toml    the effective config, and a digest of the files it names: what --resume compares
//   DIR/runs/          the run file of a point while it is needed, or all of them (`keep`)
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "noiseloom/core/error.h"
#include "noiseloom/report/report.h"

namespace noiseloom {

struct AccuracyOptions {
  std::string config;
  std::vector<std::string> overrides;
  std::string folder;
  std::string program = "noiseloom";  // to start; commands that are shown say `noiseloom`
  double budget_s = 300;
  int seeds = 3;    // runs of each point: with the config's seed and those after it
  int threads = 0;  // 0: as many as there are processors
  bool resume = false;
  bool overwrite = false;
  bool keep = false;
  ReportOrigin origin = {};                                                      // what the page says of itself
  std::function<void(const std::string& line)> say = [](const std::string&) {};  // progress, a line a point
  bool quiet = false;                                                            // no result, and no word of a stop
  bool json = false;                                                             // the result as an object
};

enum class AccuracyEnd { complete, stopped };

// To be called in the main thread. `faults`: what is already known to be wrong with the command line. Throws UserError
// with these and all that is wrong with the config or in the folder, before anything is started; EnvironmentError when
// a run or the disk fails (what has run before is saved).
AccuracyEnd run_accuracy(const AccuracyOptions& options, std::vector<Fault> faults);

}  // namespace noiseloom
