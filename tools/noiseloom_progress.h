// What a person (or a program) sees while a run goes on. Rank 0 only.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace noiseloom {

enum class ProgressKind { bar, plain, json, none };

// "auto": a bar where standard error is a terminal and no launcher stands between (isatty lies under mpirun), else
// plain lines. Throws UserError for another word than auto, plain, json, none.
ProgressKind progress_kind(const std::string& word);

std::string json_string(const std::string& text);  // quoted and escaped
std::string duration_text(double seconds);         // "7.2 s", "3 min 5 s", "2 h 14 min"
std::string bytes_text(double bytes);              // "3.5 MiB"
// "1.20 M picks/s", "3.4 k picks/s"
std::string rate_text(double per_second, const char* what);

// Seconds left by the pace of this part of a run.
class Pace {
 public:
  // `fraction`: of the whole that is done. Negative: not known yet.
  double left_s(double fraction, double part_s);

 private:
  double first_fraction_ = -1;
};

struct ProgressFigures {
  double fraction = 0;  // of the bar
  std::string bar;      // what stands behind it
  std::string plain;
  std::string json;    // members of an object
  double left_s = -1;  // negative: not known
};

class Progress {
 public:
  explicit Progress(ProgressKind kind) : kind_(kind) {}
  // Shows the figures where it is time to. `num_rows`: of the history, each of which json shows; `part_s`: since this
  // part of the run began.
  void update(std::size_t num_rows, double part_s, const std::function<ProgressFigures()>& figures);
  // A line that interrupts the bar.
  void say(const std::string& line);
  // The same, but said whatever the kind: what a user must not miss.
  void warn(const std::string& line);
  void end();

 private:
  void print_bar(const ProgressFigures& figures);

  ProgressKind kind_;
  double last_shown_s_ = -1;
  std::size_t rows_shown_ = 0;
  bool bar_open_ = false;
};

}  // namespace noiseloom
