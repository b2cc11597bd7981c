#include <fmt/format.h>

#include <algorithm>

#include "config/config_tree.h"
#include "config/settings.h"

namespace noiseloom {
namespace settings {
namespace {

class ConfigWriter {
 public:
  explicit ConfigWriter(const RunConfig& config) : config_(config) {}

  std::string text() {
    std::string result;
    for (const Setting* table : below("")) {
      const Items lines = items(table->key, {.config = &config_});
      if (lines.empty()) continue;
      result += fmt::format("{}[{}]\n", result.empty() ? "" : "\n", table->key);
      for (const auto& [key, value] : lines) result += fmt::format("{} = {}\n", key, value);
    }
    return result;
  }

 private:
  using Items = std::vector<std::pair<std::string_view, std::string>>;

  Items items(std::string_view parent, const Target& target) {
    Items result;
    for (const Setting* setting : below(parent)) {
      if (!applies(*setting, target)) continue;
      std::string value = value_text(*setting, target);
      if (!value.empty()) result.emplace_back(setting->leaf(), std::move(value));
    }
    return result;
  }

  // Empty if there is nothing to say.
  std::string inline_table(const Items& items) {
    std::string text;
    for (const auto& [key, value] : items) text += fmt::format("{}{} = {}", text.empty() ? "{ " : ", ", key, value);
    return text.empty() ? text : text + " }";
  }

  std::string value_text(const Setting& setting, const Target& target) {
    switch (setting.type) {
      case Type::table:
        return inline_table(items(setting.key, target));
      case Type::size:
        return size_text();
      case Type::samples:
        if (config_.problem.samples.kind == SampleKind::file) return inline_table(items(setting.key, target));
        return toml_string(word_from_samples(config_.problem.samples));
      case Type::groups:
        return groups_text();
      case Type::axes:
        return axes_text(*std::get<std::vector<int>*>(setting.field(target)));
      case Type::word:
        return toml_string(current_word(setting, target));
      default:
        return scalar_text(setting, target);
    }
  }

  std::string scalar_text(const Setting& setting, const Target& target) {
    return std::visit(
        [&]<class T>(const T* value) -> std::string {
          if constexpr (std::is_same_v<T, std::string>) {
            const auto written = config_.written_paths.find(*value);
            return toml_string(written == config_.written_paths.end() ? *value : written->second);
          } else if constexpr (std::is_same_v<T, bool>) {
            return *value ? "true" : "false";
          } else if constexpr (std::is_arithmetic_v<T>) {
            if (setting.zero_is_unset && *value == T{}) return "";
            if constexpr (std::is_integral_v<T>) return std::to_string(*value);
            if (setting.type == Type::duration) return toml_string(fmt::format("{}s", *value));
            return number_text(static_cast<double>(*value));
          }
          return "";
        },
        setting.field(target));
  }

  std::string size_text() {
    const Extents& extents = config_.problem.extents;
    std::string text;
    for (int axis = 0; axis < extents.num_axes(); ++axis) {
      text += fmt::format("{}{} = {}", axis == 0 ? "{ " : ", ", extents.name(axis), extents.size(axis));
    }
    return text + " }";
  }

  std::string groups_text() {
    std::string text = "[\n";
    for (GroupSpec& group : config_.problem.filter.groups) {
      text += "  " + inline_table(items("filter.groups[]", {.config = &config_, .group = &group})) + ",\n";
    }
    return text + "]";
  }

  std::string axes_text(const std::vector<int>& axes) {
    std::string letters;
    std::string list;
    bool single_letters = true;
    for (const int axis : axes) {
      const std::string& name = config_.problem.extents.name(axis);
      single_letters = single_letters && name.size() == 1;
      letters += name;
      list += (list.empty() ? "" : ", ") + toml_string(name);
    }
    return single_letters ? toml_string(letters) : "[" + list + "]";
  }

  RunConfig config_;
};

bool is_table_list(const Value& value) {
  const Array* array = value.array();
  return array != nullptr && !array->empty() && array->front().table() != nullptr;
}

// Tables and lists of tables are compared element by element, the rest as text.
class Comparison {
 public:
  void compare(const std::string& key, const Value* stored, const Value* current) {
    if (stored != nullptr && current != nullptr && stored->table() != nullptr && current->table() != nullptr) {
      return compare_tables(key, *stored, *current);
    }
    if (stored != nullptr && current != nullptr && is_table_list(*stored) && is_table_list(*current)) {
      return compare_lists(key, *stored->array(), *current->array());
    }
    const std::string there = stored == nullptr ? "not" : to_text(*stored);
    const std::string here = current == nullptr ? "not" : to_text(*current);
    if (there != here) lines.push_back(fmt::format("{}: {} in the file, {} here", key, there, here));
  }

  std::vector<std::string> lines;

 private:
  void compare_tables(const std::string& key, const Value& stored, const Value& current) {
    const std::size_t lines_before = lines.size();
    const std::string prefix = key.empty() ? "" : key + '.';
    for (const Entry& entry : *stored.table()) {
      compare(prefix + entry.key, &entry.value, find(*current.table(), entry.key));
    }
    for (const Entry& entry : *current.table()) {
      if (find(*stored.table(), entry.key) == nullptr) compare(prefix + entry.key, nullptr, &entry.value);
    }
    // Only texture.size can have its keys in another order: then the slice axes are others.
    if (lines.size() == lines_before && to_text(stored) != to_text(current)) {
      lines.push_back(fmt::format("{}: {} in the file, {} here", key, to_text(stored), to_text(current)));
    }
  }

  void compare_lists(const std::string& key, const Array& stored, const Array& current) {
    for (std::size_t i = 0; i < std::max(stored.size(), current.size()); ++i) {
      compare(fmt::format("{}[{}]", key, i), i < stored.size() ? &stored[i] : nullptr,
              i < current.size() ? &current[i] : nullptr);
    }
  }
};

}  // namespace
}  // namespace settings

std::string to_toml(const RunConfig& config) { return settings::ConfigWriter(config).text(); }

std::vector<std::string> config_differences(const std::string& stored, const std::string& current) {
  const settings::Value there = settings::parse_tree(stored, "the stored config");
  const settings::Value here = settings::parse_tree(current, "the config");
  settings::Comparison comparison;
  comparison.compare("", &there, &here);
  return comparison.lines;
}

}  // namespace noiseloom
