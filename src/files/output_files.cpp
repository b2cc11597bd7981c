#include "noiseloom/files/output_files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <system_error>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace fs = std::filesystem;
namespace {

// Creates a folder and those above it; the ones that were missing are appended, outermost first.
void create_folders(const fs::path& folder, std::vector<std::string>& created) {
  std::error_code error;
  if (fs::is_directory(folder, error)) return;
  if (fs::exists(folder, error)) throw UserError(folder.string(), "exists and is not a folder");
  if (folder.has_parent_path() && folder.parent_path() != folder) create_folders(folder.parent_path(), created);
  if (!fs::create_directory(folder, error) && error)
    throw EnvironmentError(fmt::format("{}: cannot create the folder: {}", folder.string(), error.message()));
  created.push_back(folder.string());
}

}  // namespace

OutputStream::~OutputStream() {
  if (!file_) return;
  try {
    ops_.close(*file_);
  } catch (const EnvironmentError&) {  // the first failure is the one to tell
  }
}

void OutputStream::append(std::span<const std::byte> bytes) {
  ops_.write(*file_, size_, bytes);
  size_ += bytes.size();
}

void OutputStream::close() {
  const int file = *file_;
  file_.reset();
  ops_.close(file);
}

OutputFiles::~OutputFiles() {
  std::error_code ignored;  // nothing more can be done about a file that will not go
  for (const File& file : files_) fs::remove(file.temporary, ignored);
  for (auto folder = new_folders_.rbegin(); folder != new_folders_.rend(); ++folder) fs::remove(*folder, ignored);
}

void OutputFiles::check(const std::vector<std::string>& targets) const {
  std::vector<Fault> faults;
  std::vector<std::string> existing;
  std::error_code error;
  for (const std::string& target : targets) {
    if (fs::is_directory(target, error))
      faults.push_back({target, "is a folder"});
    else if (!overwrite_ && fs::exists(target, error))
      existing.push_back(target);
  }
  if (existing.size() == 1) faults.push_back({existing.front(), "exists; --overwrite replaces it"});
  if (existing.size() > 1)
    faults.push_back(
        {existing.front(), fmt::format("exists, and {} more of the {} files to write; --overwrite replaces "
                                       "them",
                                       existing.size() - 1, targets.size())});
  throw_if_any(std::move(faults));
}

std::vector<std::string> OutputFiles::targets() const {
  std::vector<std::string> targets;
  for (const File& file : files_) targets.push_back(file.target);
  return targets;
}

std::string OutputFiles::add(const std::string& target) {
  NOISELOOM_CHECK(std::none_of(files_.begin(), files_.end(), [&](const File& file) { return file.target == target; }));
  check({target});
  const std::string place = follow_links(target);
  for (const File& file : files_) {
    if (file.place == place)
      throw UserError(target, fmt::format("leads to {}, as {} does, which is written too", place, file.target));
  }
  create_folders(parent_directory(place), new_folders_);
  // The ending is the target's own: what writes an image chooses the container by it.
  const fs::path temporary =
      fs::path(parent_directory(place)) / fmt::format(".{}.partial-{}-{}{}", fs::path(place).stem().string(),
                                                      ::getpid(), files_.size(), fs::path(target).extension().string());
  std::error_code ignored;
  fs::remove(temporary, ignored);  // left by a killed process of the same number
  files_.push_back({temporary.string(), target, place});
  return temporary.string();
}

std::unique_ptr<OutputStream> OutputFiles::open(const std::string& target) {
  return std::make_unique<OutputStream>(ops_, add(target));
}

void OutputFiles::write(const std::string& target, const std::string& text) {
  const std::unique_ptr<OutputStream> stream = open(target);
  stream->append(text);
  stream->close();
}

// Syncs a file that was written and closed, by whatever means.
void OutputFiles::sync(const std::string& path) {
  const int file = ops_.open(path);
  try {
    ops_.sync(file);
  } catch (...) {
    try {
      ops_.close(file);
    } catch (const EnvironmentError&) {  // the first failure is the one to tell
    }
    throw;
  }
  ops_.close(file);
}

void OutputFiles::commit() {
  std::set<std::string> folders;
  for (const File& file : files_) {
    sync(file.temporary);
    folders.insert(parent_directory(file.place));
  }
  for (const File& file : files_) ops_.rename(file.temporary, file.place);
  for (const std::string& folder : folders) ops_.sync_directory(folder);
  files_.clear();
  new_folders_.clear();
}

}  // namespace noiseloom
