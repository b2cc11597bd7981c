#include "noiseloom_progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

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

std::string rate_text(double per_second) {
  if (per_second >= 1e6) return fmt::format("{:.2f} M candidates/s", per_second / 1e6);
  return fmt::format("{:.1f} k candidates/s", per_second / 1e3);
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

struct Progress::Figures {
  std::int64_t iterations;
  std::int64_t of;     // 0: not known
  double fraction;     // of the round
  double temperature;  // or gamma
  double acceptance;
  double relative_error;
  double rate;
  double left_s;  // negative: not known
  double seconds;
};

Progress::Figures Progress::figures(const Engine& engine, std::int64_t candidates, double seconds, double part_s) {
  const Moment moment = engine.moment();
  const SweepFigures& sweep = engine.last_sweep();
  const bool by_time = optimizer_.stop.time_s > 0;
  double fraction = by_time ? std::min(1.0, seconds / optimizer_.stop.time_s) : 0;
  if (moment.round_length > 0) {
    fraction = static_cast<double>(moment.sweep_in_round) / static_cast<double>(moment.round_length);
  }
  if (first_fraction_ < 0) first_fraction_ = fraction;
  const double done = fraction - first_fraction_;
  const bool known = by_time || (optimizer_.stop.iterations > 0 && done > 0);
  const double left = by_time ? optimizer_.stop.time_s - seconds : part_s / done * (1 - fraction);
  return {engine.iterations(),
          optimizer_.stop.iterations,
          fraction,
          sweep.temperature,
          sweep.acceptance,
          sweep.relative_error,
          part_s > 0 ? static_cast<double>(candidates) / part_s : 0,
          known ? std::max(0.0, left) : -1,
          seconds};
}

void Progress::update(const Engine& engine, std::int64_t candidates, double seconds, double part_s) {
  if (kind_ == ProgressKind::none) return;
  const bool scored = engine.history().size() != history_shown_;
  const double interval = kind_ == ProgressKind::bar ? bar_interval_s : line_interval_s;
  const bool due = last_shown_s_ < 0 || part_s - last_shown_s_ >= interval;
  if (kind_ == ProgressKind::json ? !scored && !due : !due) return;
  last_shown_s_ = part_s;
  history_shown_ = engine.history().size();
  const Figures f = figures(engine, candidates, seconds, part_s);
  if (kind_ == ProgressKind::json) {
    fmt::print(stderr,
               "{{\"iterations\": {}, \"of\": {}, \"temperature\": {:.6g}, \"acceptance\": {:.6g}, \"relative_error\": "
               "{:.8g}, "
               "\"candidates_per_second\": {:.6g}, \"seconds\": {:.3f}, \"seconds_left\": {}}}\n",
               f.iterations, f.of, f.temperature, f.acceptance, f.relative_error, f.rate, f.seconds,
               f.left_s < 0 ? "null" : fmt::format("{:.3f}", f.left_s));
    return;
  }
  if (kind_ == ProgressKind::bar) return print_bar(f);
  const char* heat = optimizer_.method == Method::fast ? "gamma" : "T";
  const std::string of = f.of > 0 ? fmt::format("/{}", f.of) : "";
  const std::string left = f.left_s < 0 ? "" : fmt::format(", {} left (by the pace so far)", duration_text(f.left_s));
  fmt::print(stderr, "iteration {}{}  {} {:.3g}  accepted {:.1f} %  R {:.5f}  {}  {}{}\n", f.iterations, of, heat,
             f.temperature, 100 * f.acceptance, f.relative_error, rate_text(f.rate), duration_text(f.seconds), left);
}

void Progress::print_bar(const Figures& f) {
  constexpr int width = 24;
  const int full = static_cast<int>(f.fraction * width);
  const std::string bar =
      std::string(static_cast<std::size_t>(full), '#') + std::string(static_cast<std::size_t>(width - full), '.');
  const std::string left = f.left_s < 0 ? "" : fmt::format("  {} left", duration_text(f.left_s));
  fmt::print(stderr, "\r\x1b[K[{}] {:3.0f} %  R {:.5f}  accepted {:.1f} %  {}{}", bar, 100 * f.fraction,
             f.relative_error, 100 * f.acceptance, rate_text(f.rate), left);
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
