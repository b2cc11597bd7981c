// What the writers of source code (headers, shaders) share: names, numbers as text, templates.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/image/container.h"

namespace noiseloom {

// A name in C and shader languages from the file's: letters, digits and _, no digit in front.
std::string identifier_of(const std::string& target);

// Lines of a comment: `text` may have several lines.
std::string comment_lines(const std::string& text);

// The number at `index` of those that a slice is made of, in C and in HLSL alike: "17", "0.25f".
std::string stored_number_text(std::span<const std::byte> bytes, PixelType type, std::size_t index);

// `text` with each name (such as "$W") replaced by its value, longer names first.
std::string filled(std::string text, std::vector<std::pair<std::string, std::string>> values);

}  // namespace noiseloom
