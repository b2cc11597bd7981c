#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>

#include "config/config_tree.h"

namespace noiseloom::settings {
namespace {

// One step of "filter.groups[0].size": a key, or an index into the array before it.
using Step = std::variant<std::string, std::size_t>;

bool is_bare(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-'; }

std::optional<std::vector<Step>> parse_path(std::string_view text) {
  std::vector<Step> steps;
  while (true) {
    const auto key_end = static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_bare) - text.begin());
    if (key_end == 0) return std::nullopt;
    steps.emplace_back(std::string(text.substr(0, key_end)));
    text.remove_prefix(key_end);
    while (text.starts_with('[')) {
      std::size_t index = 0;
      const auto [end, error] = std::from_chars(text.data() + 1, text.data() + text.size(), index);
      if (error != std::errc{} || end == text.data() + text.size() || *end != ']') return std::nullopt;
      steps.emplace_back(index);
      text.remove_prefix(static_cast<std::size_t>(end - text.data()) + 1);
    }
    if (text.empty()) return steps;
    if (!text.starts_with('.')) return std::nullopt;
    text.remove_prefix(1);
  }
}

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

void set_place(Value& value, const Place& place) {
  value.place = place;
  if (Table* table = value.table()) {
    for (Entry& entry : *table) {
      entry.place = place;
      set_place(entry.value, place);
    }
  } else if (Array* array = std::get_if<Array>(&value.data)) {
    for (Value& element : *array) set_place(element, place);
  }
}

// A TOML value, or a word that needs no quotes on a command line ("gauss", "10s", "../taps.npy").
Value parse_value(const std::string& text, const Place& place) {
  Value value;
  try {
    Value root = parse_tree("value = " + text, place.file);
    if (root.table()->size() != 1 || root.table()->front().key != "value") {
      throw UserError(place.file, "more than one value");
    }
    value = std::move(root.table()->front().value);
  } catch (const UserError& error) {
    const bool is_word = !text.empty() && std::all_of(text.begin(), text.end(),
                                                      [](char c) { return is_bare(c) || c == '.' || c == '/'; });
    if (!is_word)
      throw UserError(place.file, error.faults().front().text + " (text with spaces or signs needs quotes)");
    value.data = text;
  }
  set_place(value, place);
  return value;
}

// The value that `step` leads to from `value`, made where there is none; null if `value` cannot have it.
Value* descend(Value& value, const Step& step, const Place& place, std::string& fault) {
  if (const std::string* key = std::get_if<std::string>(&step)) {
    Table* table = value.table();
    if (table == nullptr) {
      fault = to_text(value) + " has no key " + *key;
      return nullptr;
    }
    if (Value* found = find(*table, *key)) return found;
    table->push_back({.key = *key, .place = place, .value = {.data = Table{}, .place = place}});
    return &table->back().value;
  }
  Array* array = std::get_if<Array>(&value.data);
  const std::size_t index = std::get<std::size_t>(step);
  if (array == nullptr) {
    fault = "not a list";
    return nullptr;
  }
  if (index > array->size()) {
    fault = "the list has " + std::to_string(array->size()) + " elements, counted from 0";
    return nullptr;
  }
  if (index == array->size()) array->push_back({.data = Table{}, .place = place});
  return &(*array)[index];
}

}  // namespace

void apply_override(Value& root, const std::string& override_text, std::vector<Fault>& faults) {
  const Place place{.file = "--set " + override_text, .is_override = true};
  const std::size_t equals = override_text.find('=');
  const std::string_view whole = override_text;
  const auto steps = equals == std::string::npos ? std::nullopt : parse_path(trimmed(whole.substr(0, equals)));
  if (!steps) {
    faults.push_back(
        {place.file, "must be KEY=VALUE with a dotted key, such as texture.seed=2 or filter.groups[0].size=3"});
    return;
  }
  try {
    Value value = parse_value(std::string(trimmed(whole.substr(equals + 1))), place);
    Value* target = &root;
    std::string fault;
    for (const Step& step : *steps) {
      target = descend(*target, step, place, fault);
      if (target == nullptr) {
        faults.push_back({place.file, fault});
        return;
      }
    }
    *target = std::move(value);
  } catch (const UserError& error) {
    faults.push_back(error.faults().front());
  }
}

}  // namespace noiseloom::settings
