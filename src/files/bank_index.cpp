#include "noiseloom/files/bank_index.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <system_error>
#include <thread>

#include "files/descriptor.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/json.h"
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

std::string header_of(const std::vector<std::string>& keys) {
  std::string header = fixed_columns;
  for (const std::string& key : keys) header += fmt::format(",{}", csv_field(key));
  return header;
}

double number_of(const std::string& text) {
  double value = std::numeric_limits<double>::quiet_NaN();
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::string number_text(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

std::string csv_line(const std::string& name, const IndexRow& row) {
  std::string line = fmt::format("{},{},{},{},{},{}", csv_field(name), row.state, number_text(row.relative_error),
                                 number_text(row.seconds), row.checksum, row.config);
  for (const std::string& value : row.values) line += fmt::format(",{}", csv_field(value));
  return line + '\n';
}

std::string json_row(const std::vector<std::string>& keys, const std::string& name, const IndexRow& row) {
  std::vector<JsonMember> members = {{"name", name},           {"file", fmt::format("{}.h5", name)},
                                     {"state", row.state},     {"relative_error", row.relative_error},
                                     {"seconds", row.seconds}, {"checksum", row.checksum},
                                     {"config", row.config}};
  for (std::size_t k = 0; k < row.values.size() && k < keys.size(); ++k) members.emplace_back(keys[k], row.values[k]);
  return json_object(members);
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

[[noreturn]] void index_fails(const std::string& path, const char* doing, int error) {
  throw EnvironmentError(fmt::format("{}: cannot {}: {}", path, doing, std::system_category().message(error)));
}

std::string read_from(int fd, std::uint64_t offset, const std::string& path) {
  constexpr std::size_t chunk = 1 << 16;
  std::string text;
  for (;;) {
    const std::size_t before = text.size();
    text.resize(before + chunk);
    const ssize_t done =
        uninterrupted([&] { return ::pread(fd, text.data() + before, chunk, static_cast<off_t>(offset + before)); });
    if (done < 0) index_fails(path, "read", errno);
    text.resize(before + static_cast<std::size_t>(done));
    if (done == 0) return text;
  }
}

}  // namespace

std::string index_path(const std::string& folder) { return (fs::path(folder) / "index.csv").string(); }

std::string member_path(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / fmt::format("{}.h5", name)).string();
}

std::unique_ptr<RunLock> lock_index(const std::string& folder) {
  constexpr std::chrono::seconds longest{120};
  constexpr std::chrono::milliseconds pause{10};
  const auto end = std::chrono::steady_clock::now() + longest;
  for (;;) {
    try {
      return std::make_unique<RunLock>(index_path(folder));
    } catch (const OutputHeld& held) {
      if (std::chrono::steady_clock::now() >= end) throw EnvironmentError(held.what());
    }
    std::this_thread::sleep_for(pause);
  }
}

// What was read of index.csv. It stays open, so that no other file can have its number.
struct BankIndex::File {
  Descriptor open;
  struct stat status {};
  std::uint64_t read = 0;  // bytes, up to the end of a line
  std::int64_t lines = 0;

  bool is(const struct stat& other) const {
    return status.st_dev == other.st_dev && status.st_ino == other.st_ino &&
           static_cast<std::uint64_t>(other.st_size) >= read;
  }
};

BankIndex::BankIndex(std::string folder, std::vector<std::string> keys, std::vector<Member> members)
    : folder_(std::move(folder)), keys_(std::move(keys)), members_(std::move(members)), done_(members_.size(), false) {
  for (std::size_t i = 0; i < members_.size(); ++i) numbers_[members_[i].name] = i;
  refresh();
}

BankIndex::~BankIndex() = default;
BankIndex::BankIndex(BankIndex&& other) noexcept = default;

void BankIndex::forget() {
  file_.reset();
  rows_.clear();
  std::fill(done_.begin(), done_.end(), false);
  num_done_ = 0;
}

void BankIndex::put(const std::string& name, IndexRow row) {
  if (const auto found = numbers_.find(name); found != numbers_.end()) {
    const std::size_t member = found->second;
    const bool done = row.state == "done" && row.config == members_[member].config;
    num_done_ += static_cast<int>(done) - static_cast<int>(done_[member]);
    done_[member] = done;
  }
  rows_[name] = std::move(row);
}

void BankIndex::read_line(const std::string& line) {
  if (file_->lines++ == 0) {
    if (line == header_of(keys_)) return;
    forget();
    throw UserError(index_path(folder_) + ":1",
                    fmt::format("is no index of this bank, whose columns are {}; choose another folder, or --overwrite",
                                header_of(keys_)));
  }
  std::vector<std::string> fields = csv_fields(line);
  if (fields.size() != num_fixed + keys_.size()) return;  // of no program of ours: made again
  put(fields[0], {.state = fields[1],
                  .relative_error = number_of(fields[2]),
                  .seconds = number_of(fields[3]),
                  .checksum = fields[4],
                  .config = fields[5],
                  .values = {fields.begin() + num_fixed, fields.end()}});
}

void BankIndex::refresh() {
  const std::string path = index_path(folder_);
  Descriptor now = open_or_none(path, O_RDONLY);
  if (now.fd() < 0) {
    if (errno != ENOENT) index_fails(path, "open", errno);
    return forget();
  }
  struct stat status {};
  if (::fstat(now.fd(), &status) != 0) index_fails(path, "look at", errno);
  if (!file_ || !file_->is(status)) {
    forget();
    file_ = std::make_unique<File>();
  }
  file_->open = std::move(now);  // the same file opened anew: only that makes a network file system ask its server
  file_->status = status;
  const std::string text = read_from(file_->open.fd(), file_->read, path);
  std::size_t begin = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', begin)) {
    read_line(text.substr(begin, end - begin));
    begin = end + 1;
  }
  file_->read += begin;
}

const IndexRow* BankIndex::find(const std::string& name) const {
  const auto found = rows_.find(name);
  return found == rows_.end() ? nullptr : &found->second;
}

bool BankIndex::add(std::size_t member, const IndexRow& row) {
  constexpr double share_of_time = 1.0 / 20;
  const std::unique_ptr<RunLock> lock = lock_index(folder_);
  refresh();
  if (is_done(member)) return false;
  const std::string& name = members_[member].name;
  if (file_ && file_->lines > 0 && find(name) == nullptr) {
    append(csv_line(name, row));
  } else {
    put(name, row);
    publish(table(false), true, false);
  }
  refresh();
  if (json_took_s_ <= share_of_time * since_json_.seconds()) publish(table(true), false, true);
  return true;
}

// At the end of what was read: behind it stands at most what a killed writer left of a line.
void BankIndex::append(const std::string& line) {
  const std::string path = index_path(folder_);
  confirm_output(path);
  const Descriptor file = open_or_none(path, O_RDWR);
  if (file.fd() < 0) index_fails(path, "open", errno);
  const auto cut = [&] {
    return uninterrupted([&] { return ::ftruncate(file.fd(), static_cast<off_t>(file_->read)); });
  };
  if (cut() != 0) index_fails(path, "write", errno);
  std::size_t written = 0;
  while (written < line.size()) {
    const ssize_t done = uninterrupted([&] {
      return ::pwrite(file.fd(), line.data() + written, line.size() - written,
                      static_cast<off_t>(file_->read + written));
    });
    if (done <= 0) {
      const int error = errno;
      cut();
      index_fails(path, "write", error);
    }
    written += static_cast<std::size_t>(done);
  }
  if (uninterrupted([&] { return ::fsync(file.fd()); }) != 0) index_fails(path, "sync", errno);
  written_output(path);
}

void BankIndex::write() {
  const std::unique_ptr<RunLock> lock = lock_index(folder_);
  remove_partial_indexes(folder_);
  refresh();
  publish(table(true), true, true);
  refresh();
}

BankIndex::Table BankIndex::table(bool with_open) const {
  Table rows;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const Member& member = members_[i];
    IndexRow row{.config = member.config, .values = member.values};
    const bool there = (done_[i] || with_open) && fs::exists(member_path(folder_, member.name));
    if (there) row.state = "begun";
    if (there && done_[i]) row = rows_.at(member.name);
    if (row.state == "done" || with_open) rows.emplace_back(member.name, row);
  }
  // Of this folder, not of this bank: what is done is kept. What another bank had still to make is not this one's to
  // tell, and would look like work that is left.
  for (const auto& [name, row] : rows_) {
    if (row.state == "done" && !numbers_.contains(name)) rows.emplace_back(name, row);
  }
  return rows;
}

void BankIndex::publish(const Table& rows, bool csv, bool json) {
  const Stopwatch watch;
  OutputFiles files(posix_file_ops(), true);
  if (csv) {
    std::string text = header_of(keys_) + '\n';
    for (const auto& [name, row] : rows) text += csv_line(name, row);
    files.write(index_path(folder_), text);
  }
  if (json) {
    std::string text;
    for (const auto& [name, row] : rows) text += (text.empty() ? "[\n" : ",\n") + json_row(keys_, name, row);
    files.write((fs::path(folder_) / "index.json").string(), (text.empty() ? "[" : text) + "\n]\n");
  }
  files.commit();
  if (!json) return;
  json_took_s_ = watch.seconds();
  since_json_ = Stopwatch();
}

std::vector<DoneMember> done_members(const std::string& folder) {
  const std::string path = index_path(folder);
  const Descriptor file = open_or_none(path, O_RDONLY);
  if (file.fd() < 0) {
    throw UserError(folder, fmt::format("holds no bank: {}: {}", path, std::system_category().message(errno)));
  }
  std::istringstream text(read_from(file.fd(), 0, path));
  std::string line;
  if (!std::getline(text, line) || !line.starts_with(fixed_columns)) {
    throw UserError(path + ":1", fmt::format("is no index of a bank, which begins with {}", fixed_columns));
  }
  const std::vector<std::string> columns = csv_fields(line);
  std::vector<DoneMember> members;
  while (std::getline(text, line) && !text.eof()) {  // a line without an end is what a killed writer left
    const std::vector<std::string> fields = csv_fields(line);
    if (fields.size() != columns.size() || fields[1] != "done") continue;
    DoneMember& member = members.emplace_back(DoneMember{fields[0], fields[4], "", ""});
    for (std::size_t k = num_fixed; k < fields.size(); ++k) {
      if (columns[k] == "texture.seed") {
        member.seed = fields[k];
        continue;
      }
      member.settings += fmt::format("{}{} = {}", member.settings.empty() ? "" : ", ", columns[k], fields[k]);
    }
  }
  return members;
}

}  // namespace noiseloom
