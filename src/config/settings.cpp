#include "config/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "noiseloom/core/error.h"

namespace noiseloom::settings {
namespace {

struct SampleChoice {
  std::string_view stem;  // the word begins with it; longer ones first
  SampleKind kind;
  int channels;
};

constexpr SampleChoice sample_kinds[] = {
    {"uniform", SampleKind::uniform, 1},
    {"tent", SampleKind::tent, 1},
    {"gauss", SampleKind::gauss, 1},
    {"circle", SampleKind::circle, 1},
    {"vector", SampleKind::vector, 2},
    {"sphere", SampleKind::sphere, 3},
    {"hemisphere-cosine", SampleKind::hemisphere_cosine, 3},
    {"hemisphere", SampleKind::hemisphere, 3},
    {"disk", SampleKind::disk, 2},
};

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

std::string Condition::to_string() const {
  return fmt::format("\"{}\"", word) + (or_word.empty() ? "" : fmt::format(" or \"{}\"", or_word));
}

std::string Setting::accepted() const {
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
    case Type::file:
      return "the name of a file";
    case Type::table:
      return "a table";
    case Type::size:
      return "a table such as { x = 128, y = 128, t = 32 }";
    case Type::samples:
      return "one of " + list_of(words) + "; or { file = \"mine.npy\" }";
    case Type::groups:
      return "a list of tables such as { axes = \"xy\", kernel = \"box\", size = 5 }";
    case Type::axes:
      return "the names of axes: \"xy\", or [\"time\"] where names are longer than a letter";
  }
  return {};
}

std::vector<const Setting*> below(std::string_view parent) {
  std::vector<const Setting*> rows;
  for (const Setting& setting : all()) {
    const std::size_t dot = setting.key.rfind('.');
    if ((dot == std::string_view::npos ? "" : setting.key.substr(0, dot)) == parent) rows.push_back(&setting);
  }
  return rows;
}

const Setting& row(std::string_view key) {
  const auto found = std::find_if(all().begin(), all().end(), [&](const Setting& s) { return s.key == key; });
  NOISELOOM_CHECK(found != all().end());
  return *found;
}

SampleSpec samples_from_word(std::string_view word) {
  const auto found = std::find_if(std::begin(sample_kinds), std::end(sample_kinds),
                                  [&](const SampleChoice& choice) { return word.starts_with(choice.stem); });
  NOISELOOM_CHECK(found != std::end(sample_kinds));
  SampleSpec samples;
  samples.kind = found->kind;
  samples.channels = found->kind == SampleKind::vector ? word.back() - '0' : found->channels;
  return samples;
}

std::string word_from_samples(const SampleSpec& samples) {
  const auto found = std::find_if(std::begin(sample_kinds), std::end(sample_kinds),
                                  [&](const SampleChoice& choice) { return choice.kind == samples.kind; });
  NOISELOOM_CHECK(found != std::end(sample_kinds));
  const std::string stem(found->stem);
  return samples.kind == SampleKind::vector ? stem + std::to_string(samples.channels) : stem;
}

KernelSpec default_kernel(KernelKind kind) {
  KernelSpec kernel;
  kernel.kind = kind;
  if (kind == KernelKind::gauss_energy) kernel.sigma = 1.9;  // [STBN22], [Ulichney93]
  return kernel;
}

std::string_view current_word(const Setting& setting, const Target& target) {
  return std::visit(
      [&]<class T>(T* value) -> std::string_view {
        if constexpr (std::is_enum_v<T>) return setting.words[static_cast<std::size_t>(*value)].word;
        return {};
      },
      setting.field(target));
}

bool applies(const Setting& setting, const Target& target) {
  if (setting.when.key.empty()) return true;
  const std::string_view word = current_word(row(setting.when.key), target);
  return word == setting.when.word || word == setting.when.or_word;
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
