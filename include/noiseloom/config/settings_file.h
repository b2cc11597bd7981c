// Reading, writing and explaining any kind of file that is described by a table of settings (settings.h).
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "noiseloom/config/settings.h"
#include "noiseloom/config/settings_reader.h"

namespace noiseloom::settings {

// What stands in a file of settings, and where.
struct Source {
  std::string text;
  std::string name;    // stands for the path in messages
  std::string folder;  // names of files are relative to it; "" for the working directory
};

// Reads at most max_text_bytes. Throws UserError if there is no such file, if it is a folder, too long, or plainly
// something else (a run file, an image), and says what; EnvironmentError if it cannot be read for another reason.
Source load_source(const std::string& path, std::string_view noun);

// Fills the owners from the text, then from overrides ("optimizer.stop.iterations=200", "filter.groups[0].size=3"; the
// value is TOML, a bare word is taken as a string). Throws UserError with every fault found.
WrittenPaths parse_into(const FileKind& kind, const Owners& owners, const Source& source,
                        const std::vector<std::string>& overrides, MissingFiles missing = MissingFiles::refused);

// Every setting that applies, in the order of the table, with full precision: parsing it gives the same values.
std::string stored_text(const FileKind& kind, const Owners& owners, const WrittenPaths& written_paths);

// The reference of all settings, for --help.
std::string describe(const FileKind& kind);

// The same for a struct.
template <class T>
struct Parsed {
  T value;
  WrittenPaths written_paths;
};

template <class T>
Parsed<T> parse(const FileKind& kind, const Source& source, const std::vector<std::string>& overrides,
                MissingFiles missing = MissingFiles::refused) {
  Parsed<T> result;
  result.written_paths = parse_into(kind, Owners{}.with(result.value), source, overrides, missing);
  return result;
}

template <class T>
std::string to_toml(const FileKind& kind, T value, const WrittenPaths& written_paths) {
  return stored_text(kind, Owners{}.with(value), written_paths);
}

}  // namespace noiseloom::settings
