// The values that a row can describe by itself: numbers, words, text, names of files, lists and tables of them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <system_error>
#include <type_traits>
#include <utility>

#include "noiseloom/config/settings_reader.h"
#include "noiseloom/core/text.h"

namespace noiseloom::settings {
namespace {

// The number of an integer or real value, the seconds of a duration; nothing if the row accepts no such value.
std::optional<double> number_of(const Setting& setting, const Value& value) {
  const auto* integer = std::get_if<std::int64_t>(&value.data);
  const auto* number = std::get_if<double>(&value.data);
  if (integer != nullptr) return static_cast<double>(*integer);
  if (setting.type == Type::integer) return std::nullopt;
  if (number != nullptr) return *number;
  if (setting.type == Type::duration && value.text() != nullptr) return parse_duration(*value.text());
  return std::nullopt;
}

// Numbers below a table that say nothing: the rule of another key is set in their place.
void unset(const Setting& setting, const Owners& owners) {
  if (!setting.zero_is_unset) return;
  std::visit(
      [](auto field) {
        using T = std::remove_pointer_t<decltype(field)>;
        if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) *field = T{};
      },
      setting.field(owners));
}

}  // namespace

void Reader::read_value(const Found& found) {
  if (found.setting.list) return read_list(found);
  switch (found.setting.type) {
    case Type::table:
      return read_whole_table(found);
    case Type::tables:
      return read_tables(found);
    case Type::custom:
      return found.setting.custom->read(*this, found);
    default:
      return read_scalar(found, found.setting.field(found.owners));
  }
}

void Reader::read_whole_table(const Found& found) {
  const Setting& setting = found.setting;
  if (setting.field) {
    const Field field = setting.field(found.owners);
    *std::get<bool*>(field) = true;
  }
  if (setting.one_of && found.value.table() != nullptr) {
    Value rules = found.value;
    if (!keep_one_rule(found, rules)) return;
    for (const Setting* row : kind_.below(setting.key)) unset(*row, found.owners);
    read_table(rules, setting.key, found.shown, found.owners);
  } else {
    read_table(found.value, setting.key, found.shown, found.owners);
  }
  if (setting.check != nullptr) setting.check(*this, found);
}

// Drops the rules of the file where overrides bring one; false, with the fault, if it is not one that is left.
bool Reader::keep_one_rule(const Found& found, Value& rules) {
  Table& table = *rules.table();
  const auto is_override = [](const Entry& entry) { return entry.value.place.is_override; };
  const bool overridden = std::any_of(table.begin(), table.end(), is_override);
  if (overridden) std::erase_if(table, [&](const Entry& entry) { return !is_override(entry); });
  if (table.size() == 1) return true;
  std::string names;
  for (const Setting* row : kind_.below(found.setting.key)) {
    names += (names.empty() ? "" : ", ") + std::string(row->leaf());
  }
  rules.place = overridden ? table.back().value.place : rules.place;
  fault(rules, found.shown, "must have exactly one of " + names);
  return false;
}

void Reader::read_tables(const Found& found) {
  const Array* list = found.value.array();
  if (list == nullptr || (list->empty() && found.setting.required)) {
    return fault(found.value, found.shown, "must be " + found.setting.accepted());
  }
  const Elements elements = std::get<Elements>(found.setting.field(found.owners));
  const std::string pattern = std::string(found.setting.key) + "[]";
  elements.clear();
  const auto undecided_before = undecided_;
  for (std::size_t i = 0; i < list->size(); ++i) {
    elements.append();
    read_table((*list)[i], pattern, fmt::format("{}[{}]", found.shown, i), elements.with(i, found.owners));
    undecided_ = undecided_before;
  }
  if (found.setting.check != nullptr) found.setting.check(*this, found);
}

void Reader::read_list(const Found& found) {
  const Array* list = found.value.array();
  if (list == nullptr || (list->empty() && found.setting.required)) {
    return fault(found.value, found.shown, "must be " + found.setting.accepted());
  }
  std::visit(
      [&](auto field) {
        using T = std::remove_pointer_t<decltype(field)>;
        if constexpr (std::is_same_v<T, std::vector<int>> || std::is_same_v<T, std::vector<double>> ||
                      std::is_same_v<T, std::vector<std::string>>) {
          field->clear();
          for (std::size_t i = 0; i < list->size(); ++i) {
            typename T::value_type element{};
            const std::string shown = fmt::format("{}[{}]", found.shown, i);
            read_scalar({found.setting, (*list)[i], shown, found.owners}, &element);
            field->push_back(std::move(element));
          }
        }
      },
      found.setting.field(found.owners));
}

void Reader::read_scalar(const Found& found, const Field& field) {
  switch (found.setting.type) {
    case Type::word:
      return read_word(found, field);
    case Type::text:
      return read_text(found, field);
    case Type::file:
      return read_file(found, field);
    case Type::boolean:
      if (const auto* boolean = std::get_if<bool>(&found.value.data)) {
        *std::get<bool*>(field) = *boolean;
        return;
      }
      break;
    default:
      if (const auto number = number_of(found.setting, found.value)) return read_number(found, *number, field);
      break;
  }
  fault(found.value, found.shown, "must be " + found.setting.accepted_element());
}

void Reader::read_number(const Found& found, double number, const Field& field) {
  const Range& range = found.setting.range;
  if (!std::isfinite(number)) return fault(found.value, found.shown, "must be finite");
  if (!range.contains(number)) return fault(found.value, found.shown, "must be " + range.to_string());
  // Their reciprocals overflow and their digits are few: nobody means them.
  if (std::fpclassify(number) == FP_SUBNORMAL) {
    return fault(found.value, found.shown,
                 fmt::format("too near to 0: smaller than {:.3g}", std::numeric_limits<double>::min()));
  }
  const auto* integer = std::get_if<std::int64_t>(&found.value.data);
  std::visit(
      [&](auto target) {
        using T = std::remove_pointer_t<decltype(target)>;
        if constexpr (std::is_same_v<T, double>) {
          *target = number;
        } else if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>) {
          NOISELOOM_CHECK(integer != nullptr);
          if (std::in_range<T>(*integer)) {
            *target = static_cast<T>(*integer);
          } else {
            fault(found.value, found.shown,
                  fmt::format("must be from {} to {}", std::numeric_limits<T>::min(), std::numeric_limits<T>::max()));
          }
        }
      },
      field);
}

void Reader::read_word(const Found& found, const Field& field) {
  const Setting& setting = found.setting;
  const std::string* text = found.value.text();
  const auto is_text = [&](const Word& word) { return text != nullptr && word.word == *text; };
  if (text == nullptr) {
    fault(found.value, found.shown, "must be " + setting.accepted_element());
  } else if (std::none_of(setting.words.begin(), setting.words.end(), is_text)) {
    fault(found.value, found.shown, unknown_word(*text, setting));
  } else if (setting.list) {
    *std::get<std::string*>(field) = *text;
    return;
  } else {
    // A word that was looked up before is not set again: what depends on it may have been read since.
    if (current_word(setting, found.owners) != *text) set_word(setting, *text, found.owners);
    return;
  }
  undecided_.push_back(setting.key);
}

// A NUL would end the text for the system's calls, and so name another file.
void Reader::read_text(const Found& found, const Field& field) {
  const std::string* text = found.value.text();
  if (text == nullptr) return fault(found.value, found.shown, "must be " + found.setting.accepted_element());
  if (text->find('\0') != std::string::npos) return fault(found.value, found.shown, "must not hold the character NUL");
  *std::get<std::string*>(field) = *text;
}

void Reader::read_file(const Found& found, const Field& field) {
  const std::string* text = found.value.text();
  if (text == nullptr || text->empty() || text->find('\0') != std::string::npos) {
    return fault(found.value, found.shown, "must be " + found.setting.accepted_element());
  }
  const bool as_written = folder_.empty() || folder_ == "." || std::filesystem::path(*text).is_absolute();
  const std::string path = as_written ? *text : folder_ + '/' + *text;
  std::error_code error;
  const bool looks = missing_ == MissingFiles::refused && !found.setting.is_found_by_reader;
  if (looks && !std::filesystem::exists(path, error)) {
    return fault(found.value, found.shown, as_written ? "no such file" : "no such file: " + path);
  }
  if (looks && std::filesystem::is_directory(path, error)) {
    return fault(found.value, found.shown, "is a folder, must be a file");
  }
  *std::get<std::string*>(field) = path;
  written_paths_.emplace(path, *text);
}

}  // namespace noiseloom::settings
