#include "noiseloom/run/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <limits>
#include <utility>

#include "noiseloom/core/console.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/json.h"
#include "noiseloom/core/quantity_text.h"

namespace noiseloom {
namespace {

constexpr double bar_interval_s = 0.2;
constexpr double line_interval_s = 5;

bool under_launcher() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK", "SLURM_STEP_ID"}) {
    if (std::getenv(name) != nullptr) return true;
  }
  return false;
}

}  // namespace

ProgressKind progress_kind(const std::string& word) {
  if (word == "auto") return isatty(STDERR_FILENO) != 0 && !under_launcher() ? ProgressKind::bar : ProgressKind::plain;
  if (word == "plain") return ProgressKind::plain;
  if (word == "json") return ProgressKind::json;
  if (word == "none") return ProgressKind::none;
  throw UserError("command line", fmt::format("--progress {}: unknown word; accepted: auto, plain, json, none", word));
}

double Pace::left_s(double fraction, double part_s) {
  if (first_fraction_ < 0) first_fraction_ = fraction;
  const double done = fraction - first_fraction_;
  return done > 0 ? std::max(0.0, part_s / done * (1 - fraction)) : -1;
}

bool Progress::shows_progress() const {
  return kind_ == ProgressKind::bar || kind_ == ProgressKind::plain || kind_ == ProgressKind::json;
}

void Progress::print(const std::string& text) {
  if (reader_is_gone_) return;
  reader_is_gone_ = write_text(descriptor_, text) == EPIPE;
}

bool Progress::is_due(std::size_t num_rows, double part_s) const {
  if (!shows_progress()) return false;
  const double interval = kind_ == ProgressKind::bar ? bar_interval_s : line_interval_s;
  const bool due = last_shown_s_ < 0 || part_s - last_shown_s_ >= interval;
  return due || (kind_ == ProgressKind::json && num_rows != rows_shown_);
}

void Progress::tell(const std::string& event, std::vector<JsonMember> members) {
  if (kind_ != ProgressKind::json) return;
  members.insert(members.begin(), {"event", event});
  print(json_object(members) + "\n");
}

void Progress::update(std::size_t num_rows, double part_s, const std::function<ProgressFigures()>& figures) {
  if (!is_due(num_rows, part_s)) return;
  last_shown_s_ = part_s;
  rows_shown_ = num_rows;
  ProgressFigures f = figures();
  if (kind_ == ProgressKind::json) {
    f.json.emplace_back("seconds_left", f.left_s < 0 ? std::numeric_limits<double>::quiet_NaN() : f.left_s);
    tell("progress", std::move(f.json));
  } else if (kind_ == ProgressKind::bar) {
    print_bar(f);
  } else {
    const std::string left = f.left_s < 0 ? "" : fmt::format(", {} left (by the pace so far)", duration_text(f.left_s));
    print(fmt::format("{}{}\n", f.plain, left));
  }
}

void Progress::print_bar(const ProgressFigures& f) {
  constexpr int width = 24;
  const int full = std::clamp(static_cast<int>(f.fraction * width), 0, width);
  const std::string bar =
      std::string(static_cast<std::size_t>(full), '#') + std::string(static_cast<std::size_t>(width - full), '.');
  const std::string left = f.left_s < 0 ? "" : fmt::format("  {} left", duration_text(f.left_s));
  print(fmt::format("\r\x1b[K[{}] {:3.0f} %  {}{}", bar, 100 * f.fraction, f.bar, left));
  bar_open_ = true;
}

void Progress::print_line(const std::string& line, const std::string& event) {
  end();
  if (is_json()) return tell(event, {{"message", line}});
  print(line + "\n");
}

void Progress::say(const std::string& line) {
  if (shows_progress()) print_line(line);
}

void Progress::conclude(const std::string& line) {
  if (shows_progress() || kind_ == ProgressKind::none) print_line(line, "stopped");
}

void Progress::warn(const std::string& line) {
  if (kind_ != ProgressKind::silent) print_line("WARNING: " + line, "warning");
}

void Progress::end() {
  if (bar_open_) print("\n");
  bar_open_ = false;
}

}  // namespace noiseloom
