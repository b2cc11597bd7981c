// TOML as a tree that remembers the order in which keys were written and the line of each value. The rest of the config
// layer works on it; only config_tree.cpp sees the TOML library.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "noiseloom/core/error.h"

namespace noiseloom::settings {

// Where something was written: a line of the config, or a --set of the command line.
struct Place {
  std::string file;  // "run.toml" or "--set texture.seed=2"
  int line = 0;      // 0: nowhere in particular
  bool is_override = false;

  std::string to_string() const { return line > 0 && !is_override ? file + ':' + std::to_string(line) : file; }
};

struct Value;
struct Entry;
using Array = std::vector<Value>;
using Table = std::vector<Entry>;  // in the order written

// A date or time: TOML has them, no setting does.
struct Date {
  std::string text;
};

struct Value {
  std::variant<bool, std::int64_t, double, std::string, Date, Array, Table> data;
  Place place;

  const Table* table() const { return std::get_if<Table>(&data); }
  Table* table() { return std::get_if<Table>(&data); }
  const Array* array() const { return std::get_if<Array>(&data); }
};

struct Entry {
  std::string key;
  Place place;  // of the key
  Value value;
};

// Null if there is no such key.
const Value* find(const Table& table, std::string_view key);
Value* find(Table& table, std::string_view key);

// Throws UserError if the text is not TOML. `name` is what stands before the line number in messages.
Value parse_tree(const std::string& text, const std::string& name);

// Applies "texture.seed=2" or "filter.groups[0].size=3". An index one past the end appends. What is wrong with the
// override itself is added to `faults`; what is wrong with the value is found when the tree is read.
void apply_override(Value& root, const std::string& override_text, std::vector<Fault>& faults);

// TOML on one line.
std::string to_text(const Value& value);
std::string toml_string(std::string_view text);
// Shortest text that reads back as the same number, with a point or an exponent.
std::string number_text(double value);

}  // namespace noiseloom::settings
