#include "config/override.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>

#include "noiseloom/core/text.h"

namespace noiseloom::settings {
namespace {

// One step of "filter.groups[0].size": a key, or an index into the list before it.
using Step = std::variant<std::string, std::size_t>;

bool is_bare(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-'; }

std::optional<std::vector<Step>> parse_path(std::string_view text) {
  std::vector<Step> steps;
  while (steps.size() < max_key_parts) {
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
  return std::nullopt;
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
    Value root = parse_tree("value = " + text, place.file, QuotedLine::no);
    if (root.table()->size() != 1 || root.table()->front().key != "value") {
      throw UserError(place.file, "more than one value");
    }
    value = std::move(root.table()->front().value);
  } catch (const UserError& error) {
    const bool is_word = !text.empty() && std::all_of(text.begin(), text.end(),
                                                      [](char c) { return is_bare(c) || c == '.' || c == '/'; });
    if (!is_word) {
      throw UserError(place.file, error.faults().front().text + " (text with spaces or signs needs quotes)");
    }
    value.data = text;
  }
  set_place(value, place);
  return value;
}

// Walks from the root to the value that an override names, and makes what is missing on the way.
class Descent {
 public:
  Descent(const FileKind& kind, Value& root, const Place& place) : kind_(kind), value_(&root), place_(place) {}

  // False if there is no such value: `fault` says why.
  bool step(const Step& step, bool index_follows) {
    return std::holds_alternative<std::string>(step) ? to_key(std::get<std::string>(step), index_follows)
                                                     : to_element(std::get<std::size_t>(step));
  }
  // True at a key that the kind of file does not have: what lies below it does not matter.
  bool is_unknown() const { return is_unknown_; }
  Value& value() { return *value_; }

  std::string fault;

 private:
  bool to_key(const std::string& written, bool index_follows) {
    spell_out_shorthand();
    Table* table = value_->table();
    if (table == nullptr) {
      fault = shortened(to_text(*value_), 60) + " has no key " + written;
      return false;
    }
    const std::string key(kind_.current_leaf(pattern_, written));
    pattern_ += (pattern_.empty() ? "" : ".") + key;
    is_custom_ = is_custom_ || (kind_.has_row(pattern_) && kind_.row(pattern_).type == Type::custom);
    is_unknown_ = !is_custom_ && !kind_.has_row(pattern_);
    value_ = find(*table, key);
    if (value_ == nullptr) {
      table->push_back({.key = key, .place = place_, .value = {.data = Table{}, .place = place_}});
      value_ = &table->back().value;
      if (index_follows) value_->data = Array{};
    }
    return true;
  }

  void spell_out_shorthand() {
    if (value_->text() == nullptr || !kind_.has_row(pattern_)) return;
    const CustomType* const custom = kind_.row(pattern_).custom;
    if (custom == nullptr || custom->shorthand.empty()) return;
    const Place place = value_->place;
    Entry entry{.key = std::string(custom->shorthand), .place = place, .value = std::move(*value_)};
    *value_ = {.data = Table{std::move(entry)}, .place = place};
  }

  bool to_element(std::size_t index) {
    pattern_ += "[]";
    Array* array = std::get_if<Array>(&value_->data);
    if (array == nullptr) {
      fault = "not a list";
      return false;
    }
    if (index > array->size()) {
      fault = "the list has " + std::to_string(array->size()) + " elements, counted from 0";
      return false;
    }
    if (index == array->size()) array->push_back({.data = Table{}, .place = place_});
    value_ = &(*array)[index];
    return true;
  }

  const FileKind& kind_;
  Value* value_;
  const Place& place_;
  std::string pattern_;     // of the keys walked so far: "filter.groups[].size"
  bool is_custom_ = false;  // below a custom type, which knows its keys itself
  bool is_unknown_ = false;
};

void rename_former_keys(const FileKind& kind, Value& value, const std::string& pattern) {
  Table* table = value.table();
  if (table == nullptr) return;
  for (Entry& entry : *table) {
    const std::string_view leaf = kind.current_leaf(pattern, entry.key);
    if (leaf != entry.key && find(*table, leaf) == nullptr) entry.key = leaf;
    const std::string key = pattern.empty() ? entry.key : pattern + '.' + entry.key;
    if (kind.has_row(key)) rename_former_keys(kind, entry.value, key);
  }
}

}  // namespace

void rename_former_keys(const FileKind& kind, Value& root) { rename_former_keys(kind, root, ""); }

void apply_override(const FileKind& kind, Value& root, const std::string& override_text, std::vector<Fault>& faults) {
  const Place place{.file = "--set " + shortened(override_text, 200), .is_override = true};
  const std::size_t equals = override_text.find('=');
  const std::string_view whole = override_text;
  const auto steps = equals == std::string::npos ? std::nullopt : parse_path(trimmed(whole.substr(0, equals)));
  if (!steps) {
    const std::string example = kind.override_example.empty() ? "" : ", such as " + std::string(kind.override_example);
    faults.push_back({place.file, "must be KEY=VALUE with a dotted key" + example});
    return;
  }
  try {
    Value value = parse_value(std::string(trimmed(whole.substr(equals + 1))), place);
    Descent descent(kind, root, place);
    for (std::size_t i = 0; i < steps->size() && !descent.is_unknown(); ++i) {
      const bool index_follows = i + 1 < steps->size() && std::holds_alternative<std::size_t>((*steps)[i + 1]);
      if (!descent.step((*steps)[i], index_follows)) {
        faults.push_back({place.file, descent.fault});
        return;
      }
    }
    descent.value() = std::move(value);
  } catch (const UserError& error) {
    faults.push_back(error.faults().front());
  }
}

}  // namespace noiseloom::settings
