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
  // Finds out how the config's method is changed: where it has keys of its own, the table [optimizer] is replaced.
  PointCommands(const AccuracyOptions& options, const RunConfig& config);
  // Throws UserError where the config with a point's changes is none that generate takes.
  void check(const AccuracyLadder& ladder) const;
  PointCommand command(const AccuracyPoint& point) const;
  int threads() const { return threads_; }

 private:
  std::vector<std::string> overrides(const AccuracyPoint& point) const;
  bool accepts(const std::vector<std::string>& more) const;

  const AccuracyOptions& options_;
  const RunConfig& config_;
  int threads_;
  bool replaces_table_ = false;
};

// The word as a POSIX shell takes it, in quotes where needed.
std::string shell_word(const std::string& word);

}  // namespace noiseloom
