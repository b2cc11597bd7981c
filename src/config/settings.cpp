#include "noiseloom/config/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>

namespace noiseloom::settings {
namespace {

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

}  // namespace

std::string Range::to_string() const {
  const bool bounded_below = least > -std::numeric_limits<double>::infinity();
  const bool bounded_above = most < std::numeric_limits<double>::infinity();
  std::string text;
  if (bounded_below && bounded_above && !above) return fmt::format("from {} to {}", least, most);
  if (bounded_below) text = fmt::format("{} {}", above ? "greater than" : "at least", least);
  if (bounded_above) text += fmt::format("{}at most {}", text.empty() ? "" : " and ", most);
  return text;
}

bool Condition::accepts(std::string_view word) const {
  for (std::string_view rest = words; !rest.empty();) {
    const std::string_view next = rest.substr(0, rest.find(' '));
    if (next == word) return true;
    rest.remove_prefix(std::min(rest.size(), next.size() + 1));
  }
  return false;
}

std::string Condition::to_string() const {
  std::string text;
  for (std::string_view rest = words; !rest.empty();) {
    const std::string_view next = rest.substr(0, rest.find(' '));
    rest.remove_prefix(std::min(rest.size(), next.size() + 1));
    text += fmt::format("{}\"{}\"", text.empty() ? "" : rest.empty() ? " or " : ", ", next);
  }
  return text;
}

Owners Owners::with(void* address, const std::type_info& type) const {
  Owners result = *this;
  result.owners_.emplace_back(address, &type);
  return result;
}

void* Owners::find(const std::type_info& type) const {
  const auto found = std::find_if(owners_.rbegin(), owners_.rend(), [&](const auto& o) { return *o.second == type; });
  NOISELOOM_CHECK(found != owners_.rend());
  return found->first;
}

std::string_view Setting::parent() const {
  const std::size_t dot = key.rfind('.');
  return dot == std::string_view::npos ? std::string_view{} : key.substr(0, dot);
}

std::string Setting::accepted() const {
  return list ? fmt::format("a list; each element {}", accepted_element()) : accepted_element();
}

std::string Setting::accepted_element() const {
  const auto with_range = [&](std::string text) {
    const std::string bounds = range.to_string();
    return bounds.empty() ? text : text + ", " + bounds;
  };
  switch (type) {
    case Type::boolean:
      return "true or false";
    case Type::integer:
      return with_range("an integer");
    case Type::number:
      return with_range("a number");
    case Type::duration:
      return "a duration greater than 0: \"10s\", \"5m\", \"1h30m\", or a number of seconds";
    case Type::word:
      return "one of " + list_of(words);
    case Type::text:
      return "text in quotes";
    case Type::file:
      return "the name of a file";
    case Type::table:
      return "a table";
    case Type::tables:
      return "a list of tables" + (example.empty() ? "" : " such as " + std::string(example));
    case Type::custom:
      return custom->accepted(*this);
  }
  return {};
}

std::vector<const Setting*> FileKind::below(std::string_view parent) const {
  std::vector<const Setting*> rows;
  for (const Setting& setting : settings) {
    if (setting.parent() == parent) rows.push_back(&setting);
  }
  return rows;
}

bool FileKind::has_row(std::string_view key) const {
  return std::any_of(settings.begin(), settings.end(), [&](const Setting& s) { return s.key == key; });
}

const Setting& FileKind::row(std::string_view key) const {
  const auto found = std::find_if(settings.begin(), settings.end(), [&](const Setting& s) { return s.key == key; });
  NOISELOOM_CHECK(found != settings.end());
  return *found;
}

std::string_view FileKind::current_leaf(std::string_view parent, std::string_view leaf) const {
  const auto found = std::find_if(settings.begin(), settings.end(), [&](const Setting& s) {
    return !s.former.empty() && s.former == leaf && s.parent() == parent;
  });
  return found == settings.end() ? leaf : found->leaf();
}

bool FileKind::applies(const Setting& setting, const Owners& owners) const {
  if (setting.when.key.empty()) return true;
  return setting.when.accepts(current_word(row(setting.when.key), owners));
}

std::string_view current_word(const Setting& setting, const Owners& owners) {
  const Field field = setting.field(owners);
  if (const auto* choice = std::get_if<Choice>(&field)) {
    return choice->index() < setting.words.size() ? setting.words[choice->index()].word : std::string_view{};
  }
  return *std::get<std::string*>(field);
}

bool set_word(const Setting& setting, std::string_view text, const Owners& owners) {
  const auto word =
      std::find_if(setting.words.begin(), setting.words.end(), [&](const Word& w) { return w.word == text; });
  if (word == setting.words.end()) return false;
  const Field field = setting.field(owners);
  if (const auto* choice = std::get_if<Choice>(&field)) {
    choice->set(static_cast<std::size_t>(word - setting.words.begin()));
  } else {
    *std::get<std::string*>(field) = text;
  }
  if (setting.chosen != nullptr) setting.chosen(owners);
  return true;
}

std::string suggestion(std::string_view found, std::span<const Word> words) {
  std::vector<std::string> names;
  std::vector<std::string_view> leads_to;
  for (const Word& word : words) {
    std::istringstream other_names{std::string(word.word) + ' ' + std::string(word.aliases)};
    for (std::string name; other_names >> name;) {
      names.push_back(name);
      leads_to.push_back(word.word);
    }
  }
  const std::string nearest = nearest_word(lower_case(found), names);
  const auto position = std::find(names.begin(), names.end(), nearest) - names.begin();
  return nearest.empty() ? "" : std::string(leads_to[static_cast<std::size_t>(position)]);
}

std::string unknown_word(std::string_view found, const Setting& setting) {
  const std::string near = suggestion(found, setting.words);
  return fmt::format("unknown {}; {}accepted: {}", setting.leaf(),
                     near.empty() ? "" : "did you mean \"" + near + "\"? ", list_of(setting.words));
}

std::string list_of(std::span<const Word> words) {
  std::string text;
  for (const Word& word : words) text += (text.empty() ? "" : ", ") + std::string(word.word);
  return text;
}

}  // namespace noiseloom::settings
