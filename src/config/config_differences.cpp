#include <fmt/format.h>

#include <algorithm>

#include "config/override.h"
#include "config/run_settings.h"
#include "noiseloom/config/config.h"
#include "noiseloom/config/tree.h"

namespace noiseloom {
namespace settings {
namespace {

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

std::vector<std::string> config_differences(const std::string& stored, const std::string& current) {
  settings::Value there = settings::parse_tree(stored, "the stored config");
  settings::rename_former_keys(settings::run_config_kind(), there);
  const settings::Value here = settings::parse_tree(current, "the config");
  settings::Comparison comparison;
  comparison.compare("", &there, &here);
  return comparison.lines;
}

}  // namespace noiseloom
