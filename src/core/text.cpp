#include "noiseloom/core/text.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <iterator>
#include <system_error>

#include "noiseloom/core/error.h"

namespace noiseloom {

std::string number_text(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::optional<double> parse_duration(std::string_view text) {
  struct Unit {
    char letter;
    double seconds;
  };
  constexpr Unit units[] = {{'d', 86400}, {'h', 3600}, {'m', 60}, {'s', 1}};
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  double total = 0;
  std::size_t next_unit = 0;
  for (bool first = true; first || !text.empty(); first = false) {
    if (text.empty() || !is_digit(text.front())) return std::nullopt;
    double number = 0;
    const char* const last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), last, number, std::chars_format::fixed);
    if (error != std::errc{} || !std::isfinite(number)) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (text.empty()) return first ? std::optional(number) : std::nullopt;
    while (next_unit < std::size(units) && units[next_unit].letter != text.front()) ++next_unit;
    if (next_unit == std::size(units)) return std::nullopt;  // unknown, repeated, or a larger unit after a smaller one
    total += number * units[next_unit++].seconds;
    text.remove_prefix(1);
  }
  return total;
}

std::string shortened(std::string_view text, std::size_t max_bytes) {
  NOISELOOM_CHECK_LT(4U, max_bytes);
  if (text.size() <= max_bytes) return std::string(text);
  std::size_t end = max_bytes - 4;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return std::string(text.substr(0, end)) + " ...";
}

}  // namespace noiseloom
