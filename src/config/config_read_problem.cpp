// The settings that are more than one value: sizes, samples, groups and their axes, the stop rule.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "config/config_read.h"

namespace noiseloom::settings {
namespace {

// Names that can be written as a bare key, an attribute and a dimension label. "channel" labels the last dimension of a
// run file.
bool is_axis_name(const std::string& name) {
  const auto letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
  const auto inner = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  return !name.empty() && letter(name.front()) && std::all_of(name.begin(), name.end(), inner) && name != "channel";
}

std::string quoted_list(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}  // namespace

void ConfigReader::read_size(const Setting& setting, const Value& value, const std::string& shown) {
  const Table* table = value.table();
  if (table == nullptr) return fault(value, shown, "must be " + setting.accepted());
  axis_names_ = {"x", "y"};
  std::vector<std::int64_t> sizes(2, 0);
  std::size_t num_sound = 0;
  for (const Entry& entry : *table) {
    const std::string key = shown + '.' + entry.key;
    const auto* size = std::get_if<std::int64_t>(&entry.value.data);
    const auto spatial = std::find(axis_names_.begin(), axis_names_.begin() + 2, entry.key);
    const std::size_t axis = spatial != axis_names_.begin() + 2
                                 ? static_cast<std::size_t>(spatial - axis_names_.begin())
                                 : axis_names_.size();
    if (axis == axis_names_.size()) {
      axis_names_.push_back(entry.key);
      sizes.push_back(0);
    }
    if (!is_axis_name(entry.key)) {
      fault(entry.place, key + ": not the name of an axis; accepted: letters, digits and _, beginning with a letter");
    } else if (size == nullptr) {
      fault(entry.value, key, "must be an integer, at least 1");
    } else if (*size < 1 || *size > std::numeric_limits<std::int32_t>::max()) {
      fault(entry.value, key, *size < 1 ? "must be at least 1" : "must be at most 2147483647");
    } else {
      sizes[axis] = *size;
      ++num_sound;
    }
  }
  for (const char* axis : {"x", "y"}) {
    if (find(*table, axis) == nullptr) fault(value.place, fmt::format("{}.{}: missing", shown, axis));
  }
  if (num_sound == sizes.size()) set_extents(value, shown, sizes);
}

// Ids of samples have 32 bits, slices 31; no machine holds 2^48 pixels.
void ConfigReader::set_extents(const Value& value, const std::string& shown, const std::vector<std::int64_t>& sizes) {
  double slices = 1;
  for (std::size_t axis = 2; axis < sizes.size(); ++axis) slices *= static_cast<double>(sizes[axis]);
  const double cells = static_cast<double>(sizes[0]) * static_cast<double>(sizes[1]);
  if (sizes.size() > static_cast<std::size_t>(Extents::max_axes)) {
    fault(value, shown, fmt::format("{} axes; at most {}, x and y included", sizes.size(), Extents::max_axes));
  } else if (cells > 0x1p32 - 1) {
    fault(value, shown, fmt::format("{} pixels in a slice; at most 4294967295", cells));
  } else if (slices > std::numeric_limits<SliceIndex>::max()) {
    fault(value, shown, fmt::format("{} slices; at most 2147483647", slices));
  } else if (cells * slices > 0x1p48) {
    fault(value, shown, fmt::format("{} pixels; at most 281474976710656", cells * slices));
  } else {
    config_.problem.extents = Extents(sizes, axis_names_);
  }
}

void ConfigReader::read_samples(const Setting& setting, const Value& value, const std::string& shown,
                                const Target& target) {
  SampleSpec& samples = config_.problem.samples;
  if (const Table* table = value.table()) {
    if (const Value* image = find(*table, "image")) {
      return fault(*image, shown + ".image", "planned, but this version does not have it");
    }
    samples.kind = SampleKind::file;
    return read_table(value, setting.key, shown, target);
  }
  const auto* text = std::get_if<std::string>(&value.data);
  if (text == nullptr) return fault(value, shown, "must be " + setting.accepted());
  const auto word =
      std::find_if(setting.words.begin(), setting.words.end(), [&](const Word& w) { return w.word == *text; });
  if (word == setting.words.end()) return fault(value, shown, unknown_word(*text, setting));
  samples = samples_from_word(word->word);
}

void ConfigReader::read_groups(const Setting& setting, const Value& value, const std::string& shown) {
  const Array* groups = value.array();
  if (groups == nullptr || groups->empty()) return fault(value, shown, "must be " + setting.accepted());
  const auto undecided_before = undecided_;
  for (std::size_t i = 0; i < groups->size(); ++i) {
    GroupSpec group;
    const std::string name = fmt::format("{}[{}]", shown, i);
    read_table((*groups)[i], "filter.groups[]", name, {.config = &config_, .group = &group});
    config_.problem.filter.groups.push_back(std::move(group));
    undecided_ = undecided_before;
  }
  if (!decided(row("filter.groups[].weight"))) return;  // product or sum?
  if (config_.problem.filter.combine == Combine::product) check_axes_are_disjoint(*groups, shown);
  if (config_.problem.filter.combine == Combine::sum) check_weights(value, shown);
}

void ConfigReader::read_axes(const Setting& setting, const Value& value, const std::string& shown,
                             const Target& target) {
  std::vector<int>& axes = *std::get<std::vector<int>*>(setting.field(target));
  std::vector<std::string> names;
  if (const auto* letters = std::get_if<std::string>(&value.data)) {
    for (const char letter : *letters) names.emplace_back(1, letter);
    const bool is_name = std::find(axis_names_.begin(), axis_names_.end(), *letters) != axis_names_.end();
    if (is_name && letters->size() > 1) {
      return fault(value, shown,
                   fmt::format("a string is read letter by letter; did you mean [{}]?", toml_string(*letters)));
    }
  } else if (const Array* list = value.array()) {
    for (const Value& element : *list) {
      const auto* name = std::get_if<std::string>(&element.data);
      if (name == nullptr) return fault(value, shown, "must be " + setting.accepted());
      names.push_back(*name);
    }
  }
  const bool is_list = value.array() != nullptr || std::holds_alternative<std::string>(value.data);
  if (!is_list || (names.empty() && setting.required)) return fault(value, shown, "must be " + setting.accepted());
  for (const std::string& name : names) {
    const auto axis = std::find(axis_names_.begin(), axis_names_.end(), name);
    const int index = static_cast<int>(axis - axis_names_.begin());
    if (axis_names_.empty()) continue;  // texture.size is in fault
    if (axis == axis_names_.end()) {
      fault(value, shown, fmt::format("no axis {}; the texture has {}", toml_string(name), quoted_list(axis_names_)));
    } else if (std::find(axes.begin(), axes.end(), index) != axes.end()) {
      fault(value, shown, fmt::format("axis {} is named twice", toml_string(name)));
    } else {
      axes.push_back(index);
    }
  }
}

void ConfigReader::check_axes_are_disjoint(const Array& groups, const std::string& shown) {
  std::vector<std::size_t> owner(axis_names_.size(), groups.size());
  for (std::size_t i = 0; i < groups.size(); ++i) {
    for (const int axis : config_.problem.filter.groups[i].axes) {
      std::size_t& first = owner[static_cast<std::size_t>(axis)];
      if (first == groups.size()) {
        first = i;
      } else {
        fault(*find(*groups[i].table(), "axes"), fmt::format("{}[{}].axes", shown, i),
              fmt::format("axis {} is in {}[{}] already; with combine = \"product\" an axis belongs to one group",
                          toml_string(axis_names_[static_cast<std::size_t>(axis)]), shown, first));
      }
    }
  }
}

void ConfigReader::check_weights(const Value& groups, const std::string& shown) {
  std::vector<GroupSpec>& specs = config_.problem.filter.groups;
  std::size_t num_given = 0;
  bool sound = true;
  double sum = 0;
  for (std::size_t i = 0; i < specs.size(); ++i) {
    const Table* table = (*groups.array())[i].table();
    if (table != nullptr && find(*table, "weight") != nullptr) ++num_given;
    if (table != nullptr && find(*table, "weight") != nullptr && specs[i].weight == 0) sound = false;
    sum += specs[i].weight;
  }
  if (num_given == 0) {
    for (GroupSpec& spec : specs) spec.weight = 1.0 / static_cast<double>(specs.size());
  } else if (num_given < specs.size()) {
    fault(groups.place, fmt::format("{}: {} of {} groups have a weight; all must, or none (equal shares)", shown,
                                    num_given, specs.size()));
  } else if (sound && std::abs(sum - 1) > 1e-6) {
    fault(groups.place, fmt::format("{}: weights add up to {:.7g}; must add up to 1", shown, sum));
  }
}

void ConfigReader::read_stop(const Value& value, const std::string& shown, const Target& target) {
  Value rules = value;
  if (Table* table = rules.table()) {
    const auto overrides = [](const Entry& entry) { return entry.value.place.is_override; };
    const bool overridden = std::any_of(table->begin(), table->end(), overrides);
    if (overridden) std::erase_if(*table, [&](const Entry& entry) { return !overrides(entry); });
    if (table->size() != 1) {
      const Place& place = overridden ? table->back().value.place : value.place;
      return fault(place, fmt::format("{} = {}: must have exactly one of iterations, time, score, improvement", shown,
                                      to_text(rules)));
    }
  }
  StopSpec& stop = config_.optimizer.stop;
  stop = {.iterations = 0};
  read_table(rules, "optimizer.stop", shown, target);
}

void ConfigReader::check_temperatures(const Value& value, const std::string& shown) {
  const OptimizerSpec& optimizer = config_.optimizer;
  if (optimizer.temperature_start > 0 && optimizer.temperature_end > optimizer.temperature_start) {
    fault(value, shown, "end must not be above start");
  }
}

}  // namespace noiseloom::settings
