#include "run/output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <filesystem>

#include "noiseloom/config/config.h"
#include "noiseloom/dist/launcher.h"

namespace noiseloom {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds just_now{60};

bool has_run_file_ending(const std::string& path) {
  std::string ending = fs::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".h5" || ending == ".hdf5";
}

// Whether the lock was taken so lately that whoever holds it may have been started together with this process.
bool locked_just_now(const std::string& path) {
  std::error_code error;
  const auto when = fs::last_write_time(path + ".lock", error);
  return !error && fs::file_time_type::clock::now() - when < just_now;
}

constexpr const char* same_interface =
    "the launcher and the MPI library that noiseloom was built with must speak the same process interface (PMI or "
    "PMIx): use that library's own mpirun, or with Slurm srun --mpi=pmix";

}  // namespace

std::string launcher_mismatch(int ranks) {
  const int launched = num_launched_processes();
  if (launched <= ranks) return "";
  return fmt::format("the launcher started {} processes, but MPI sees only {}, so that each works for itself; {}",
                     launched, ranks == 1 ? "this one" : fmt::format("{} of them", ranks), same_interface);
}

void refuse_unfit_output(const std::string& path) {
  if (path.empty()) throw UserError("command line", "-o: the name of the run file is empty");
  std::error_code error;
  if (fs::is_directory(path, error)) throw UserError(path, "is a folder, not a file; choose another output");
  if (error == std::errc::filename_too_long) throw UserError(path, "this name is too long; choose a shorter one");
  if (!has_run_file_ending(path)) {
    throw UserError("command line",
                    fmt::format("-o {}: a run file is HDF5 and its name ends in .h5 or .hdf5; images of it are made by "
                                "noiseloom export",
                                path));
  }
  refuse_foreign_output(path);
}

void refuse_existing_output(const std::string& path) {
  if (fs::exists(path)) {
    throw UserError(path, "exists; go on from it with --resume, or replace it with --overwrite");
  }
  if (only_previous_generation(path)) {
    throw UserError(path, fmt::format("is missing, but {}, the generation before it, is there; go on from that with "
                                      "--resume, or start anew with --overwrite",
                                      previous_generation(path)));
  }
}

std::unique_ptr<RunLock> lock_output(const std::string& path, int ranks, Progress& progress) {
  const bool just_locked = locked_just_now(path);
  try {
    auto lock = std::make_unique<RunLock>(path, [&progress](const std::string& line) { progress.warn(line); });
    if (!lock->enforced()) {
      progress.warn(fmt::format("{}: this file system has no locks; see that no second run writes here", path));
    }
    return lock;
  } catch (const OutputHeld& held) {
    std::string reason = launcher_mismatch(ranks);
    if (reason.empty() && ranks == 1 && just_locked) {
      reason = fmt::format("if one launcher started both processes: {}", same_interface);
    }
    if (reason.empty()) throw;
    std::vector<Fault> faults = held.faults();
    faults.back().text += "; " + reason;
    throw OutputHeld(std::move(faults));
  }
}

NewestGeneration open_saved_run(const std::string& path, Progress& progress) {
  NewestGeneration newest = open_newest_generation(path);
  if (!newest.reader) progress.say(fmt::format("{}: nothing to resume yet; starting afresh", path));
  if (newest.is_previous) {
    progress.warn(
        fmt::format("{}; going on from the generation before it, {}", newest.trouble, previous_generation(path)));
  }
  return newest;
}

}  // namespace noiseloom
