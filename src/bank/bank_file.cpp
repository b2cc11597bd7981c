// The file that describes a bank, and the members that follow from it.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include "noiseloom/bank/bank.h"
#include "noiseloom/config/config.h"
#include "noiseloom/config/settings_file.h"
#include "noiseloom/config/settings_writer.h"
#include "noiseloom/core/error.h"
#include "noiseloom/files/digest.h"

namespace noiseloom {
namespace {

using settings::Array;
using settings::Condition;
using settings::CustomType;
using settings::Entry;
using settings::Field;
using settings::FileKind;
using settings::Found;
using settings::Owners;
using settings::Place;
using settings::Reader;
using settings::Setting;
using settings::Type;
using settings::Value;
using settings::Word;

constexpr std::size_t most_members = 100'000;

struct VariedSetting {
  std::string key;
  std::vector<std::string> values;  // TOML
  Place place;
  std::string shown;
  std::optional<Place> repeated = {};  // a value that stood in the list before
};

enum class MemberPairs { all, side_by_side };

struct BankFile {
  std::string base;
  MemberPairs combine = MemberPairs::all;
  std::vector<VariedSetting> vary;
};

constexpr Word combine_words[] = {
    {"all", "every combination of the values", "product grid matrix"},
    {"side-by-side", "the first value of every list, then the second of every list", "zip parallel"}};

// "1:1000" as numbers.
std::optional<std::vector<std::string>> range_of(const std::string& text) {
  std::int64_t first = 0;
  std::int64_t last = 0;
  const char* const end = text.data() + text.size();
  const auto begun = std::from_chars(text.data(), end, first);
  if (begun.ec != std::errc() || begun.ptr == end || *begun.ptr != ':') return std::nullopt;
  const auto done = std::from_chars(begun.ptr + 1, end, last);
  if (done.ec != std::errc() || done.ptr != end || last < first) return std::nullopt;
  if (static_cast<std::uint64_t>(last) - static_cast<std::uint64_t>(first) >= most_members) return std::nullopt;
  std::vector<std::string> values;
  for (std::int64_t value = first; value <= last; ++value) values.push_back(std::to_string(value));
  return values;
}

constexpr const char* accepted_values =
    "must be a list of different values, such as [0.7, 1.0], or a range of at most 100000 integers, such as \"1:12\"";

void read_varied(Reader& reader, const Found& found, const std::string& key, const Entry& entry) {
  if (const settings::Table* table = entry.value.table()) {
    for (const Entry& below : *table) read_varied(reader, found, fmt::format("{}.{}", key, below.key), below);
    return;
  }
  const std::string shown = fmt::format("{}.{}", found.shown, settings::toml_key(key));
  VariedSetting varied{.key = key, .values = {}, .place = entry.place, .shown = shown};
  const std::vector<VariedSetting>& before = found.owners.get<BankFile>().vary;
  if (std::any_of(before.begin(), before.end(), [&](const VariedSetting& other) { return other.key == key; })) {
    return reader.fault(entry.value, shown, "is varied twice");
  }
  if (const std::string* text = entry.value.text()) {
    const auto range = range_of(*text);
    if (!range) return reader.fault(entry.value, shown, accepted_values);
    varied.values = *range;
  } else if (const Array* list = entry.value.array(); list != nullptr && !list->empty()) {
    std::set<std::string> seen;
    for (const Value& value : *list) {
      varied.values.push_back(settings::to_text(value));
      if (!seen.insert(varied.values.back()).second && !varied.repeated) varied.repeated = value.place;
    }
  } else {
    return reader.fault(entry.value, shown, accepted_values);
  }
  found.owners.get<BankFile>().vary.push_back(std::move(varied));
}

void read_vary(Reader& reader, const Found& found) {
  const settings::Table* table = found.value.table();
  if (table == nullptr || table->empty()) {
    return reader.fault(found.value, found.shown, "must be " + found.setting.accepted());
  }
  for (const Entry& entry : *table) read_varied(reader, found, entry.key, entry);
}

const CustomType vary_type = {
    .accepted = [](const Setting&) -> std::string {
      return "a table of settings of the base, each with a list of values or a range, such as \"texture.seed\" = "
             "\"1:12\"";
    },
    .read = read_vary,
    .text = [](const settings::Writer&, const Setting&, const Owners&) -> std::string { return ""; }};

// In every combination a value once more makes the same members once more; side by side only where all others repeat
// too.
void check_repeats(Reader& reader, const BankFile& file) {
  if (file.combine == MemberPairs::all) {
    for (const VariedSetting& varied : file.vary) {
      if (varied.repeated)
        reader.fault(*varied.repeated,
                     fmt::format("{}: a value stands twice in the list; {}", varied.shown, accepted_values));
    }
    return;
  }
  std::map<std::vector<std::string>, std::size_t> seen;
  for (std::size_t i = 0; i < file.vary.front().values.size(); ++i) {
    std::vector<std::string> member;
    for (const VariedSetting& varied : file.vary) {
      if (i < varied.values.size()) member.push_back(varied.values[i]);
    }
    if (const auto [earlier, is_new] = seen.emplace(std::move(member), i); !is_new) {
      reader.fault(file.vary.front().place, fmt::format("vary: values {} and {} of all lists are the same: a member "
                                                        "stands twice",
                                                        earlier->second + 1, i + 1));
      return;
    }
  }
}

void check_bank(Reader& reader, const Value&, const Owners& owners) {
  const BankFile& file = owners.get<BankFile>();
  if (file.vary.empty()) return;
  check_repeats(reader, file);
  std::size_t count = 1;
  for (const VariedSetting& varied : file.vary) {
    if (file.combine == MemberPairs::side_by_side && varied.values.size() != file.vary.front().values.size()) {
      reader.fault(varied.place, fmt::format("vary.{}: has {} values, and {} has {}: side by side all lists must have "
                                             "the same number",
                                             settings::toml_key(varied.key), varied.values.size(),
                                             file.vary.front().key, file.vary.front().values.size()));
    }
    count = file.combine == MemberPairs::all ? std::min(most_members + 1, count * varied.values.size()) : count;
  }
  if (count > most_members) {
    reader.fault(file.vary.back().place,
                 fmt::format("vary: more than {} members; at most so many fit into one bank", most_members));
  }
}

const FileKind& bank_kind() {
  static const Setting rows[] = {
      {.key = "base",
       .type = Type::file,
       .sentence = "The config that all members share, but for what varies.",
       .field = [](BankFile& b) -> Field { return &b.base; },
       .required = true},
      {.key = "combine",
       .type = Type::word,
       .sentence = "How the values of several settings go together.",
       .field = [](BankFile& b) -> Field { return &b.combine; },
       .words = combine_words},
      {.key = "vary",
       .type = Type::custom,
       .sentence = "What differs from member to member: settings of the base by their dotted keys in quotes.",
       .required = true,
       .custom = &vary_type},
  };
  static const FileKind kind = settings::file_kind<BankFile>(
      {.noun = "bank", .settings = rows, .check = check_bank, .override_example = "combine=all"});
  return kind;
}

// Of the dotted key, what is enough to tell it from the others.
std::string label_of(const std::string& key, const std::vector<VariedSetting>& all) {
  const std::string leaf = key.substr(key.rfind('.') + 1);
  const auto same = std::count_if(all.begin(), all.end(), [&](const VariedSetting& other) {
    return other.key.substr(other.key.rfind('.') + 1) == leaf;
  });
  std::string label;
  for (const char c : same == 1 ? leaf : key) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_') label += c;
  }
  return label;
}

// A value as a part of a file name: itself where it is short and plain, else its number in the list.
std::string value_label(const std::string& value, std::size_t number) {
  constexpr std::size_t longest = 24;
  std::string plain = value;
  if (plain.size() > 2 && plain.front() == '"' && plain.back() == '"') plain = plain.substr(1, plain.size() - 2);
  const bool fits = plain.size() <= longest && std::all_of(plain.begin(), plain.end(), [](char c) {
                      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '_';
                    });
  return fits ? plain : fmt::format("-{}", number + 1);
}

// Which value of each list the member takes.
std::vector<std::vector<std::size_t>> choices(const BankFile& file) {
  std::vector<std::vector<std::size_t>> all;
  if (file.combine == MemberPairs::side_by_side) {
    for (std::size_t i = 0; i < file.vary.front().values.size(); ++i) all.emplace_back(file.vary.size(), i);
    return all;
  }
  std::vector<std::size_t> choice(file.vary.size(), 0);
  for (;;) {  // the last setting varies fastest
    all.push_back(choice);
    std::size_t k = choice.size();
    while (k > 0 && ++choice[k - 1] == file.vary[k - 1].values.size()) choice[--k] = 0;
    if (k == 0) return all;
  }
}

std::vector<BankMember> members_of(const BankFile& file, const std::vector<std::string>& overrides) {
  std::vector<BankMember> members;
  for (const std::vector<std::size_t>& choice : choices(file)) {
    BankMember& member = members.emplace_back();
    member.overrides = overrides;
    for (std::size_t k = 0; k < choice.size(); ++k) {
      const VariedSetting& varied = file.vary[k];
      const std::string& value = varied.values[choice[k]];
      member.values.push_back(value);
      member.overrides.push_back(fmt::format("{}={}", varied.key, value));
      member.name += fmt::format("{}{}{}", member.name.empty() ? "" : "_", label_of(varied.key, file.vary),
                                 value_label(value, choice[k]));
    }
  }
  return members;
}

}  // namespace

Bank load_bank(const std::string& path, const std::vector<std::string>& overrides) {
  const auto parsed = settings::parse<BankFile>(bank_kind(), settings::load_source(path, bank_kind().noun), {});
  const BankFile& file = parsed.value;
  Bank bank{.base = file.base, .keys = {}, .members = members_of(file, overrides)};
  std::map<std::string, Place> places;  // of what varies, by what faults call it
  for (const VariedSetting& varied : file.vary) {
    bank.keys.push_back(varied.key);
    for (const std::string& value : varied.values) places[fmt::format("--set {}={}", varied.key, value)] = varied.place;
  }
  std::vector<Fault> faults;
  std::set<std::string> told;
  std::set<std::string> names;
  for (BankMember& member : bank.members) {
    const std::string name = member.name;
    for (std::size_t number = names.size(); !names.insert(member.name).second; ++number) {
      member.name = fmt::format("{}_{}", name, number);
    }
    try {
      const std::string text = to_toml(load_config(bank.base, member.overrides));
      member.config = to_hex(digest_of(std::as_bytes(std::span(text))));
    } catch (const UserError& error) {
      for (Fault fault : error.faults()) {
        if (const auto place = places.find(fault.where); place != places.end()) fault.where = place->second.to_string();
        if (told.insert(fault.where + fault.text).second) faults.push_back(fault);
      }
    }
  }
  throw_if_any(std::move(faults));
  return bank;
}

std::string describe_bank_settings() { return settings::describe(bank_kind()); }

}  // namespace noiseloom
