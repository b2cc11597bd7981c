// Whether a run may go on from what its run file holds.
//
// It may with the config that it began with, and with another stop rule where that only extends it. The samples of a
// run that is extended must be those of a run that had the new end from its start: so only where nothing before that
// end depended on it.
//   score, improvement   Rounds of 100, 200, 400, ... sweeps are each cooled by themselves, and where they end does not
//                        matter to them: a lower score, or a smaller improvement, just takes more of them.
//   iterations, fast     Every sweep is like the others but for the fraction, which grows once in a hundredth of the
//                        run (schedule.h): so with as long a hundredth, or a fraction that does not grow.
//   iterations, anneal   The temperature falls from the first iteration to the last, so with another last one every
//                        sweep is another. Not extended; to cool the finished texture again would be another algorithm.
//   time                 The temperature follows the clock to the end. Not extended.
// Void and cluster has no stop rule.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/anneal/spec.h"
#include "noiseloom/config/config.h"
#include "noiseloom/core/error.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

// "" where a run that began with `before` may go on with `now`, which differs from it in the stop rule alone; else why
// not, and what to do.
std::string why_not_extended(const OptimizerSpec& before, const OptimizerSpec& now);

// What keeps a run from going on from `saved` with `config`, whose files need not have been read: nothing where it may.
// Files that the config names count only for run files from before these were kept in them (/inputs): then they must be
// there, with the bytes that they had.
std::vector<Fault> resume_faults(const RunFileReader& saved, const RunConfig& config);

}  // namespace noiseloom
