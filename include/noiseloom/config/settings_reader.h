// From a tree to the struct that a kind of file fills, with every fault on the way. What custom types and checks of a
// kind of file (settings.h) are handed.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "noiseloom/config/file_names.h"
#include "noiseloom/config/settings.h"
#include "noiseloom/config/tree.h"

namespace noiseloom::settings {

class Reader {
 public:
  // Names of files are relative to `folder` ("" for the working directory). `kind` must outlive the reader.
  Reader(const FileKind& kind, std::string folder, MissingFiles missing)
      : kind_(kind), folder_(std::move(folder)), missing_(missing) {}

  // Fills the owners with what could be read: usable only if there are no faults. `root` must outlive the calls below.
  void read(const Value& root, const Owners& owners);
  // Of the last read, in the order of the lines of the file, those of overrides last; at most 100, and a last one that
  // counts the others.
  std::vector<Fault> faults() const;
  const WrittenPaths& written_paths() const { return written_paths_; }

  // For custom types and checks.
  const FileKind& kind() const { return kind_; }
  const Value& root() const { return *root_; }
  // `shown` is the key that the user wrote; the message is `shown = value: text`.
  void fault(const Value& value, const std::string& shown, const std::string& text);
  void fault(const Place& place, const std::string& text);
  // Reads a value that is a table with the rows below `pattern` ("filter.groups[]").
  void read_table(const Value& value, std::string_view pattern, const std::string& shown, const Owners& owners);
  // False if that setting, of type word, is itself in fault, so that nothing follows from it.
  bool decided(std::string_view key) const;

 private:
  void look_up_deciders(const Owners& owners);
  void read_key(const std::vector<const Setting*>& rows, const Value& parent, const std::string& shown,
                const Owners& owners);
  void report_unsuitable(const std::vector<const Setting*>& rows, const Value& value, const std::string& shown,
                         const Owners& owners);
  void report_unknown_keys(const Table& table, std::string_view pattern, const std::string& shown,
                           const Owners& owners);
  std::string elsewhere(const std::string& key, std::string_view pattern, bool is_override) const;
  std::string did_you_mean(const Entry& entry, std::string_view pattern, const std::vector<std::string>& usable) const;

  void read_value(const Found& found);
  void read_whole_table(const Found& found);
  bool keep_one_rule(const Found& found, Value& rules);
  void read_tables(const Found& found);
  void read_list(const Found& found);
  void read_scalar(const Found& found, const Field& field);
  void read_number(const Found& found, double number, const Field& field);
  void read_word(const Found& found, const Field& field);
  void read_text(const Found& found, const Field& field);
  void read_file(const Found& found, const Field& field);

  const FileKind& kind_;
  std::string folder_;
  MissingFiles missing_;
  const Value* root_ = nullptr;
  WrittenPaths written_paths_;
  std::vector<std::string_view> undecided_;  // keys of type word that are in fault
  std::vector<std::pair<Place, Fault>> faults_;
  std::size_t num_left_out_ = 0;  // faults past those that are kept
};

}  // namespace noiseloom::settings
