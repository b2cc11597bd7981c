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
#include "noiseloom/image/image_reader.h"

namespace noiseloom {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t most_digits = 15;  // of a number that is counted with

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

struct Numbered {
  std::string prefix;
  std::string suffix;
  std::int64_t number = 0;
};

// The name split at each run of digits before the extension, the last run first.
std::vector<Numbered> split_at_numbers(const std::string& name) {
  std::vector<Numbered> splits;
  std::size_t end = name.size() - fs::path(name).extension().string().size();
  while (true) {
    while (end > 0 && !is_digit(name[end - 1])) --end;
    if (end == 0) return splits;
    std::size_t begin = end;
    while (begin > 0 && is_digit(name[begin - 1])) --begin;
    if (end - begin <= most_digits) {
      std::int64_t number = 0;
      std::from_chars(name.data() + begin, name.data() + end, number);
      splits.push_back({name.substr(0, begin), name.substr(end), number});
    }
    end = begin;
  }
}

// The number between `prefix` and `suffix`, where the name is just that.
std::optional<std::int64_t> number_between(const std::string& name, const std::string& prefix,
                                           const std::string& suffix) {
  if (name.size() <= prefix.size() + suffix.size() || !name.starts_with(prefix) || !name.ends_with(suffix))
    return std::nullopt;
  const char* const begin = name.data() + prefix.size();
  const char* const end = name.data() + name.size() - suffix.size();
  std::int64_t number = 0;
  if (!std::all_of(begin, end, is_digit)) return std::nullopt;
  const auto [stop, error] = std::from_chars(begin, end, number);
  if (stop != end || error != std::errc{}) return std::nullopt;
  return number;
}

// Files by their number; a number may be there twice, written with and without zeros.
using Members = std::map<std::int64_t, std::vector<std::string>>;

// "number 17 is missing" or "numbers 17 to 19 are missing"
std::string missing_text(std::int64_t first, std::int64_t last) {
  return first == last ? fmt::format("number {} is missing", first)
                       : fmt::format("numbers {} to {} are missing", first, last);
}

std::vector<std::string> without_gaps(const std::string& where, const Members& members) {
  std::vector<std::string> files;
  std::int64_t expected = members.begin()->first;
  for (const auto& [number, names] : members) {
    if (number != expected)
      throw UserError(
          where, fmt::format("the sequence has a gap: {} ({} to {} were found)", missing_text(expected, number - 1),
                             members.begin()->first, members.rbegin()->first));
    if (names.size() > 1)
      throw UserError(where, fmt::format("number {} is there twice: {} and {}", number, names[0], names[1]));
    files.push_back(names.front());
    ++expected;
  }
  return files;
}

// In the order of their names, so that messages do not depend on the file system.
std::vector<fs::path> files_in(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(folder, error); !error && entry != fs::directory_iterator(); entry.increment(error))
    files.push_back(entry->path());
  if (error) throw EnvironmentError(fmt::format("{}: cannot be listed: {}", folder.string(), error.message()));
  std::sort(files.begin(), files.end());
  return files;
}

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

// "31 x .jpg (lossy: it changes noise), 2 x .dds (...)"
std::string unread_text(const std::map<std::string, int>& unread) {
  std::string text;
  for (const auto& [extension, count] : unread)
    text += fmt::format("{}{} x {} ({})", text.empty() ? "" : ", ", count, extension, why_not_read(extension));
  return text;
}

// The one sequence, or the single file, among the images of these.
std::vector<std::string> only_sequence(const std::string& where, const std::vector<fs::path>& files) {
  std::map<std::tuple<std::string, std::string>, Members> sequences;
  std::vector<std::string> single;
  std::map<std::string, int> unread;
  for (const fs::path& path : files) {
    const std::string name = path.filename().string();
    if (name.starts_with(".")) continue;
    if (!has_image_extension(name)) {
      const std::string extension = lower_case_extension(name);
      if (!why_not_read(extension).empty()) ++unread[extension];
      continue;
    }
    const std::vector<Numbered> splits = split_at_numbers(name);
    if (splits.empty())
      single.push_back(path.string());
    else
      sequences[{splits.front().prefix, splits.front().suffix}][splits.front().number].push_back(path.string());
  }
  if (sequences.empty() && single.size() == 1) return single;
  if (sequences.size() == 1 && single.empty()) return without_gaps(where, sequences.begin()->second);
  if (sequences.empty() && single.empty())
    throw UserError(where, fmt::format("no images that are read here{}; accepted: {}",
                                       unread.empty() ? "" : ", but " + unread_text(unread), image_extensions()));
  std::string found;
  for (const auto& [key, members] : sequences)
    found += fmt::format("{}{}{{}}{}", found.empty() ? "" : ", ", std::get<0>(key), std::get<1>(key));
  for (const std::string& path : single)
    found += fmt::format("{}{}", found.empty() ? "" : ", ", fs::path(path).filename().string());
  throw UserError(where, fmt::format("more than one set of images: {}; give one of them", found));
}

std::vector<std::string> from_star(const std::string& pattern, const std::string& name) {
  const std::size_t star = name.find('*');
  const std::string prefix = name.substr(0, star);
  const std::string suffix = name.substr(star + 1);
  std::vector<fs::path> files = files_in(folder_of(pattern));
  std::erase_if(files, [&](const fs::path& path) {
    const std::string found = path.filename().string();
    return found.size() < prefix.size() + suffix.size() || !found.starts_with(prefix) || !found.ends_with(suffix);
  });
  if (files.empty()) throw UserError(pattern, "no file has a name like this");
  return only_sequence(pattern, files);
}

std::vector<std::string> from_pattern(const std::string& pattern) {
  const fs::path path(pattern);
  const fs::path folder = folder_of(path);
  const std::string name = path.filename().string();
  const std::optional<NumberPlace> place = number_place(name);
  if (!fs::is_directory(folder)) throw UserError(folder.string(), "no such folder");
  if (!place) return from_star(pattern, name);
  const std::string prefix = name.substr(0, place->begin);
  const std::string suffix = name.substr(place->begin + place->size);
  Members members;
  for (const fs::path& file : files_in(folder))
    if (const auto number = number_between(file.filename().string(), prefix, suffix))
      members[*number].push_back((folder / file.filename()).string());
  if (members.empty()) throw UserError(pattern, "no file has a name like this");
  return without_gaps(pattern, members);
}

}  // namespace

std::optional<NumberPlace> number_place(const std::string& pattern) {
  static const std::regex place(R"(\{(?:slice)?(?::0?(\d{1,2}))?\}|%(?:0(\d))?[diu]|#+)");
  const std::size_t name = pattern.rfind('/') == std::string::npos ? 0 : pattern.rfind('/') + 1;
  const auto begin = pattern.begin() + static_cast<std::ptrdiff_t>(name);
  std::smatch match;
  const bool has_star = std::find(begin, pattern.end(), '*') != pattern.end();
  if (!std::regex_search(begin, pattern.end(), match, place)) {
    if (std::count(begin, pattern.end(), '*') > 1)
      throw UserError(pattern, "more than one *; accepted: one, or one place for the number");
    return std::nullopt;
  }
  std::smatch second;
  if (has_star || std::regex_search(match[0].second, pattern.end(), second, place))
    throw UserError(pattern, "more than one place for the number; accepted: one of {}, {slice:03}, %d, %03d, %i, ####");
  const std::string found = match.str();
  const std::string width = match[1].matched ? match[1].str() : match[2].str();
  return NumberPlace{static_cast<std::size_t>(match[0].first - pattern.begin()), found.size(),
                     found.front() == '#' ? static_cast<int>(std::min<std::size_t>(found.size(), 99))
                     : width.empty()      ? 1
                                          : std::max(1, std::stoi(width))};
}

bool is_sequence_pattern(const std::string& path) {
  return number_place(path).has_value() || fs::path(path).filename().string().find('*') != std::string::npos;
}

std::string fill_pattern(const std::string& pattern, std::int64_t number) {
  const std::optional<NumberPlace> place = number_place(pattern);
  if (!place) {
    if (is_sequence_pattern(pattern))
      throw UserError(pattern,
                      "* does not say how the number is written; accepted: {}, {slice:03}, %d, %03d, %i, ####");
    return pattern;
  }
  return pattern.substr(0, place->begin) + fmt::format("{:0{}}", number, place->width) +
         pattern.substr(place->begin + place->size);
}

std::vector<std::string> find_sequence(const std::string& pattern_or_folder) {
  if (!fs::is_directory(pattern_or_folder)) return from_pattern(pattern_or_folder);
  return only_sequence(pattern_or_folder, files_in(pattern_or_folder));
}

std::vector<Sequence> sequences_from_first(const std::string& path) {
  const fs::path first(path);
  const std::vector<fs::path> all = files_in(folder_of(first));
  std::vector<Sequence> sequences;
  for (const Numbered& split : split_at_numbers(first.filename().string())) {
    Members members;
    for (const fs::path& file : all) {
      const auto number = number_between(file.filename().string(), split.prefix, split.suffix);
      if (number && *number > split.number)
        members[*number].push_back((first.parent_path() / file.filename()).string());
    }
    if (members.empty()) continue;
    Sequence sequence{(first.parent_path() / (split.prefix + "{}" + split.suffix)).string(), {path}, ""};
    std::int64_t next = split.number + 1;
    for (; members.contains(next); ++next) sequence.files.push_back(members[next].front());
    if (const auto after = members.upper_bound(next); after != members.end())
      sequence.gap = fmt::format("{}, but {} to {} {} there", missing_text(next, after->first - 1), after->first,
                                 members.rbegin()->first, after->first == members.rbegin()->first ? "is" : "are");
    sequences.push_back(std::move(sequence));
  }
  if (sequences.empty()) sequences.push_back({"", {path}, ""});
  return sequences;
}

bool is_one_sequence(const std::vector<std::string>& files) {
  if (files.size() < 2) return false;
  for (const Sequence& sequence : sequences_from_first(files.front()))
    if (sequence.files.size() >= files.size() && std::equal(files.begin(), files.end(), sequence.files.begin()))
      return true;
  return false;
}

}  // namespace noiseloom
