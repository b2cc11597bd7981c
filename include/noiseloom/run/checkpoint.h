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

// What save_run writes; `has_given`: of a run that begins with a given arrangement.
std::vector<SliceDataset> run_datasets(const SampleSource& source, bool has_given = false);

// The number of the algorithm (anneal/swap_optimizer.h, construct/void_and_cluster.h) of the program that wrote a run
// file; 1 for files from before there were such numbers. Throws UserError, naming `path`, for what is no such number.
std::int64_t stored_algorithm(const RunFileContent& content, const std::string& path);

// Publishes the present state at `path`, with the contents of the files that the config names; rank 0 writes, slices
// stream to it. Returns the combined checksum of /samples on rank 0. On failure every rank throws EnvironmentError and
// earlier generations are untouched. *Collective*
std::string save_run(FileOps& ops, const std::string& path, const RunConfig& config, const SampleSource& source,
                     SwapOptimizer& engine, const Communicator& communicator,
                     const std::map<std::string, Attribute>& provenance);

// The part of a run file that save_run wrote into /state and /history, once all of it that is no slice has been found
// sound by the file's own config. Throws UserError, naming `path`, with everything that no run can have.
SwapState engine_state(const RunFileContent& content, const std::string& path);

// Throws UserError if a slice of /state/permutation is no permutation. After engine_state.
void check_permutations(const RunFileReader& file);

// Brings the engine to the state of a run file, which rank 0 has opened (nullptr elsewhere). `config` may differ from
// the file's in its stop rule (run/resume.h): the run is then finished only where that rule ends it. Throws UserError
// on every rank if the file's contents make no sense (engine_state, check_permutations), belong to another algorithm
// and the run is not finished, or hold other samples than the config yields. *Collective*
void restore_run(const RunFileReader* file, const RunConfig& config, SwapOptimizer& engine,
                 const Communicator& communicator);

}  // namespace noiseloom
