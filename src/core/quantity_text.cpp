#include "noiseloom/core/quantity_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace noiseloom {

std::string duration_text(double seconds) {
  if (seconds < 60) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

std::string bytes_text(double bytes) {
  for (const char* unit : {"B", "KiB", "MiB", "GiB"}) {
    if (bytes < 1024) return fmt::format("{:.4g} {}", bytes, unit);
    bytes /= 1024;
  }
  return fmt::format("{:.4g} TiB", bytes);
}

std::string digits_text(double value) {
  if (value == 0 || !std::isfinite(value)) return fmt::format("{}", value);
  const int magnitude = static_cast<int>(std::floor(std::log10(std::abs(value))));
  if (magnitude < -9) return fmt::format("{:.2e}", value);
  return fmt::format("{:.{}f}", value, std::max(2 - magnitude, 0));
}

std::string rate_text(double per_second, const char* what) {
  if (per_second >= 1e6) return fmt::format("{:.2f} M {}/s", per_second / 1e6, what);
  return fmt::format("{:.1f} k {}/s", per_second / 1e3, what);
}

}  // namespace noiseloom
