#include "run/bank_index.h"

#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "noiseloom/core/error.h"
#include "noiseloom/core/json.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/output_files.h"

namespace noiseloom {
namespace fs = std::filesystem;
namespace {

constexpr const char* fixed_columns = "name,state,relative_error,seconds,checksum,config";
constexpr std::size_t num_fixed = 6;

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

// The fields of one line; lines of an index have no line breaks within quotes, as TOML on one line has none.
std::vector<std::string> csv_fields(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += line[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

std::string header_of(const Bank& bank) {
  std::string header = fixed_columns;
  for (const std::string& key : bank.keys) header += fmt::format(",{}", csv_field(key));
  return header;
}

double number_of(const std::string& text) {
  double value = std::numeric_limits<double>::quiet_NaN();
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::string number_text(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

std::string csv_of(const Bank& bank, const std::vector<std::pair<std::string, IndexRow>>& rows) {
  std::string text = header_of(bank) + '\n';
  for (const auto& [name, row] : rows) {
    text += fmt::format("{},{},{},{},{},{}", csv_field(name), row.state, number_text(row.relative_error),
                        number_text(row.seconds), row.checksum, row.config);
    for (const std::string& value : row.values) text += fmt::format(",{}", csv_field(value));
    text += '\n';
  }
  return text;
}

std::string json_of(const Bank& bank, const std::vector<std::pair<std::string, IndexRow>>& rows) {
  std::string text = "[\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const IndexRow& row = rows[i].second;
    std::vector<JsonMember> members = {{"name", rows[i].first},  {"file", fmt::format("{}.h5", rows[i].first)},
                                       {"state", row.state},     {"relative_error", row.relative_error},
                                       {"seconds", row.seconds}, {"checksum", row.checksum},
                                       {"config", row.config}};
    for (std::size_t k = 0; k < row.values.size() && k < bank.keys.size(); ++k) {
      members.emplace_back(bank.keys[k], row.values[k]);
    }
    text += json_object(members) + (i + 1 < rows.size() ? ",\n" : "\n");
  }
  return text + "]\n";
}

// What killed writers of the index left. Under its lock, so that nobody is at it.
void remove_partial_indexes(const std::string& folder) {
  std::vector<fs::path> left;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().filename().string().starts_with(".index.partial-")) left.push_back(entry->path());
  }
  for (const fs::path& path : left) fs::remove(path, error);
}

}  // namespace

std::string index_path(const std::string& folder) { return (fs::path(folder) / "index.csv").string(); }

std::string member_path(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / fmt::format("{}.h5", name)).string();
}

std::unique_ptr<RunLock> lock_index(const std::string& path) {
  constexpr std::chrono::seconds longest{120};
  constexpr std::chrono::milliseconds pause{10};
  const auto end = std::chrono::steady_clock::now() + longest;
  for (;;) {
    try {
      return std::make_unique<RunLock>(path);
    } catch (const OutputHeld& held) {
      if (std::chrono::steady_clock::now() >= end) throw EnvironmentError(held.what());
    }
    std::this_thread::sleep_for(pause);
  }
}

BankIndex read_index(const Bank& bank, const std::string& folder) {
  BankIndex index;
  const std::string path = index_path(folder);
  std::ifstream file(path);
  std::string line;
  if (!file || !std::getline(file, line)) return index;
  if (line != header_of(bank)) {
    throw UserError(path + ":1",
                    fmt::format("is no index of this bank, whose columns are {}; choose another folder, or "
                                "--overwrite",
                                header_of(bank)));
  }
  while (std::getline(file, line)) {
    const std::vector<std::string> fields = csv_fields(line);
    if (fields.size() != num_fixed + bank.keys.size()) continue;  // of no program of ours: made again
    index[fields[0]] = {.state = fields[1],
                        .relative_error = number_of(fields[2]),
                        .seconds = number_of(fields[3]),
                        .checksum = fields[4],
                        .config = fields[5],
                        .values = {fields.begin() + num_fixed, fields.end()}};
  }
  return index;
}

bool is_done(const BankIndex& index, const BankMember& member) {
  const auto found = index.find(member.name);
  return found != index.end() && found->second.state == "done" && found->second.config == member.config;
}

bool update_index(const Bank& bank, const std::string& folder, const std::string& name, const IndexRow& row) {
  const std::string path = index_path(folder);
  const std::unique_ptr<RunLock> lock = lock_index(path);
  remove_partial_indexes(folder);
  BankIndex index = read_index(bank, folder);
  const auto known_before = index.find(name);
  const bool is_news =
      known_before == index.end() || known_before->second.state != "done" || known_before->second.config != row.config;
  if (!name.empty()) index[name] = row;
  std::vector<std::pair<std::string, IndexRow>> rows;
  for (const BankMember& member : bank.members) {
    IndexRow known{.config = member.config, .values = member.values};
    const bool done = is_done(index, member) && fs::exists(member_path(folder, member.name));
    if (done) known = index[member.name];
    if (!done && fs::exists(member_path(folder, member.name))) known.state = "begun";
    rows.emplace_back(member.name, known);
    index.erase(member.name);
  }
  for (const auto& [other, known] : index) rows.emplace_back(other, known);  // of this folder, not of this bank
  OutputFiles files(posix_file_ops(), true);
  files.write(path, csv_of(bank, rows));
  files.write((fs::path(folder) / "index.json").string(), json_of(bank, rows));
  files.commit();
  return is_news;
}

IndexRow row_of(const BankMember& member, const std::string& folder) {
  const RunFileReader reader = open_to_look_at(member_path(folder, member.name));
  const RunFileContent& content = reader.content();
  IndexRow row{.state = "done", .config = member.config, .values = member.values};
  if (const auto found = content.state.find("relative_error"); found != content.state.end()) {
    if (const auto* value = std::get_if<double>(&found->second)) row.relative_error = *value;
  }
  if (const auto found = content.provenance.find("seconds_total"); found != content.provenance.end()) {
    if (const auto* value = std::get_if<double>(&found->second)) row.seconds = *value;
  }
  if (const auto found = content.checksums.find("/samples"); found != content.checksums.end()) {
    row.checksum = found->second;
  }
  return row;
}

}  // namespace noiseloom
