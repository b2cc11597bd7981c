#include "config/config_tree.h"

#include <fmt/format.h>

// The library asserts that a table header begins with a key before it reports that it does not: "[=]" in a config would
// end a debug build.
#define TOML_ASSERT(expression) static_assert(true)
#define TOML_ENABLE_FORMATTERS 0
#include <toml++/toml.h>

#include <algorithm>
#include <sstream>

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

}  // namespace

Value parse_tree(const std::string& text, const std::string& name) {
  try {
    Value root = converted(toml::parse(text), name);
    root.place = {.file = name};
    return root;
  } catch (const toml::parse_error& error) {
    const Place place = place_of(error.source(), name);
    throw UserError(place.to_string(), "not valid TOML: " + std::string(error.description()));
  }
}

const Value* find(const Table& table, std::string_view key) {
  const auto entry = std::find_if(table.begin(), table.end(), [&](const Entry& e) { return e.key == key; });
  return entry == table.end() ? nullptr : &entry->value;
}

Value* find(Table& table, std::string_view key) {
  return const_cast<Value*>(find(static_cast<const Table&>(table), key));
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

std::string number_text(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

namespace {

std::string key_text(const std::string& key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  return bare ? key : toml_string(key);
}

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
                  [](const Entry& entry) { return key_text(entry.key) + " = " + to_text(entry.value); });
  }
};

}  // namespace

std::string to_text(const Value& value) { return std::visit(ToText{}, value.data); }

}  // namespace noiseloom::settings
