// The command line of a point: what is started, and what a user types to run it again.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/accuracy/accuracy_ladder.h"
#include "noiseloom/accuracy/accuracy_run.h"

namespace noiseloom {

struct PointCommand {
  std::vector<std::string> words;
  std::string shown;   // for a shell
  std::string output;  // the run file
};

class PointCommands {
 public:
  PointCommands(const AccuracyOptions& options, const RunConfig& config);
  // Takes methods off the ladder that the config cannot have, whatever is written under [optimizer]. Throws UserError
  // where the config with another point's changes is none that generate takes.
  void check(AccuracyLadder& ladder) const;
  // The `run`-th run of the point, from 0 on: with the config's seed plus that.
  PointCommand command(const AccuracyPoint& point, int run = 0) const;
  int threads() const { return threads_; }

 private:
  std::vector<std::string> overrides(const AccuracyPoint& point) const;
  std::vector<Fault> faults_with(const std::vector<std::string>& more) const;

  const AccuracyOptions& options_;
  const RunConfig& config_;
  int threads_;
};

// The word as a POSIX shell takes it, in quotes where needed.
std::string shell_word(const std::string& word);

}  // namespace noiseloom
