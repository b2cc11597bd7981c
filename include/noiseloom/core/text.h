// Numbers and durations as text that is read back, the same under every locale. (As people read them:
// core/quantity_text.h.)
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace noiseloom {

// Shortest text that reads back as the same number, with a point or an exponent: "1.0", "0.1", "1e-300", "inf", "nan".
std::string number_text(double value);

// Seconds in "10s", "5m", "2h", "1h30m", "1.5h", "1d" or a plain number of seconds; nothing if `text` is no duration.
std::optional<double> parse_duration(std::string_view text);

// The text if it has at most `max_bytes`, else its beginning and " ...", cut between characters of UTF-8. Requires
// max_bytes > 4.
std::string shortened(std::string_view text, std::size_t max_bytes);

}  // namespace noiseloom
