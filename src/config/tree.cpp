#include "noiseloom/config/tree.h"

#include <fmt/format.h>

// The library asserts that a table header begins with a key before it reports that it does not: "[=]" in a config would
// end a debug build.
#define TOML_ASSERT(expression) static_assert(true)
#define TOML_ENABLE_FORMATTERS 0
#include <toml++/toml.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "config/tree_limits.h"
#include "noiseloom/core/text.h"

namespace noiseloom::settings {
namespace {

Value converted(const toml::node& node, const std::string& name);

Place place_of(const toml::source_region& source, const std::string& name) {
  return {.file = name, .line = static_cast<int>(source.begin.line)};
}

// The library sorts keys; the positions of the keys give back the order of the text.
Table converted_table(const toml::table& table, const std::string& name) {
  std::vector<std::pair<toml::source_position, Entry>> entries;
  for (const auto& [key, node] : table) {
    entries.push_back(
        {key.source().begin,
         {.key = std::string(key.str()), .place = place_of(key.source(), name), .value = converted(node, name)}});
  }
  std::stable_sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  Table result;
  for (auto& [position, entry] : entries) result.push_back(std::move(entry));
  return result;
}

Value converted(const toml::node& node, const std::string& name) {
  Value value{.data = false, .place = place_of(node.source(), name)};
  if (const auto* table = node.as_table()) {
    value.data = converted_table(*table, name);
  } else if (const auto* array = node.as_array()) {
    Array elements;
    for (const toml::node& element : *array) elements.push_back(converted(element, name));
    value.data = std::move(elements);
  } else if (const auto* boolean = node.as_boolean()) {
    value.data = boolean->get();
  } else if (const auto* integer = node.as_integer()) {
    value.data = integer->get();
  } else if (const auto* number = node.as_floating_point()) {
    value.data = number->get();
  } else if (const auto* text = node.as_string()) {
    value.data = text->get();
  } else {
    std::ostringstream date;
    node.visit([&](const auto& date_or_time) {
      if constexpr (toml::is_chronological<decltype(date_or_time)>) date << date_or_time.get();
    });
    value.data = Date{date.str()};
  }
  return value;
}

// `; the line is: seed = 1 2`, where it can be shown.
std::string quoted_line_text(std::string_view text, int line) {
  for (int i = 1; i < line; ++i) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return "";
    text.remove_prefix(end + 1);
  }
  text = text.substr(0, text.find('\n'));
  if (text.ends_with('\r')) text.remove_suffix(1);
  while (text.starts_with(' ') || text.starts_with('\t')) text.remove_prefix(1);
  const bool shows = std::all_of(text.begin(), text.end(),
                                 [](char c) { return static_cast<unsigned char>(c) >= 0x20 ? c != 0x7f : c == '\t'; });
  return text.empty() || !shows || !is_utf8(text) ? "" : "; the line is: " + shortened(text, 100);
}

}  // namespace

Value parse_tree(const std::string& text, const std::string& name, QuotedLine quoted_line) {
  const auto fail = [&](int line, const std::string& why) {
    const Place place{.file = name, .line = line};
    const bool quoted = quoted_line == QuotedLine::yes && why.starts_with("not valid TOML");
    throw UserError(place.to_string(), why + (quoted ? quoted_line_text(text, line) : ""));
  };
  if (text.size() > max_text_bytes) throw UserError(name, fmt::format("longer than {} bytes", max_text_bytes));
  if (foreign_format(text) == "text in UTF-16") fail(1, "not valid TOML: text in UTF-16, must be UTF-8");
  if (const auto fault = early_fault(text)) fail(fault->line, fault->text);
  try {
    Value root = converted(toml::parse(text), name);
    root.place = {.file = name};
    return root;
  } catch (const toml::parse_error& error) {
    fail(static_cast<int>(error.source().begin.line), "not valid TOML: " + shortened(error.description(), 500));
  }
  return {};  // never reached
}

const Value* find(const Table& table, std::string_view key) {
  const auto entry = std::find_if(table.begin(), table.end(), [&](const Entry& e) { return e.key == key; });
  return entry == table.end() ? nullptr : &entry->value;
}

Value* find(Table& table, std::string_view key) {
  return const_cast<Value*>(find(static_cast<const Table&>(table), key));
}

const Value* find_at(const Value& root, std::string_view dotted_key) {
  const Value* value = &root;
  while (value != nullptr && !dotted_key.empty()) {
    const std::size_t dot = dotted_key.find('.');
    const Table* table = value->table();
    value = table == nullptr ? nullptr : find(*table, dotted_key.substr(0, dot));
    dotted_key = dot == std::string_view::npos ? std::string_view{} : dotted_key.substr(dot + 1);
  }
  return value;
}

std::string toml_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      result += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      result += c;
    }
  }
  return result + '"';
}

std::string toml_key(std::string_view key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  return bare ? std::string(key) : toml_string(key);
}

namespace {

template <class List, class ItemText>
std::string listed(const char* open, const List& list, const char* close, ItemText&& item_text) {
  std::string text = open;
  for (const auto& item : list) text += (&item == &list.front() ? "" : ", ") + item_text(item);
  return text + close;
}

struct ToText {
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(std::int64_t value) const { return std::to_string(value); }
  std::string operator()(double value) const { return number_text(value); }
  std::string operator()(const std::string& value) const { return toml_string(value); }
  std::string operator()(const Date& value) const { return value.text; }
  std::string operator()(const Array& array) const { return listed("[", array, "]", to_text); }
  std::string operator()(const Table& table) const {
    if (table.empty()) return "{}";
    return listed("{ ", table, " }",
                  [](const Entry& entry) { return toml_key(entry.key) + " = " + to_text(entry.value); });
  }
};

}  // namespace

std::string to_text(const Value& value) { return std::visit(ToText{}, value.data); }

}  // namespace noiseloom::settings
