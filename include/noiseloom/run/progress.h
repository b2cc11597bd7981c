// What a person (or a program) sees while a run goes on. Rank 0 only.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "noiseloom/core/json.h"

namespace noiseloom {

enum class ProgressKind {
  bar,     // one line that is drawn again and again
  plain,   // a line every few seconds
  json,    // an object a line, each with its "event": start, progress (at least for every row of the history), message,
           // warning, stopped, summary
  none,    // the conclusion and warnings
  quiet,   // warnings
  silent,  // nothing at all: for every rank but 0
};

// "auto": a bar where standard error is a terminal and no launcher stands between (isatty lies under mpirun), else
// plain lines. Throws UserError for another word than auto, plain, json, none.
ProgressKind progress_kind(const std::string& word);

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
  std::vector<JsonMember> json;  // less what follows
  double left_s = -1;            // negative: not known
};

class Progress {
 public:
  // Writes to `descriptor`, standard error where none is given.
  explicit Progress(ProgressKind kind, int descriptor = 2) : kind_(kind), descriptor_(descriptor) {}
  // Shows the figures where it is time to. `num_rows`: of the history, each of which json shows; `part_s`: since this
  // part of the run began.
  // Whether update() with these would show something.
  bool is_due(std::size_t num_rows, double part_s) const;
  bool is_json() const { return kind_ == ProgressKind::json; }
  void update(std::size_t num_rows, double part_s, const std::function<ProgressFigures()>& figures);
  // A line that interrupts the bar.
  void say(const std::string& line);
  // For programs alone.
  void tell(const std::string& event, std::vector<JsonMember> members);
  // How the run ended before its end: said where no progress is shown, too.
  void conclude(const std::string& line);
  // What a user must not miss: said even when quiet.
  void warn(const std::string& line);
  // Closes the bar's line.
  void end();

  // True once a write has found that nobody reads any more (a closed pipe). What cannot be written for another reason,
  // such as a full disk, is lost without harm.
  bool reader_is_gone() const { return reader_is_gone_; }

 private:
  bool shows_progress() const;
  void print_bar(const ProgressFigures& figures);
  void print(const std::string& text);
  void print_line(const std::string& line, const std::string& event = "message");

  ProgressKind kind_;
  int descriptor_;
  double last_shown_s_ = -1;
  std::size_t rows_shown_ = 0;
  bool bar_open_ = false;
  bool reader_is_gone_ = false;
};

}  // namespace noiseloom
