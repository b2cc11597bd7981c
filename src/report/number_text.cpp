#include "noiseloom/report/number_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace noiseloom {

std::string number_text(double value, int digits) {
  constexpr int most_decimals = 12;
  if (std::isnan(value)) return "none";
  if (!std::isfinite(value)) return value > 0 ? "infinite" : "-infinite";
  if (value == 0) return "0";
  const int leading = static_cast<int>(std::floor(std::log10(std::abs(value))));
  const int decimals = std::clamp(digits - 1 - leading, 0, most_decimals);
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (decimals == 0) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string error_text(double relative_error) { return fmt::format("{:.4f}", relative_error); }

}  // namespace noiseloom
