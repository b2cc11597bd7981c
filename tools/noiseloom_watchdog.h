// --watchdog of the commands that run on several ranks.
#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>

#include "noiseloom/core/error.h"
#include "noiseloom/core/text.h"
#include "noiseloom/dist/watchdog.h"

namespace noiseloom {

inline constexpr const char* watchdog_help =
    "end with exit status 76 when a rank is not heard of, or no rank makes a step, for this long (30s, 10m); off; auto "
    "(default): 2 minutes without a word, half an hour or 100 usual steps without a step";

// Steps are looked at as soon as any has been made, and none may then take longer than what the user says.
inline WatchSettings watch_settings_of(const std::string& text) {
  WatchSettings settings;
  if (text == "auto") return settings;
  settings.is_on = text != "off";
  if (!settings.is_on) return settings;
  const std::optional<double> seconds = parse_duration(text);
  if (!seconds || *seconds <= 0) {
    throw UserError("command line", fmt::format("--watchdog {}: accepted: auto, off, or a duration (30s, 10m)", text));
  }
  settings.silence_s = *seconds;
  settings.stuck_s = *seconds;
  return settings;
}

}  // namespace noiseloom
