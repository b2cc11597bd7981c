// TOML as a tree that remembers the order in which keys were written and the line of each value. The rest of the config
// layer works on it; only src/config/tree.cpp sees the TOML library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "noiseloom/core/error.h"

namespace noiseloom::settings {

// Where something was written: a line of the file, or a --set of the command line.
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
  const std::string* text() const { return std::get_if<std::string>(&data); }
};

struct Entry {
  std::string key;
  Place place;  // of the key
  Value value;
};

// Null if there is no such key.
const Value* find(const Table& table, std::string_view key);
Value* find(Table& table, std::string_view key);
// The value that a dotted key leads to from `root`, through tables alone; null if there is none.
const Value* find_at(const Value& root, std::string_view dotted_key);

// Bounds of what is handed to the TOML library, which works by recursion: a key has at most 32 parts, tables and lists
// lie at most 32 deep, a text has at most 4 MiB. No file of settings comes near any of them.
inline constexpr std::size_t max_key_parts = 32;
inline constexpr std::size_t max_nesting = 32;
inline constexpr std::size_t max_text_bytes = std::size_t{4} << 20;

// Throws UserError if the text is not TOML or passes the bounds. `name` is what stands before the line number in
// messages. With quoted_line::yes the message ends with the line that is wrong.
enum class QuotedLine { no, yes };
Value parse_tree(const std::string& text, const std::string& name, QuotedLine quoted_line = QuotedLine::yes);

// TOML on one line.
std::string to_text(const Value& value);
std::string toml_string(std::string_view text);
// The key as it is written in TOML: in quotes where it must be.
std::string toml_key(std::string_view key);

}  // namespace noiseloom::settings
