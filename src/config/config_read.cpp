#include "config/config_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace noiseloom::settings {
namespace {

std::string joined(const std::string& parent, std::string_view key) {
  return parent.empty() ? std::string(key) : parent + '.' + std::string(key);
}

// Long lists are cut, between characters of UTF-8: the line number leads to the rest.
std::string shortened(const Value& value) {
  constexpr std::size_t longest = 60;
  std::string text = to_text(value);
  if (text.size() <= longest) return text;
  std::size_t end = longest - 4;
  while ((static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return text.substr(0, end) + " ...";
}

}  // namespace

RunConfig ConfigReader::read(const Value& root) {
  config_ = RunConfig{};
  axis_names_.clear();
  undecided_.clear();
  faults_.clear();
  look_up_method(root);
  read_table(root, "", "", {.config = &config_});
  if (config_.optimizer.method == Method::void_and_cluster) check_void_and_cluster(root);
  return config_;
}

std::vector<Fault> ConfigReader::faults() const {
  auto sorted = faults_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first.is_override, a.first.line) < std::pair(b.first.is_override, b.first.line);
  });
  std::vector<Fault> result;
  for (auto& [place, fault] : sorted) result.push_back(std::move(fault));
  return result;
}

void ConfigReader::fault(const Place& place, const std::string& text) {
  faults_.push_back({place, {place.to_string(), text}});
}

void ConfigReader::fault(const Value& value, const std::string& shown, const std::string& text) {
  fault(value.place, fmt::format("{} = {}: {}", shown, shortened(value), text));
}

bool ConfigReader::decided(const Setting& setting) const {
  return std::find(undecided_.begin(), undecided_.end(), setting.when.key) == undecided_.end();
}

void ConfigReader::read_table(const Value& value, std::string_view pattern, const std::string& shown,
                              const Target& target) {
  const Table* table = value.table();
  if (table == nullptr) return fault(value, shown, "must be a table");
  std::vector<const Setting*> rows = below(pattern);
  while (!rows.empty()) {
    const std::string_view leaf = rows.front()->leaf();
    std::vector<const Setting*> same_key;
    std::copy_if(rows.begin(), rows.end(), std::back_inserter(same_key),
                 [&](const Setting* s) { return s->leaf() == leaf; });
    std::erase_if(rows, [&](const Setting* s) { return s->leaf() == leaf; });
    read_key(same_key, value, joined(shown, leaf), target);
  }
  report_unknown_keys(*table, pattern, shown, target);
}

void ConfigReader::read_key(const std::vector<const Setting*>& rows, const Value& parent, const std::string& shown,
                            const Target& target) {
  const Value* value = find(*parent.table(), rows.front()->leaf());
  if (!decided(*rows.front())) return;
  const auto applying = std::find_if(rows.begin(), rows.end(), [&](const Setting* s) { return applies(*s, target); });
  if (applying == rows.end()) {
    if (value == nullptr) return;
    undecided_.push_back(rows.front()->key);
    std::string needed;
    for (const Setting* row : rows) needed += (needed.empty() ? "" : " or ") + row->when.to_string();
    const std::string_view decider = rows.front()->when.key;
    return fault(*value, shown,
                 fmt::format("applies only with {} = {}; here it is {}", row(decider).leaf(), needed,
                             toml_string(current_word(row(decider), target))));
  }
  const Setting& setting = **applying;
  if (value != nullptr) return read_value(setting, *value, shown, target);
  if (setting.required) {
    fault(parent.place, setting.type == Type::table
                            ? fmt::format("{0}: missing; a config needs the table [{0}]", shown)
                            : fmt::format("{}: missing; must be {}", shown, setting.accepted()));
    undecided_.push_back(setting.key);
  }
}

void ConfigReader::report_unknown_keys(const Table& table, std::string_view pattern, const std::string& shown,
                                       const Target& target) {
  std::vector<std::string> known;
  std::vector<std::string> usable;
  std::string list;
  for (const Setting* setting : below(pattern)) {
    known.emplace_back(setting->leaf());
    const bool listed = std::find(usable.begin(), usable.end(), setting->leaf()) != usable.end();
    if (listed || (decided(*setting) && !applies(*setting, target))) continue;
    usable.emplace_back(setting->leaf());
    list += (list.empty() ? "" : ", ") + usable.back();
  }
  for (const Entry& entry : table) {
    if (std::find(known.begin(), known.end(), entry.key) != known.end()) continue;
    const std::string near = nearest_word(entry.key, usable);
    fault(entry.place, fmt::format("{}: unknown key; {}accepted: {}", joined(shown, entry.key),
                                   near.empty() ? "" : "did you mean " + toml_string(near) + "? ", list));
  }
}

void ConfigReader::read_value(const Setting& setting, const Value& value, const std::string& shown,
                              const Target& target) {
  switch (setting.type) {
    case Type::table:
      if (setting.key == "optimizer.stop") return read_stop(value, shown, target);
      read_table(value, setting.key, shown, target);
      if (setting.key == "optimizer.temperature") check_temperatures(value, shown);
      return;
    case Type::word:
      return read_word(setting, value, shown, target);
    case Type::file:
      return read_file(setting, value, shown, target);
    case Type::size:
      return read_size(setting, value, shown);
    case Type::samples:
      return read_samples(setting, value, shown, target);
    case Type::groups:
      return read_groups(setting, value, shown);
    case Type::axes:
      return read_axes(setting, value, shown, target);
    default:
      return read_scalar(setting, value, shown, target);
  }
}

void ConfigReader::read_scalar(const Setting& setting, const Value& value, const std::string& shown,
                               const Target& target) {
  const auto* integer = std::get_if<std::int64_t>(&value.data);
  const auto* number = std::get_if<double>(&value.data);
  const auto* text = std::get_if<std::string>(&value.data);
  const auto* boolean = std::get_if<bool>(&value.data);
  if (setting.type == Type::boolean && boolean != nullptr) {
    *std::get<bool*>(setting.field(target)) = *boolean;
  } else if (integer != nullptr && setting.type != Type::boolean) {
    read_number(setting, static_cast<double>(*integer), value, shown, target);
  } else if (number != nullptr && (setting.type == Type::number || setting.type == Type::duration)) {
    read_number(setting, *number, value, shown, target);
  } else if (text != nullptr && setting.type == Type::duration && parse_duration(*text)) {
    read_number(setting, *parse_duration(*text), value, shown, target);
  } else {
    fault(value, shown, "must be " + setting.accepted());
  }
}

void ConfigReader::read_number(const Setting& setting, double number, const Value& value, const std::string& shown,
                               const Target& target) {
  if (!std::isfinite(number)) return fault(value, shown, "must be finite");
  if (!setting.range.contains(number)) return fault(value, shown, "must be " + setting.range.to_string());
  const auto* integer = std::get_if<std::int64_t>(&value.data);
  std::visit(
      [&]<class T>(T* field) {
        if constexpr (std::is_same_v<T, double>) {
          *field = number;
        } else if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>) {
          *field = static_cast<T>(*integer);
        }
      },
      setting.field(target));
}

bool ConfigReader::set_word(const Setting& setting, const Value& value, const Target& target) {
  const auto* text = std::get_if<std::string>(&value.data);
  const auto word = std::find_if(setting.words.begin(), setting.words.end(),
                                 [&](const Word& w) { return text != nullptr && w.word == *text; });
  if (word == setting.words.end()) return false;
  std::visit(
      [&]<class T>(T* field) {
        if constexpr (std::is_enum_v<T>) *field = static_cast<T>(word - setting.words.begin());
      },
      setting.field(target));
  return true;
}

void ConfigReader::read_word(const Setting& setting, const Value& value, const std::string& shown,
                             const Target& target) {
  const auto* text = std::get_if<std::string>(&value.data);
  if (text == nullptr) {
    fault(value, shown, "must be " + setting.accepted());
  } else if (!set_word(setting, value, target)) {
    fault(value, shown, unknown_word(*text, setting));
  } else {
    if (setting.key == "filter.groups[].kernel") target.group->kernel = default_kernel(target.group->kernel.kind);
    return;
  }
  undecided_.push_back(setting.key);
}

void ConfigReader::read_file(const Setting& setting, const Value& value, const std::string& shown,
                             const Target& target) {
  const auto* text = std::get_if<std::string>(&value.data);
  if (text == nullptr || text->empty()) return fault(value, shown, "must be " + setting.accepted());
  const bool as_written = folder_.empty() || folder_ == "." || std::filesystem::path(*text).is_absolute();
  const std::string path = as_written ? *text : folder_ + '/' + *text;
  std::error_code error;
  if (missing_ == MissingFiles::refused && !std::filesystem::exists(path, error)) {
    return fault(value, shown, as_written ? "no such file" : "no such file: " + path);
  }
  if (missing_ == MissingFiles::refused && std::filesystem::is_directory(path, error)) {
    return fault(value, shown, "is a folder, must be a file");
  }
  *std::get<std::string*>(setting.field(target)) = path;
  config_.written_paths.emplace(path, *text);
}

}  // namespace noiseloom::settings
