// What is refused before the TOML library sees it.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace noiseloom::settings {

// What a text that is no TOML plainly is by its beginning: "an image (PNG)", "JSON"; empty if that cannot be told.
std::string_view foreign_format(std::string_view beginning);

bool is_utf8(std::string_view text);

struct LineFault {
  int line = 0;
  std::string text;
};

// The first line of the text that is not UTF-8, that passes max_key_parts or max_nesting (tree.h), or that holds a
// character beyond ASCII where TOML has none and the library has undefined behaviour (its test for blanks takes some of
// them for impossible); and why. Knows as much of TOML as that needs: comments, strings, brackets, the dots of keys.
std::optional<LineFault> early_fault(std::string_view text);

}  // namespace noiseloom::settings
