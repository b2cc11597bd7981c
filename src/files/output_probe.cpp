#include "noiseloom/files/output_probe.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <optional>
#include <system_error>

#include "noiseloom/files/generations.h"

namespace noiseloom {
namespace {

std::string bytes_text(std::uint64_t bytes) {
  constexpr std::uint64_t mib = std::uint64_t{1} << 20;
  return bytes < mib ? fmt::format("{:.0f} KiB", static_cast<double>(bytes) / 1024)
                     : fmt::format("{:.1f} MiB", static_cast<double>(bytes) / static_cast<double>(mib));
}

std::optional<struct stat> status_of(const std::string& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) == 0) return status;
  if (errno == ENOENT || errno == ENOTDIR) return std::nullopt;
  if (errno == ENAMETOOLONG) throw UserError(path, "this name is too long; choose a shorter one for the output");
  throw EnvironmentError(path + ": cannot look up: " + std::system_category().message(errno));
}

// Of each name that a run uses beside the output.
void check_names(const std::string& target) {
  const std::string longest = temporary_name(target);
  const std::string name = longest.substr(longest.rfind('/') + 1);
  const std::string folder = parent_directory(target);
  const long most = ::pathconf(folder.c_str(), _PC_NAME_MAX);
  const auto spare = longest.size() - target.size();
  if (most > 0 && name.size() > static_cast<std::size_t>(most)) {
    throw UserError(target, fmt::format("the name is too long: {} characters here, and temporary files need {} more of "
                                        "the {} that this file system allows; choose a shorter one",
                                        name.size() - spare, spare, most));
  }
  if (longest.size() >= PATH_MAX) {
    throw UserError(target,
                    fmt::format("the path is too long: with temporary files it has {} of at most {} characters; "
                                "go to the folder and give a shorter one",
                                longest.size(), PATH_MAX - 1));
  }
}

// PATH.prev is replaced at a save: it must be a generation of a run file, if it is there.
void check_previous(const std::string& target) {
  const std::string previous = previous_generation(target);
  const std::optional<struct stat> status = status_of(previous);
  if (!status) return;
  if (S_ISDIR(status->st_mode)) {
    throw UserError(previous,
                    "is a folder, but each save puts the generation before it there; move it away or choose "
                    "another output");
  }
  if (S_ISREG(status->st_mode) && may_be_run_file(previous)) return;
  throw UserError(previous,
                  "is not a run file of noiseloom, but each save puts the generation before it there; move it "
                  "away or choose another output");
}

// In a folder with the sticky bit (/tmp) nobody may rename or replace the files of others.
void check_owners(const std::string& target) {
  const std::optional<struct stat> folder = status_of(parent_directory(target) + "/.");
  const uid_t user = ::geteuid();
  if (!folder || (folder->st_mode & S_ISVTX) == 0 || user == 0 || folder->st_uid == user) return;
  for (const std::string& path : {target, previous_generation(target)}) {
    const std::optional<struct stat> status = status_of(path);
    if (status && status->st_uid != user) {
      throw UserError(path,
                      "belongs to another user, and in this folder (sticky bit) only the owner may replace it; "
                      "choose another output");
    }
  }
}

// Returns false where a file can have one name only.
bool try_operations(const std::string& target) {
  FileOps& ops = posix_file_ops();
  const std::string first = temporary_name(target);
  const std::string second = temporary_name(target);
  const std::vector<std::byte> bytes(4096);
  const int fd = ops.create(first);
  bool links = true;
  try {
    try {
      ops.write(fd, 0, bytes);
      ops.sync(fd);
    } catch (...) {
      ops.close(fd);
      throw;
    }
    ops.close(fd);
    links = ops.link(first, second);
    ops.rename(first, second);
    if (ops.exists(first)) ops.remove(first);
    ops.sync_directory(parent_directory(target));
    ops.remove(second);
  } catch (...) {
    ::unlink(first.c_str());
    ::unlink(second.c_str());
    throw;
  }
  return links;
}

std::uint64_t bytes_of(const std::string& path) {
  const std::optional<struct stat> status = status_of(path);
  return status && S_ISREG(status->st_mode) ? static_cast<std::uint64_t>(status->st_blocks) * 512 : 0;
}

void check_file_size_limit(const std::string& target, std::uint64_t file_bytes) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur >= file_bytes) return;
  throw EnvironmentError(fmt::format("{}: will have {}, but files may have {} at most (ulimit -f)", target,
                                     bytes_text(file_bytes), bytes_text(limit.rlim_cur)));
}

// A warning, or "".
std::string check_space(const std::string& target, std::uint64_t file_bytes) {
  struct statvfs disk {};
  if (::statvfs(parent_directory(target).c_str(), &disk) != 0) return "";
  const std::uint64_t free = std::uint64_t{disk.f_bavail} * disk.f_frsize;
  const std::uint64_t there = bytes_of(target) + bytes_of(previous_generation(target));
  const std::uint64_t all = bytes_needed(file_bytes);
  const std::uint64_t more = all > there ? all - there : 0;
  if (free < file_bytes) {
    throw EnvironmentError(fmt::format("{}: no space for it: the file will have {}, {} are free", target,
                                       bytes_text(file_bytes), bytes_text(free)));
  }
  if (free >= more) return "";
  return fmt::format(
      "{}: a save needs up to {} more (the new file beside the two generations before it), {} are free; "
      "later saves may fail",
      target, bytes_text(more), bytes_text(free));
}

}  // namespace

std::uint64_t run_file_bytes(const Extents& extents, const std::vector<SliceDataset>& datasets,
                             std::uint64_t other_bytes) {
  constexpr std::uint64_t structure = std::uint64_t{1} << 16;
  constexpr std::uint64_t history = std::uint64_t{1} << 18;
  const auto slices = narrow<std::uint64_t>(extents.num_slices());
  std::uint64_t bytes = structure + history + other_bytes;
  for (const SliceDataset& dataset : datasets) {
    bytes += slices * (bytes_per_slice(dataset, extents) + sizeof(std::uint64_t)) + 2048;
  }
  return bytes;
}

std::uint64_t bytes_needed(std::uint64_t file_bytes) { return 3 * file_bytes; }

std::vector<std::string> probe_output(const std::string& path, std::uint64_t file_bytes) {
  const std::string target = follow_links(path);
  check_names(target);
  if (const auto status = status_of(target); status && S_ISDIR(status->st_mode)) {
    throw UserError(target, "is a folder; choose another output");
  }
  check_previous(target);
  check_owners(target);
  check_file_size_limit(target, file_bytes);
  std::vector<std::string> warnings;
  if (!try_operations(target)) {
    warnings.push_back(target +
                       ": files have one name only on this file system: at each save the output is missing for "
                       "some milliseconds (a reader may try again; a run that is killed then goes on from " +
                       previous_generation(target) + ")");
  }
  if (const std::string warning = check_space(target, file_bytes); !warning.empty()) warnings.push_back(warning);
  return warnings;
}

}  // namespace noiseloom
