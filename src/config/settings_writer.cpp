#include "noiseloom/config/settings_writer.h"

#include <fmt/format.h>

#include <type_traits>

#include "noiseloom/core/text.h"

namespace noiseloom::settings {
namespace {

bool is_section(const Setting& setting) { return setting.type == Type::table || setting.type == Type::tables; }

// Durations have no exponent: very short and very long ones are written as numbers of seconds.
std::string stored_duration(double seconds) {
  const std::string digits = fmt::format("{}", seconds);
  return digits.find('e') == std::string::npos ? toml_string(digits + 's') : digits;
}

}  // namespace

std::string Writer::text(const Owners& owners) const {
  std::string result;
  for (const Setting* setting : kind_.below("")) {
    if (is_section(*setting) || !kind_.applies(*setting, owners)) continue;
    const std::string value = value_text(*setting, owners);
    if (!value.empty()) result += fmt::format("{} = {}\n", toml_key(setting->leaf()), value);
  }
  for (const Setting* setting : kind_.below("")) {
    if (!is_section(*setting) || !kind_.applies(*setting, owners)) continue;
    const std::string part = section(*setting, owners);
    if (!part.empty()) result += (result.empty() ? "" : "\n") + part;
  }
  return result;
}

// A table or a list of tables of the top level, with a header of its own; empty if there is nothing to say.
std::string Writer::section(const Setting& setting, const Owners& owners) const {
  if (setting.type == Type::table) {
    const std::string body = lines(setting.key, owners);
    const bool present = setting.field && *std::get<bool*>(setting.field(owners));
    return body.empty() && !present ? "" : fmt::format("[{}]\n{}", setting.key, body);
  }
  const Elements elements = std::get<Elements>(setting.field(owners));
  const std::string pattern = std::string(setting.key) + "[]";
  std::string result;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    result += fmt::format("{}[[{}]]\n{}", i == 0 ? "" : "\n", setting.key, lines(pattern, elements.with(i, owners)));
  }
  return result;
}

std::string Writer::lines(std::string_view pattern, const Owners& owners) const {
  std::string result;
  for (const Setting* setting : kind_.below(pattern)) {
    if (!kind_.applies(*setting, owners)) continue;
    const std::string value = value_text(*setting, owners);
    if (!value.empty()) result += fmt::format("{} = {}\n", toml_key(setting->leaf()), value);
  }
  return result;
}

std::string Writer::inline_table(std::string_view pattern, const Owners& owners, std::string_view without) const {
  std::string result;
  for (const Setting* setting : kind_.below(pattern)) {
    if (setting->leaf() == without || !kind_.applies(*setting, owners)) continue;
    const std::string value = value_text(*setting, owners);
    if (!value.empty())
      result += fmt::format("{}{} = {}", result.empty() ? "{ " : ", ", toml_key(setting->leaf()), value);
  }
  return result.empty() ? result : result + " }";
}

std::string Writer::value_text(const Setting& setting, const Owners& owners) const {
  switch (setting.type) {
    case Type::table: {
      const bool present = setting.field && *std::get<bool*>(setting.field(owners));
      if (setting.field && !present) return "";
      const std::string table = inline_table(setting.key, owners);
      return table.empty() && present ? "{}" : table;
    }
    case Type::tables:
      return tables_text(setting, owners);
    case Type::custom:
      return setting.custom->text(*this, setting, owners);
    case Type::word:
      if (!setting.list) return word_text(setting, owners);
      [[fallthrough]];
    default:
      return scalar_text(setting, setting.field(owners));
  }
}

std::string Writer::word_text(const Setting& setting, const Owners& owners) const {
  const std::string_view word = current_word(setting, owners);
  return setting.zero_is_unset && word == setting.words.front().word ? "" : toml_string(word);
}

// One element a line. Lists inside inline tables are written like all others: TOML lets a list go over lines anywhere.
std::string Writer::tables_text(const Setting& setting, const Owners& owners) const {
  const Elements elements = std::get<Elements>(setting.field(owners));
  const std::string pattern = std::string(setting.key) + "[]";
  std::string result;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const std::string element = inline_table(pattern, elements.with(i, owners));
    result += "  " + (element.empty() ? "{}" : element) + ",\n";
  }
  return result.empty() ? result : "[\n" + result + "]";
}

std::string Writer::scalar_text(const Setting& setting, const Field& field) const {
  const auto element_text = [&]<class T>(const T& value) -> std::string {
    if constexpr (std::is_same_v<T, std::string>) return string_text(setting, value);
    if constexpr (std::is_same_v<T, bool>) return value ? "true" : "false";
    if constexpr (std::is_integral_v<T>) return std::to_string(value);
    if constexpr (std::is_same_v<T, double>) {
      if (setting.type == Type::integer) return fmt::format("{}", value);
      return setting.type == Type::duration ? stored_duration(value) : number_text(value);
    }
    return "";
  };
  return std::visit(
      [&](const auto& target) -> std::string {
        using T = std::remove_pointer_t<std::decay_t<decltype(target)>>;
        if constexpr (std::is_same_v<T, std::vector<int>> || std::is_same_v<T, std::vector<double>> ||
                      std::is_same_v<T, std::vector<std::string>>) {
          std::string list;
          for (const auto& element : *target) list += (list.empty() ? "" : ", ") + element_text(element);
          return "[" + list + "]";
        } else if constexpr (std::is_same_v<T, Choice> || std::is_same_v<T, Elements>) {
          return "";
        } else {
          if (setting.zero_is_unset && *target == T{}) return "";
          if constexpr (std::is_same_v<T, double>) {
            if (setting.negative_is_unset && *target < 0) return "";
          }
          return element_text(*target);
        }
      },
      field);
}

std::string Writer::string_text(const Setting& setting, const std::string& text) const {
  if (setting.type != Type::file) return toml_string(text);
  const auto written = written_paths_.find(text);
  return toml_string(written == written_paths_.end() ? text : written->second);
}

}  // namespace noiseloom::settings
