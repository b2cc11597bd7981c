// What is refused before the TOML library sees it.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace noiseloom::settings {

// What a text that is no TOML plainly is by its beginning: "an image (PNG)", "JSON"; empty if that cannot be told.
std::string_view foreign_format(std::string_view beginning);

struct LineFault {
  int line = 0;
  std::string text;
};

// The first line of the text that passes max_key_parts or max_nesting (tree.h), and why. Knows as much of TOML as that
// needs: comments, strings, brackets and the dots of keys.
std::optional<LineFault> nesting_fault(std::string_view text);

}  // namespace noiseloom::settings
