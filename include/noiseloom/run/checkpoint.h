// Between a running engine and its run file: saving at a safe point, and going on from what was saved.
#pragma once

#include <map>
#include <string>

#include "noiseloom/anneal/swap_optimizer.h"
#include "noiseloom/config/config.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

// One digest of the contents of all files that a config names (samples, filter tables), 16 hexadecimal digits; "" if it
// names none. Throws EnvironmentError.
std::string inputs_digest(const RunConfig& config);

// What save_run writes.
std::vector<SliceDataset> run_datasets(const SampleSource& source);

// Publishes the present state at `path`; rank 0 writes, slices stream to it. `inputs`: the inputs_digest. Returns the
// combined checksum of /samples on rank 0. On failure every rank throws EnvironmentError and earlier generations are
// untouched. *Collective*
std::string save_run(FileOps& ops, const std::string& path, const RunConfig& config, const SampleSource& source,
                     SwapOptimizer& engine, const Communicator& communicator, const std::string& inputs,
                     const std::map<std::string, Attribute>& provenance);

// The part of a run file that save_run wrote into /state and /history.
SwapState engine_state(const RunFileContent& content);

// Brings the engine to the state of a run file, which rank 0 has opened (nullptr elsewhere). Throws EnvironmentError on
// every rank if the stored samples are not those that the config yields (a sample file that has changed). *Collective*
void restore_run(const RunFileReader* file, const Extents& extents, SwapOptimizer& engine,
                 const Communicator& communicator);

}  // namespace noiseloom
