#include <fmt/format.h>

#include <sstream>

#include "config/config_tree.h"
#include "config/settings.h"

namespace noiseloom {
namespace {

using settings::Setting;
using settings::Type;

constexpr std::size_t width = 100;

std::string wrapped(std::string_view text, std::size_t indent) {
  std::istringstream words{std::string(text)};
  std::string result;
  std::string line;
  for (std::string word; words >> word;) {
    if (!line.empty() && indent + line.size() + 1 + word.size() > width) {
      result += std::string(indent, ' ') + line + '\n';
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return result + std::string(indent, ' ') + line + '\n';
}

// The default as a config would write it; empty if there is none.
std::string default_text(const Setting& setting) {
  if (setting.required || setting.zero_is_unset) return {};
  if (setting.type == Type::samples) return settings::toml_string(settings::word_from_samples({}));
  if (setting.field == nullptr) return {};
  RunConfig config;
  GroupSpec group;
  for (const KernelKind kind : {KernelKind::ema, KernelKind::gauss_energy}) {
    group.kernel = settings::default_kernel(kind);
    if (settings::applies(setting, {.config = &config, .group = &group})) break;
  }
  const settings::Target target{.config = &config, .group = &group};
  return std::visit(
      [&]<class T>(const T* value) -> std::string {
        if constexpr (std::is_enum_v<T>) return settings::toml_string(settings::current_word(setting, target));
        if constexpr (std::is_same_v<T, bool>) return *value ? "true" : "false";
        if constexpr (std::is_same_v<T, double>) return settings::number_text(*value);
        if constexpr (std::is_integral_v<T>) return std::to_string(*value);
        if constexpr (std::is_same_v<T, std::vector<int>>) return "\"\"";
        return {};
      },
      setting.field(target));
}

std::string described(const Setting& setting) {
  std::string facts = setting.type == Type::word      ? "one of the words below"
                      : setting.type == Type::samples ? "one of the words below, or a table"
                                                      : setting.accepted();
  if (!setting.unit.empty()) facts += fmt::format("; {}", setting.unit);
  if (setting.required) facts += "; required";
  if (const std::string value = default_text(setting); !value.empty()) facts += "; default " + value;
  if (!setting.when.key.empty()) {
    const std::string_view decider = settings::row(setting.when.key).leaf();
    facts += fmt::format("; with {} = {}", decider, setting.when.to_string());
  }
  std::string text = fmt::format("  {}\n", setting.key) + wrapped(facts, 6) + wrapped(setting.sentence, 6);
  for (const settings::Word& word : setting.words) {
    text += fmt::format("        {:<18} {}\n", word.word, word.meaning);
  }
  return text;
}

}  // namespace

std::string describe_settings() {
  std::string text;
  for (const Setting& setting : settings::all()) {
    if (setting.key.find('.') == std::string_view::npos) {
      text += fmt::format("{}[{}]  {}\n", text.empty() ? "" : "\n", setting.key, setting.sentence);
    } else {
      text += described(setting);
    }
  }
  return text;
}

}  // namespace noiseloom
