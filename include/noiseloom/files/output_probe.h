// Whether an output can be written, tried before hours are spent on what goes into it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/files/run_file.h"

namespace noiseloom {

// The size of a run file with these datasets, rounded up; `other_bytes`: of its config and of what it was made from
// (/inputs). A history of some thousand rows is included.
std::uint64_t run_file_bytes(const Extents& extents, const std::vector<SliceDataset>& datasets,
                             std::uint64_t other_bytes);

// What a run needs on disk when it needs most: at a save there are the new file, PATH and PATH.prev.
std::uint64_t bytes_needed(std::uint64_t file_bytes);

// Tries all that a save will do: makes a file beside `path`, writes, syncs, names and renames it; looks at what
// PATH.prev is, at limits of file sizes and at the free space for files of `file_bytes`. Changes nothing that is there.
// Call it with the lock held, after remove_stale_temporaries. Returns warnings. Throws UserError for what another
// output would mend (a name too long, a folder or somebody else's file in the way), EnvironmentError for what the
// system refuses.
std::vector<std::string> probe_output(const std::string& path, std::uint64_t file_bytes);

}  // namespace noiseloom
