#include "render/noises/sampler_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>

#include "noiseloom/core/error.h"

namespace noiseloom::render {
namespace {

constexpr std::uintmax_t most_bytes_of_tables = std::uintmax_t{1} << 26;

// In lower case and without _, so that ranking_tile is rankingTile; comments become blanks.
std::string plain_text(const std::string& path) {
  std::error_code absent;
  const std::uintmax_t size = std::filesystem::file_size(path, absent);
  if (absent || size > most_bytes_of_tables)
    throw UserError(path, fmt::format("is no source text of tables, which has at most {} bytes", most_bytes_of_tables));
  std::ifstream file(path, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  if (!file.read(text.data(), std::ssize(text))) throw EnvironmentError(path + ": cannot be read");
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text.compare(i, 2, "//") == 0) {
      i = std::min(text.find('\n', i), text.size() - 1);
      plain += ' ';
    } else if (text.compare(i, 2, "/*") == 0) {
      i = std::min(text.find("*/", i + 2), text.size() - 2) + 1;
      plain += ' ';
    } else if (text[i] != '_') {
      plain += text[i] >= 'A' && text[i] <= 'Z' ? static_cast<char>(text[i] + ('a' - 'A')) : text[i];
    }
  }
  return plain;
}

constexpr std::string_view blanks = " \t\r\n";

// Where the numbers of an array begin: behind its name, sizes in brackets, and "= {". Empty where it has none.
std::optional<std::size_t> first_number(std::string_view text, std::string_view name) {
  for (std::size_t at = text.find(name); at != std::string_view::npos; at = text.find(name, at + 1)) {
    std::size_t i = at + name.size();
    const auto skip = [&] { i = std::min(text.find_first_not_of(blanks, i), text.size()); };
    for (skip(); i < text.size() && text[i] == '['; skip()) i = std::min(text.find(']', i), text.size() - 1) + 1;
    if (i < text.size() && text[i] == '=') ++i;
    skip();
    if (i < text.size() && text[i] == '{') return i + 1;
  }
  return std::nullopt;
}

std::vector<std::uint8_t> array_of(std::string_view text, const std::string& path, const char* name,
                                   std::string_view plain_name, std::size_t size, bool may_be_absent) {
  const std::optional<std::size_t> first = first_number(text, plain_name);
  if (!first) {
    if (may_be_absent) return std::vector<std::uint8_t>(size);
    throw UserError(path, fmt::format("has no array {} = {{ ... }}", name));
  }
  std::vector<std::uint8_t> values;
  for (std::size_t i = *first;; ++i) {
    i = std::min(text.find_first_not_of(blanks, i), text.size());
    if (i < text.size() && text[i] == '}') break;
    unsigned value = 0;
    const auto [end, error] = std::from_chars(text.data() + i, text.data() + text.size(), value);
    if (error != std::errc() || value > 255) {
      std::string_view word = text.substr(i, 20);
      word = word.substr(0, word.find_first_of(",}\n"));
      throw UserError(path, fmt::format("{}: number {} (counted from 0) is \"{}\": accepted are integers from 0 to 255",
                                        name, values.size(), word));
    }
    values.push_back(static_cast<std::uint8_t>(value));
    i = std::min(text.find_first_not_of(blanks, static_cast<std::size_t>(end - text.data())), text.size());
    if (i < text.size() && text[i] == '}') break;
    if (i == text.size() || text[i] != ',')
      throw UserError(path, fmt::format("{}: after {} numbers neither , nor }} follows", name, values.size()));
  }
  if (values.size() != size)
    throw UserError(path, fmt::format("{} has {} numbers, must have {}", name, values.size(), size));
  return values;
}

}  // namespace

SamplerTables load_sampler_tables(const std::string& path) {
  using T = SamplerTables;
  const std::string text = plain_text(path);
  constexpr std::size_t keys = T::side * T::side * T::num_keys;
  return {array_of(text, path, "sobol_256spp_256d", "sobol256spp256d", T::num_points * T::num_dimensions, false),
          array_of(text, path, "scramblingTile", "scramblingtile", keys, false),
          array_of(text, path, "rankingTile", "rankingtile", keys, true)};
}

}  // namespace noiseloom::render
