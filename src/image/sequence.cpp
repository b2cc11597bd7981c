#include "noiseloom/image/sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <map>
#include <regex>
#include <tuple>

#include "noiseloom/core/error.h"
#include "noiseloom/image/image_io.h"

namespace noiseloom {
namespace fs = std::filesystem;
namespace {

// The place of the number in a pattern and the zero padding that was asked for.
struct Slot {
  std::size_t begin;
  std::size_t size;
  int width;
};

std::optional<Slot> find_slot(const std::string& pattern) {
  static const std::regex slot(R"(\{(?:slice)?(?::0?(\d{1,2}))?\}|%(?:0(\d))?d)");
  std::smatch match;
  if (!std::regex_search(pattern, match, slot)) return std::nullopt;
  const std::string width = match[1].matched ? match[1].str() : match[2].str();
  return Slot{static_cast<std::size_t>(match.position(0)), static_cast<std::size_t>(match.length(0)),
              width.empty() ? 0 : std::stoi(width)};
}

struct Numbered {
  std::string prefix;
  std::string suffix;
  std::int64_t number;
};

// Splits a file name at its last run of digits before the extension.
std::optional<Numbered> split_number(const std::string& name) {
  const std::string extension = fs::path(name).extension().string();
  const std::string stem = name.substr(0, name.size() - extension.size());
  std::size_t end = stem.size();
  std::size_t begin = end;
  while (begin > 0 && std::isdigit(static_cast<unsigned char>(stem[begin - 1]))) --begin;
  if (begin == end || end - begin > 15) return std::nullopt;
  std::int64_t number = 0;
  std::from_chars(stem.data() + begin, stem.data() + end, number);
  return Numbered{stem.substr(0, begin), extension, number};
}

// Numbered files of one folder that share prefix and suffix.
using Members = std::map<std::int64_t, std::vector<std::string>>;

std::vector<std::string> without_gaps(const std::string& where, const Members& members) {
  std::vector<std::string> files;
  std::int64_t expected = members.begin()->first;
  for (const auto& [number, names] : members) {
    if (number != expected)
      throw UserError(where, fmt::format("the sequence has a gap: number {} is missing ({} to {} were found)", expected,
                                         members.begin()->first, members.rbegin()->first));
    if (names.size() > 1)
      throw UserError(where, fmt::format("number {} is there twice: {} and {}", number, names[0], names[1]));
    files.push_back(names.front());
    ++expected;
  }
  return files;
}

std::vector<std::string> from_pattern(const std::string& pattern) {
  const fs::path path(pattern);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const std::string name = path.filename().string();
  const std::optional<Slot> slot = find_slot(name);
  if (!slot) throw UserError(pattern, "the place of the number must be in the file name, not in a folder's");
  const std::string prefix = name.substr(0, slot->begin);
  const std::string suffix = name.substr(slot->begin + slot->size);
  if (!fs::is_directory(folder)) throw UserError(folder.string(), "no such folder");
  Members members;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string found = entry.path().filename().string();
    if (found.size() <= prefix.size() + suffix.size() || !found.starts_with(prefix) || !found.ends_with(suffix))
      continue;
    const char* const begin = found.data() + prefix.size();
    const char* const end = found.data() + found.size() - suffix.size();
    std::int64_t number = 0;
    if (!std::isdigit(static_cast<unsigned char>(*begin))) continue;
    const auto [stop, error] = std::from_chars(begin, end, number);
    if (stop == end && error == std::errc{}) members[number].push_back((folder / found).string());
  }
  if (members.empty()) throw UserError(pattern, "no file has a name like this");
  return without_gaps(pattern, members);
}

std::vector<std::string> from_folder(const std::string& folder) {
  std::map<std::tuple<std::string, std::string>, Members> sequences;
  std::vector<std::string> single;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(".") || !has_image_extension(name)) continue;
    const auto numbered = split_number(name);
    if (numbered)
      sequences[{numbered->prefix, numbered->suffix}][numbered->number].push_back(entry.path().string());
    else
      single.push_back(entry.path().string());
  }
  if (sequences.empty() && single.size() == 1) return single;
  if (sequences.size() == 1 && single.empty()) return without_gaps(folder, sequences.begin()->second);
  if (sequences.empty() && single.empty()) throw UserError(folder, "no images in this folder");
  std::string found;
  for (const auto& [key, members] : sequences)
    found += fmt::format("{}{}{{}}{}", found.empty() ? "" : ", ", std::get<0>(key), std::get<1>(key));
  std::sort(single.begin(), single.end());
  for (const std::string& path : single)
    found += fmt::format("{}{}", found.empty() ? "" : ", ", fs::path(path).filename().string());
  throw UserError(folder, fmt::format("more than one set of images: {}; give one of them", found));
}

}  // namespace

bool is_sequence_pattern(const std::string& path) { return find_slot(path).has_value(); }

std::vector<std::string> find_sequence(const std::string& pattern_or_folder) {
  return fs::is_directory(pattern_or_folder) ? from_folder(pattern_or_folder) : from_pattern(pattern_or_folder);
}

std::vector<std::string> sequence_from_first(const std::string& path) {
  const fs::path first(path);
  const auto numbered = split_number(first.filename().string());
  if (!numbered) return {path};
  const fs::path folder = first.has_parent_path() ? first.parent_path() : fs::path(".");
  Members members;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const auto other = split_number(entry.path().filename().string());
    if (other && other->prefix == numbered->prefix && other->suffix == numbered->suffix &&
        other->number > numbered->number)
      members[other->number].push_back(entry.path().string());
  }
  members[numbered->number] = {path};
  std::vector<std::string> files;
  for (std::int64_t number = numbered->number; members.contains(number); ++number)
    files.push_back(members[number].front());
  return files;
}

std::string fill_pattern(const std::string& pattern, std::int64_t number) {
  const std::optional<Slot> slot = find_slot(pattern);
  if (!slot) return pattern;
  return pattern.substr(0, slot->begin) + fmt::format("{:0{}}", number, std::max(slot->width, 1)) +
         pattern.substr(slot->begin + slot->size);
}

}  // namespace noiseloom
