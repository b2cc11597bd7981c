#include "noiseloom/files/generations.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <span>
#include <vector>

#include "files/attempt.h"
#include "noiseloom/files/digest.h"
#include "noiseloom/files/run_lock.h"

namespace noiseloom {
namespace {

constexpr std::string_view temporary_infix = ".tmp-";

// Gives the old generation its second name. False where a file can have one name only.
bool keep_by_link(FileOps& ops, const std::string& path) {
  const std::string second = temporary_name(path);
  if (!ops.link(path, second)) return false;
  const auto remove_second = [&] {
    if (ops.exists(second)) ops.remove(second);
  };
  try {
    ops.rename(second, previous_generation(path));
    // Where PATH.prev was PATH already (a run was killed just here), renaming one to the other does nothing at all.
    remove_second();
  } catch (...) {
    attempt(remove_second);
    throw;
  }
  return true;
}

void replace_in_two_renames(FileOps& ops, const std::string& temporary, const std::string& path) {
  const std::string previous = previous_generation(path);
  ops.rename(path, previous);
  try {
    ops.rename(temporary, path);
  } catch (...) {
    attempt([&] { ops.rename(previous, path); });
    throw;
  }
}

std::unique_ptr<RunFileReader> open_previous(const std::string& path, FileOps& ops, const std::string& trouble) {
  const std::string previous = previous_generation(path);
  try {
    return std::make_unique<RunFileReader>(previous, Changed::refused, ops);
  } catch (const UserError& error) {
    throw UserError("", trouble + "\n" + error.what());
  } catch (const EnvironmentError& error) {
    throw EnvironmentError(trouble + "\n" + error.what());
  }
}

// Only what the file says can show that it is damaged. That it cannot be read may pass (a network file system that lost
// its server, no memory left), and then the generation before it would be a loss without need; a disk that stays
// unreadable looks just the same. So it is tried once more, and after that a person decides.
std::unique_ptr<RunFileReader> open_newest(const std::string& path, FileOps& ops, bool has_previous) {
  try {
    return std::make_unique<RunFileReader>(path, Changed::refused, ops);
  } catch (const EnvironmentError&) {
  }
  try {
    return std::make_unique<RunFileReader>(path, Changed::refused, ops);
  } catch (const EnvironmentError& error) {
    if (!has_previous) throw;
    throw EnvironmentError(
        fmt::format("{}\nit may be whole, so {}, the generation before it, does not stand in for it: "
                    "try again; where it stays like this, move it away, and --resume goes on from "
                    "that generation",
                    error.what(), previous_generation(path)));
  }
}

}  // namespace

std::string previous_generation(const std::string& path) { return follow_links(path) + ".prev"; }

std::string temporary_name(const std::string& path) {
  static std::atomic<int> count = 0;
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  const auto now = std::chrono::system_clock::now().time_since_epoch().count();
  const std::string identity = fmt::format("{} {} {} {}", host, ::getpid(), now, count++);
  return follow_links(path) + std::string(temporary_infix) + to_hex(digest_of(std::as_bytes(std::span(identity))));
}

void publish_generation(FileOps& ops, const std::string& temporary, const std::string& path) {
  const std::string target = follow_links(path);
  confirm_output(target);
  if (!ops.exists(target) || keep_by_link(ops, target)) {
    ops.rename(temporary, target);
  } else {
    replace_in_two_renames(ops, temporary, target);
  }
  written_output(target);
  ops.sync_directory(parent_directory(target));
}

void restore_previous_generation(FileOps& ops, const std::string& path) {
  const std::string target = follow_links(path);
  // Damaged files of before stay what they are: the first free name.
  std::string aside = target + ".damaged";
  for (int number = 2; ops.exists(target) && ops.exists(aside); ++number) {
    aside = target + ".damaged" + std::to_string(number);
  }
  if (ops.exists(target)) ops.rename(target, aside);
  ops.rename(previous_generation(target), target);
  written_output(target);
  ops.sync_directory(parent_directory(target));
}

void remove_stale_temporaries(FileOps& ops, const std::string& path) {
  const std::string target = follow_links(path);
  const std::string start = std::filesystem::path(target).filename().string() + std::string(temporary_infix);
  std::vector<std::string> stale;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(parent_directory(target), error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().filename().string().starts_with(start)) stale.push_back(entry->path().string());
  }
  if (error) throw EnvironmentError(parent_directory(target) + ": cannot list the folder: " + error.message());
  for (const std::string& name : stale) ops.remove(name);
}

void refuse_foreign_output(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) return;
  if (error) throw EnvironmentError(path + ": cannot look up: " + error.message());
  if (!std::filesystem::is_regular_file(status)) throw UserError(path, "is not a file; choose another output");
  if (!may_be_run_file(path)) {
    throw UserError(path, "is not a run file of noiseloom, and is not replaced; choose another output");
  }
}

bool only_previous_generation(const std::string& path) {
  FileOps& ops = posix_file_ops();
  const std::string previous = previous_generation(path);
  return !ops.exists(follow_links(path)) && ops.exists(previous) && looks_like_run_file(previous);
}

std::string previous_generation_note(const std::string& path) {
  const std::string previous = previous_generation(path);
  if (!looks_like_run_file(previous)) return "";
  return fmt::format("; {}, the generation before it, is there (generate --resume goes on from it)", previous);
}

RunFileReader open_to_look_at(const std::string& path) {
  try {
    return RunFileReader(path, Changed::accepted);
  } catch (const UserError& error) {
    std::error_code ignored;
    const bool is_damaged = dynamic_cast<const DamagedRunFile*>(&error) != nullptr;
    if (!is_damaged && std::filesystem::exists(path, ignored)) throw;
    std::vector<Fault> faults = error.faults();
    faults.back().text += previous_generation_note(path);
    throw UserError(std::move(faults));
  }
}

NewestGeneration open_newest_generation(const std::string& path, FileOps& ops) {
  const bool has_previous = ops.exists(previous_generation(path));
  NewestGeneration newest;
  if (ops.exists(follow_links(path))) {
    try {
      newest.reader = open_newest(path, ops, has_previous);
      return newest;
    } catch (const DamagedRunFile& damage) {
      if (!has_previous) throw;
      newest.trouble = damage.what();
    }
  } else {
    if (!has_previous) return newest;
    newest.trouble = path + ": missing";
  }
  newest.reader = open_previous(path, ops, newest.trouble);
  newest.is_previous = true;
  return newest;
}

}  // namespace noiseloom
