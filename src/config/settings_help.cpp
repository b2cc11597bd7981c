#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <sstream>
#include <vector>

#include "noiseloom/config/settings_file.h"
#include "noiseloom/config/settings_writer.h"

namespace noiseloom::settings {
namespace {

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

// A struct of default values with one element in each list that the row's key passes through.
struct Defaults {
  Defaults(const FileKind& kind, const Setting& setting) {
    memory = kind.make(owners);
    std::string_view key = setting.key;
    for (std::size_t end = key.find("[]"); end != std::string_view::npos; end = key.find("[]", end + 2)) {
      const Elements elements = std::get<Elements>(kind.row(key.substr(0, end)).field(owners));
      elements.append();
      owners = elements.with(elements.size() - 1, owners);
    }
    if (!setting.when.key.empty()) set_word(kind.row(setting.when.key), setting.when.first_word(), owners);
  }

  std::shared_ptr<void> memory;
  Owners owners;
};

// The default as a file would write it; empty if there is none.
std::string default_text(const FileKind& kind, const Setting& setting) {
  if (setting.required || setting.zero_is_unset || setting.negative_is_unset) return {};
  if (setting.type == Type::table || setting.type == Type::tables) return {};
  const Defaults defaults(kind, setting);
  const std::string text = Writer(kind, {}).value_text(setting, defaults.owners);
  const bool says_nothing = (setting.type == Type::file || setting.type == Type::text) && text == "\"\"";
  return says_nothing ? "" : text;
}

// The key of the row above that lists the same words; empty if there is none.
std::string_view lister_of_words(const FileKind& kind, const Setting& setting) {
  const auto found = std::find_if(kind.settings.begin(), kind.settings.end(), [&](const Setting& s) {
    return &s == &setting ||
           (!s.words.empty() && s.words.data() == setting.words.data() && s.words.size() == setting.words.size());
  });
  return &*found == &setting ? std::string_view{} : found->key;
}

std::string described(const FileKind& kind, const Setting& setting) {
  const bool in_words = setting.type == Type::word && !setting.list;
  const std::string_view lister = lister_of_words(kind, setting);
  std::string facts = !in_words        ? setting.accepted()
                      : lister.empty() ? "one of the words below"
                                       : fmt::format("one of the words of {}", lister);
  if (setting.custom != nullptr && !setting.custom->help.empty()) facts = setting.custom->help;
  if (!setting.unit.empty()) facts += fmt::format("; {}", setting.unit);
  if (setting.required) facts += "; required";
  if (const std::string value = default_text(kind, setting); !value.empty()) facts += "; default " + value;
  if (!setting.when.key.empty()) {
    facts += fmt::format("; with {} = {}", kind.row(setting.when.key).leaf(), setting.when.to_string());
  }
  std::string text = fmt::format("  {}\n", setting.key) + wrapped(facts, 6) + wrapped(setting.sentence, 6);
  if (!lister.empty()) return text;
  for (const Word& word : setting.words) text += fmt::format("        {:<18} {}\n", word.word, word.meaning);
  return text;
}

}  // namespace

std::string describe(const FileKind& kind) {
  std::string text;
  for (const Setting& setting : kind.settings) {
    const bool heads_a_section = setting.parent().empty() && setting.type == Type::table;
    const bool heads_a_list = setting.parent().empty() && setting.type == Type::tables;
    const std::string_view gap = text.empty() ? "" : "\n";
    if (heads_a_section) {
      text += fmt::format("{}[{}]  {}\n", gap, setting.key, setting.sentence);
    } else if (heads_a_list) {
      text += fmt::format("{}[[{}]]  {}\n", gap, setting.key, setting.sentence);
    } else {
      text += described(kind, setting);
    }
  }
  return text;
}

}  // namespace noiseloom::settings
