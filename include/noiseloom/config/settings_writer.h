// From values back to text. What custom types of a kind of file (settings.h) are handed.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "noiseloom/config/settings.h"
#include "noiseloom/config/settings_reader.h"

namespace noiseloom::settings {

class Writer {
 public:
  // Both must outlive the writer.
  Writer(const FileKind& kind, const WrittenPaths& written_paths) : kind_(kind), written_paths_(written_paths) {}

  // The whole file: keys of the top level, then one section for each table.
  std::string text(const Owners& owners) const;

  // For custom types: `{ file = "mine.npy", distance = "euclidean" }` of the rows below `pattern`, save the one that
  // ends in `without`; empty if there is nothing to say.
  std::string inline_table(std::string_view pattern, const Owners& owners, std::string_view without = {}) const;
  // One value as TOML; empty if there is nothing to say.
  std::string value_text(const Setting& setting, const Owners& owners) const;

 private:
  std::string section(const Setting& table, const Owners& owners) const;
  std::string lines(std::string_view pattern, const Owners& owners) const;
  std::string word_text(const Setting& setting, const Owners& owners) const;
  std::string tables_text(const Setting& setting, const Owners& owners) const;
  std::string scalar_text(const Setting& setting, const Field& field) const;
  std::string string_text(const Setting& setting, const std::string& text) const;

  const FileKind& kind_;
  const WrittenPaths& written_paths_;
};

}  // namespace noiseloom::settings
