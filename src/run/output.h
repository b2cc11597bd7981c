// The place that a run writes to: whether it may, what is there, and who else writes. Rank 0 only.
#pragma once

#include <memory>
#include <string>

#include "noiseloom/files/generations.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/files/run_lock.h"
#include "noiseloom/run/progress.h"

namespace noiseloom {

// Throws UserError where `path` cannot be the name of a run file, or something else stands there. Touches nothing.
void refuse_unfit_output(const std::string& path);

// Throws UserError where a run file, or the generation before one, stands at `path`: neither is replaced unasked.
void refuse_existing_output(const std::string& path);

// Locks the output for this process. Where another process holds it, the error also says what it means if one launcher
// started both; `ranks`: of this run.
std::unique_ptr<RunLock> lock_output(const std::string& path, int ranks, Progress& progress);

// The newest good generation to go on from, if there is one; what happens otherwise, and which one it is, is said.
NewestGeneration open_saved_run(const std::string& path, Progress& progress);

// A sentence for a process that MPI takes for the only one although its launcher started several; empty otherwise.
std::string launcher_mismatch(int ranks);

}  // namespace noiseloom
