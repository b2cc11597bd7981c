#include "image/containers/source_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>

namespace noiseloom {
namespace {

template <class Number>
Number number_at_index(std::span<const std::byte> bytes, std::size_t index) {
  Number number{};
  std::memcpy(&number, bytes.data() + index * sizeof number, sizeof number);
  return number;
}

}  // namespace

std::string identifier_of(const std::string& target) {
  std::string name = std::filesystem::path(target).stem().string();
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 || static_cast<unsigned char>(c) > 127) c = '_';
  // Shader languages keep two underscores in a row, and one in front, for themselves.
  const auto both = [](char a, char b) { return a == '_' && b == '_'; };
  name.erase(std::unique(name.begin(), name.end(), both), name.end());
  if (name.empty() || name[0] == '_' || std::isdigit(static_cast<unsigned char>(name[0])) != 0)
    name = "noise" + std::string(name.starts_with('_') ? "" : "_") + name;
  // No texture is likely to be called as any other of the languages' words is.
  constexpr std::string_view words[] = {"auto",   "bool",   "buffer",   "char",    "class",  "const",   "default",
                                        "double", "export", "float",    "half",    "image",  "int",     "layout",
                                        "long",   "matrix", "new",      "private", "public", "sample",  "sampler",
                                        "shared", "short",  "signed",   "static",  "struct", "texture", "this",
                                        "uint",   "union",  "unsigned", "vector",  "void",   "volatile"};
  return std::find(std::begin(words), std::end(words), name) == std::end(words) ? name : "noise_" + name;
}

std::string comment_lines(const std::string& text) {
  std::string lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines += "// " + text.substr(at, end - at) + "\n";
    at = end + 1;
  }
  return lines;
}

std::string stored_number_text(std::span<const std::byte> bytes, PixelType type, std::size_t index) {
  switch (type) {
    case PixelType::uint8:
      return fmt::format("{}", std::to_integer<unsigned>(bytes[index]));
    case PixelType::uint16:
    case PixelType::float16:
      return fmt::format("{}", number_at_index<std::uint16_t>(bytes, index));
    case PixelType::uint32:
      return fmt::format("{}u", number_at_index<std::uint32_t>(bytes, index));
    case PixelType::float32: {
      std::string text = fmt::format("{}", number_at_index<float>(bytes, index));
      if (text.find_first_of(".e") == std::string::npos) text += ".0";
      return text + "f";
    }
  }
  return "";
}

std::string filled(std::string text, std::vector<std::pair<std::string, std::string>> values) {
  std::sort(values.begin(), values.end(), [](const auto& a, const auto& b) { return a.first.size() > b.first.size(); });
  for (const auto& [name, value] : values)
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + value.size()))
      text.replace(at, name.size(), value);
  return text;
}

}  // namespace noiseloom
