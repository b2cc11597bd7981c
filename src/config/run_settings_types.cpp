// The settings of a run that are more than one value: the sizes of the axes, the axes of a group.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "config/run_settings.h"
#include "noiseloom/config/settings_writer.h"

namespace noiseloom::settings {
namespace {

// "channel" labels the last dimension of the arrays in a run file.
constexpr std::string_view reserved_name = "channel";
constexpr std::size_t longest_name = 64;

// What is wrong with the name of an axis: it is written as a bare key, an attribute and a dimension label. Empty if
// nothing is.
std::string name_fault(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto inner = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_'; };
  if (name.empty() || !letter(name.front()) || !std::all_of(name.begin(), name.end(), inner)) {
    return "not the name of an axis; accepted: letters, digits and _, beginning with a letter";
  }
  if (name == reserved_name) {
    return "this name is reserved: in a run file it labels the last dimension, the components of a sample; choose "
           "another";
  }
  return name.size() > longest_name ? fmt::format("a name of more than {} characters", longest_name) : "";
}

std::string quoted(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + toml_string(name);
  return text;
}

// texture.size

// Ids of samples have 32 bits, slices 31; no machine holds 2^48 pixels.
std::string count_fault(const std::vector<std::int64_t>& sizes) {
  double slices = 1;
  for (std::size_t axis = 2; axis < sizes.size(); ++axis) slices *= static_cast<double>(sizes[axis]);
  const double cells = static_cast<double>(sizes[0]) * static_cast<double>(sizes[1]);
  if (sizes.size() > static_cast<std::size_t>(Extents::max_axes)) {
    return fmt::format("{} axes; at most {}, x and y included", sizes.size(), Extents::max_axes);
  }
  if (cells > 0x1p32 - 1) return fmt::format("{} pixels in a slice; at most 4294967295", cells);
  if (slices > std::numeric_limits<std::int32_t>::max()) return fmt::format("{} slices; at most 2147483647", slices);
  if (cells * slices > 0x1p48) return fmt::format("{} pixels; at most 281474976710656", cells * slices);
  return "";
}

// The size that an axis is given; 0, and the fault, if it is unsound.
std::int64_t read_axis_size(Reader& reader, const Entry& entry, const std::string& shown) {
  const std::string key = shown + '.' + toml_key(entry.key);
  const auto* size = std::get_if<std::int64_t>(&entry.value.data);
  if (const std::string why = name_fault(entry.key); !why.empty()) {
    reader.fault(entry.place, key + ": " + why);
  } else if (size == nullptr) {
    reader.fault(entry.value, key, "must be an integer, at least 1");
  } else if (*size < 1 || *size > std::numeric_limits<std::int32_t>::max()) {
    reader.fault(entry.value, key, *size < 1 ? "must be at least 1" : "must be at most 2147483647");
  } else {
    return *size;
  }
  return 0;
}

void read_size(Reader& reader, const Found& found) {
  const Table* table = found.value.table();
  if (table == nullptr) return reader.fault(found.value, found.shown, "must be " + found.setting.accepted());
  const std::vector<std::string> names = axis_names(reader.root());
  std::vector<std::int64_t> sizes(2, 0);
  for (const Entry& entry : *table) {
    const std::int64_t size = read_axis_size(reader, entry, found.shown);
    if (entry.key == "x" || entry.key == "y") {
      sizes[entry.key == "x" ? 0 : 1] = size;
    } else {
      sizes.push_back(size);
    }
  }
  for (const auto& [axis, capital] : {std::pair("x", "X"), std::pair("y", "Y")}) {
    if (find(*table, axis) != nullptr) continue;
    const std::string hint = find(*table, capital) != nullptr ? fmt::format("; did you mean it by {}?", capital) : "";
    reader.fault(found.value.place, fmt::format("{}.{}: missing{}", found.shown, axis, hint));
  }
  if (std::find(sizes.begin(), sizes.end(), 0) != sizes.end()) return;
  if (const std::string why = count_fault(sizes); !why.empty()) return reader.fault(found.value, found.shown, why);
  found.owners.get<RunConfig>().problem.extents = Extents(sizes, names);
}

std::string size_text(const Writer& /*writer*/, const Setting& /*setting*/, const Owners& owners) {
  const Extents& extents = owners.get<RunConfig>().problem.extents;
  std::string text;
  for (int axis = 0; axis < extents.num_axes(); ++axis) {
    text += fmt::format("{}{} = {}", axis == 0 ? "{ " : ", ", extents.name(axis), extents.size(axis));
  }
  return text.empty() ? text : text + " }";
}

// Axes of a group, and those that are bounded

// The names that a value gives; nothing if it is no text and no list of texts.
std::optional<std::vector<std::string>> names_in(const Value& value) {
  std::vector<std::string> names;
  if (const std::string* letters = value.text()) {
    for (const char byte : *letters) {
      const bool continues = (static_cast<unsigned char>(byte) & 0xC0) == 0x80;  // a character of several bytes
      if (continues && !names.empty()) {
        names.back() += byte;
      } else {
        names.emplace_back(1, byte);
      }
    }
    return names;
  }
  if (value.array() == nullptr) return std::nullopt;
  for (const Value& element : *value.array()) {
    if (element.text() == nullptr) return std::nullopt;
    names.push_back(*element.text());
  }
  return names;
}

// What the user may have meant by text of which some letters name no axis.
std::string axes_hint(const std::string& written, const std::vector<std::string>& axes, std::size_t num_unknown) {
  const auto is_axis = [&](const std::string& name) { return std::find(axes.begin(), axes.end(), name) != axes.end(); };
  std::string letters;  // without blanks, commas and capitals
  for (const char c : written) {
    if (std::isalpha(static_cast<unsigned char>(c)) != 0) {
      letters += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  const bool all_known = std::all_of(letters.begin(), letters.end(), [&](char c) { return is_axis({c}); });
  if (all_known && !letters.empty()) return fmt::format("; did you mean {}?", toml_string(letters));
  std::vector<std::string> long_names;
  std::copy_if(axes.begin(), axes.end(), std::back_inserter(long_names), [](const auto& n) { return n.size() > 1; });
  const std::string near = nearest_word(letters, long_names);
  if (!near.empty()) return fmt::format("; did you mean [{}]?", toml_string(near));
  const bool is_name = num_unknown > 1 && name_fault(written).empty();
  return is_name ? fmt::format("; a name longer than a letter is written [{}]", toml_string(written)) : "";
}

void read_axes(Reader& reader, const Found& found) {
  const Value& value = found.value;
  const auto names = names_in(value);
  if (!names || (names->empty() && found.setting.required)) {
    return reader.fault(value, found.shown, "must be " + found.setting.accepted());
  }
  const std::vector<std::string> all = axis_names(reader.root());
  if (all.empty()) return;  // texture.size is in fault
  const auto number = [&](const std::string& name) { return std::find(all.begin(), all.end(), name) - all.begin(); };
  const auto is_axis = [&](const std::string& name) { return number(name) < std::ssize(all); };
  if (value.text() != nullptr && value.text()->size() > 1 && is_axis(*value.text())) {
    return reader.fault(
        value, found.shown,
        fmt::format("a string is read letter by letter; did you mean [{}]?", toml_string(*value.text())));
  }
  std::vector<int>& axes = *std::get<std::vector<int>*>(found.setting.field(found.owners));
  axes.clear();
  std::vector<std::string> unknown;
  for (const std::string& name : *names) {
    const int axis = static_cast<int>(number(name));
    if (!is_axis(name)) {
      if (std::find(unknown.begin(), unknown.end(), name) == unknown.end()) unknown.push_back(name);
    } else if (std::find(axes.begin(), axes.end(), axis) != axes.end()) {
      reader.fault(value, found.shown, fmt::format("axis {} is named twice", toml_string(name)));
    } else {
      axes.push_back(axis);
    }
  }
  if (unknown.empty()) return;
  const std::string hint = value.text() != nullptr ? axes_hint(*value.text(), all, unknown.size()) : "";
  reader.fault(value, found.shown,
               fmt::format("no ax{} {}; the texture has {}{}", unknown.size() == 1 ? "is" : "es", quoted(unknown),
                           fmt::join(all, ", "), hint));
}

std::string axes_text(const Writer& /*writer*/, const Setting& setting, const Owners& owners) {
  const Extents& extents = owners.get<RunConfig>().problem.extents;
  std::string letters;
  std::vector<std::string> names;
  for (const int axis : *std::get<std::vector<int>*>(setting.field(owners))) {
    names.push_back(extents.name(axis));
    letters += names.back();
  }
  return letters.size() == names.size() ? toml_string(letters) : fmt::format("[{}]", quoted(names));
}

std::string some_axes_text(const Writer& writer, const Setting& setting, const Owners& owners) {
  const bool none = std::get<std::vector<int>*>(setting.field(owners))->empty();
  return none ? "" : axes_text(writer, setting, owners);
}

std::string axes_accepted(const Setting& /*setting*/) {
  return "the names of axes: \"xy\", or [\"time\"] where names are longer than a letter";
}

}  // namespace

std::vector<std::string> axis_names(const Value& root) {
  const Value* size = find_at(root, "texture.size");
  if (size == nullptr || size->table() == nullptr) return {};
  std::vector<std::string> names = {"x", "y"};
  for (const Entry& entry : *size->table()) {
    if (entry.key != "x" && entry.key != "y") names.push_back(entry.key);
  }
  return names;
}

const CustomType size_type = {
    .accepted = [](const Setting&) -> std::string { return "a table such as { x = 128, y = 128, t = 32 }"; },
    .read = read_size,
    .text = size_text};

const CustomType some_axes_type = {.accepted = axes_accepted, .read = read_axes, .text = some_axes_text};

const CustomType axes_type = {.accepted = axes_accepted, .read = read_axes, .text = axes_text};

}  // namespace noiseloom::settings
