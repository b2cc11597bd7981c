// What a person (or a program) sees while a run goes on. Rank 0 only.
#pragma once

#include <cstdint>
#include <string>

#include "noiseloom/optimize/engine.h"

namespace noiseloom {

enum class ProgressKind { bar, plain, json, none };

// "auto": a bar where standard error is a terminal and no launcher stands between (isatty lies under mpirun), else
// plain lines. Throws UserError for another word than auto, plain, json, none.
ProgressKind progress_kind(const std::string& word);

std::string json_string(const std::string& text);  // quoted and escaped
std::string duration_text(double seconds);         // "7.2 s", "3 min 5 s", "2 h 14 min"

class Progress {
 public:
  Progress(ProgressKind kind, const OptimizerSpec& optimizer) : kind_(kind), optimizer_(optimizer) {}
  // `candidates`: judged by all ranks in this part of the run; `seconds`: since the run began; `part_s`: since this
  // part did.
  void update(const Engine& engine, std::int64_t candidates, double seconds, double part_s);
  // A line that interrupts the bar.
  void say(const std::string& line);
  // The same, but said whatever the kind: what a user must not miss.
  void warn(const std::string& line);
  void end();

 private:
  struct Figures;
  Figures figures(const Engine& engine, std::int64_t candidates, double seconds, double part_s);
  void print_bar(const Figures& figures);

  ProgressKind kind_;
  const OptimizerSpec& optimizer_;
  double last_shown_s_ = -1;
  double first_fraction_ = -1;
  std::size_t history_shown_ = 0;
  bool bar_open_ = false;
};

}  // namespace noiseloom
