#include "noiseloom_progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "noiseloom/core/error.h"

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

std::string duration_text(double seconds) {
  if (seconds < 60) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

std::string json_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<int>(c));
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::string bytes_text(double bytes) {
  for (const char* unit : {"B", "KiB", "MiB", "GiB"}) {
    if (bytes < 1024) return fmt::format("{:.4g} {}", bytes, unit);
    bytes /= 1024;
  }
  return fmt::format("{:.4g} TiB", bytes);
}

std::string rate_text(double per_second, const char* what) {
  if (per_second >= 1e6) return fmt::format("{:.2f} M {}/s", per_second / 1e6, what);
  return fmt::format("{:.1f} k {}/s", per_second / 1e3, what);
}

double Pace::left_s(double fraction, double part_s) {
  if (first_fraction_ < 0) first_fraction_ = fraction;
  const double done = fraction - first_fraction_;
  return done > 0 ? std::max(0.0, part_s / done * (1 - fraction)) : -1;
}

void Progress::update(std::size_t num_rows, double part_s, const std::function<ProgressFigures()>& figures) {
  if (kind_ == ProgressKind::none) return;
  const double interval = kind_ == ProgressKind::bar ? bar_interval_s : line_interval_s;
  const bool due = last_shown_s_ < 0 || part_s - last_shown_s_ >= interval;
  if (kind_ == ProgressKind::json ? num_rows == rows_shown_ && !due : !due) return;
  last_shown_s_ = part_s;
  rows_shown_ = num_rows;
  const ProgressFigures f = figures();
  if (kind_ == ProgressKind::json) {
    fmt::print(stderr, "{{{}, \"seconds_left\": {}}}\n", f.json,
               f.left_s < 0 ? "null" : fmt::format("{:.3f}", f.left_s));
  } else if (kind_ == ProgressKind::bar) {
    print_bar(f);
  } else {
    const std::string left = f.left_s < 0 ? "" : fmt::format(", {} left (by the pace so far)", duration_text(f.left_s));
    fmt::print(stderr, "{}{}\n", f.plain, left);
  }
}

void Progress::print_bar(const ProgressFigures& f) {
  constexpr int width = 24;
  const int full = static_cast<int>(f.fraction * width);
  const std::string bar =
      std::string(static_cast<std::size_t>(full), '#') + std::string(static_cast<std::size_t>(width - full), '.');
  const std::string left = f.left_s < 0 ? "" : fmt::format("  {} left", duration_text(f.left_s));
  fmt::print(stderr, "\r\x1b[K[{}] {:3.0f} %  {}{}", bar, 100 * f.fraction, f.bar, left);
  std::fflush(stderr);
  bar_open_ = true;
}

void Progress::say(const std::string& line) {
  if (kind_ == ProgressKind::none) return;
  end();
  if (kind_ == ProgressKind::json) {
    fmt::print(stderr, "{{\"message\": {}}}\n", json_string(line));
  } else {
    fmt::print(stderr, "{}\n", line);
  }
}

void Progress::warn(const std::string& line) {
  if (kind_ == ProgressKind::json) return say("WARNING: " + line);
  end();
  fmt::print(stderr, "WARNING: {}\n", line);
}

void Progress::end() {
  if (bar_open_) fmt::print(stderr, "\n");
  bar_open_ = false;
}

}  // namespace noiseloom
