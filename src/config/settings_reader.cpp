// Tables and their keys; single values are read in settings_reader_values.cpp.
#include "noiseloom/config/settings_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "noiseloom/core/text.h"

namespace noiseloom::settings {
namespace {

constexpr std::size_t max_faults_shown = 100;
constexpr std::size_t max_faults_kept = 1000;  // of a file of garbage; enough to sort those that are shown

std::string joined(const std::string& parent, std::string_view key) {
  return parent.empty() ? std::string(key) : parent + '.' + std::string(key);
}

}  // namespace

void Reader::read(const Value& root, const Owners& owners) {
  root_ = &root;
  written_paths_.clear();
  undecided_.clear();
  faults_.clear();
  num_left_out_ = 0;
  look_up_deciders(owners);
  read_table(root, "", "", owners);
  if (kind_.check != nullptr) kind_.check(*this, root, owners);
}

std::vector<Fault> Reader::faults() const {
  auto sorted = faults_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first.is_override, a.first.line) < std::pair(b.first.is_override, b.first.line);
  });
  std::vector<Fault> result;
  for (auto& [place, fault] : sorted) {
    if (result.size() < max_faults_shown) result.push_back(std::move(fault));
  }
  const std::size_t others = sorted.size() - result.size() + num_left_out_;
  if (others > 0) result.push_back({root_->place.file, fmt::format("{} faults more", others)});
  return result;
}

void Reader::fault(const Place& place, const std::string& text) {
  constexpr std::size_t longest = 2000;  // a name of megabytes is no help
  if (faults_.size() < max_faults_kept) {
    faults_.push_back({place, {place.to_string(), shortened(text, longest)}});
  } else {
    ++num_left_out_;
  }
}

// Long lists are cut: the line number leads to the rest.
void Reader::fault(const Value& value, const std::string& shown, const std::string& text) {
  fault(value.place, fmt::format("{} = {}: {}", shown, shortened(to_text(value), 60), text));
}

bool Reader::decided(std::string_view key) const {
  return std::find(undecided_.begin(), undecided_.end(), key) == undecided_.end();
}

// Settings of any table may depend on a word that stands in another one, so these words are set before tables are read.
// Words of list elements are not: they stand before what depends on them.
void Reader::look_up_deciders(const Owners& owners) {
  for (const Setting& setting : kind_.settings) {
    const std::string_view key = setting.when.key;
    if (key.empty() || key.find("[]") != std::string_view::npos) continue;
    const Value* value = find_at(*root_, key);
    if (value == nullptr || !decided(key)) continue;
    if (value->text() == nullptr || !set_word(kind_.row(key), *value->text(), owners)) undecided_.push_back(key);
  }
}

void Reader::read_table(const Value& value, std::string_view pattern, const std::string& shown, const Owners& owners) {
  const Table* table = value.table();
  if (table == nullptr) return fault(value, shown, "must be a table");
  std::vector<const Setting*> rows = kind_.below(pattern);
  while (!rows.empty()) {
    const std::string_view leaf = rows.front()->leaf();
    std::vector<const Setting*> same_key;
    std::copy_if(rows.begin(), rows.end(), std::back_inserter(same_key),
                 [&](const Setting* s) { return s->leaf() == leaf; });
    std::erase_if(rows, [&](const Setting* s) { return s->leaf() == leaf; });
    read_key(same_key, value, joined(shown, leaf), owners);
  }
  report_unknown_keys(*table, pattern, shown, owners);
}

void Reader::read_key(const std::vector<const Setting*>& rows, const Value& parent, const std::string& shown,
                      const Owners& owners) {
  const Value* value = find(*parent.table(), rows.front()->leaf());
  if (!decided(rows.front()->when.key)) return;
  const auto applying =
      std::find_if(rows.begin(), rows.end(), [&](const Setting* s) { return kind_.applies(*s, owners); });
  if (applying == rows.end()) {
    if (value != nullptr) report_unsuitable(rows, *value, shown, owners);
    return;
  }
  const Setting& setting = **applying;
  if (value != nullptr) return read_value({setting, *value, shown, owners});
  if (!setting.required) return;
  const bool section = setting.type == Type::table && setting.parent().empty();
  fault(parent.place, section ? fmt::format("{0}: missing; a {1} needs the table [{0}]", shown, kind_.noun)
                              : fmt::format("{}: missing; must be {}", shown, setting.accepted()));
  undecided_.push_back(setting.key);
}

// The key is known, but another word stands where its rows ask for theirs.
void Reader::report_unsuitable(const std::vector<const Setting*>& rows, const Value& value, const std::string& shown,
                               const Owners& owners) {
  undecided_.push_back(rows.front()->key);
  std::string needed;
  for (const Setting* row : rows) needed += (needed.empty() ? "" : " or ") + row->when.to_string();
  const Setting& decider = kind_.row(rows.front()->when.key);
  fault(value, shown,
        fmt::format("applies only with {} = {}; here it is {}", decider.leaf(), needed,
                    toml_string(current_word(decider, owners))));
}

void Reader::report_unknown_keys(const Table& table, std::string_view pattern, const std::string& shown,
                                 const Owners& owners) {
  std::vector<std::string_view> known;
  std::vector<std::string> usable;
  std::string list;
  for (const Setting* setting : kind_.below(pattern)) {
    known.push_back(setting->leaf());
    const bool listed = std::find(usable.begin(), usable.end(), setting->leaf()) != usable.end();
    if (listed || (decided(setting->when.key) && !kind_.applies(*setting, owners))) continue;
    usable.emplace_back(setting->leaf());
    list += (list.empty() ? "" : ", ") + usable.back();
  }
  for (const Entry& entry : table) {
    if (std::find(known.begin(), known.end(), entry.key) != known.end()) continue;
    if (faults_.size() >= max_faults_kept) {
      ++num_left_out_;
      continue;
    }
    if (const std::string_view now = kind_.current_leaf(pattern, entry.key); now != entry.key) {
      fault(entry.place,
            fmt::format("{}: is what older files call {}, which stands here too", joined(shown, entry.key), now));
      continue;
    }
    fault(entry.place, fmt::format("{}: unknown key; {}accepted: {}", joined(shown, shortened(toml_key(entry.key), 60)),
                                   did_you_mean(entry, pattern, usable), list));
  }
}

// A key that is spelled like one of this table, or that belongs to another table ("seed" for "texture.seed").
std::string Reader::did_you_mean(const Entry& entry, std::string_view pattern,
                                 const std::vector<std::string>& usable) const {
  std::string meant = elsewhere(entry.key, pattern, entry.place.is_override);
  if (meant.empty()) {
    if (const std::string near = nearest_word(entry.key, usable); !near.empty()) meant = toml_string(near);
  }
  if (meant.empty() && entry.key.size() > 3) {
    std::vector<std::string> leaves;
    for (const Setting& setting : kind_.settings) leaves.emplace_back(setting.leaf());
    const std::string near = nearest_word(entry.key, leaves);
    if (!near.empty()) meant = elsewhere(near, pattern, entry.place.is_override);
  }
  return meant.empty() ? "" : "did you mean " + meant + "? ";
}

// The dotted keys of other tables that end in `key`: `"texture.size" or "filter.groups[].size"`; empty if none does. On
// the command line an element has a number.
std::string Reader::elsewhere(const std::string& key, std::string_view pattern, bool is_override) const {
  std::vector<std::string> places;
  for (const Setting& setting : kind_.settings) {
    if (setting.leaf() != key || setting.parent() == pattern) continue;
    std::string place(setting.key);
    for (std::size_t at = place.find("[]"); is_override && at != std::string::npos; at = place.find("[]", at)) {
      place.replace(at, 2, "[0]");
    }
    place = toml_string(place);
    if (std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
  }
  return fmt::format("{}", fmt::join(places, " or "));
}

}  // namespace noiseloom::settings
