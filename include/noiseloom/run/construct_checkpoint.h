// Between a run of construction and its run file.
//
// /state/permutation holds, for every pixel, its place in its slice, which is also the id of its sample; while it has
// none, whether it is on (construct/slice_construction.h). /samples follows from it: final where the pixel has a place,
// NaN where it has none. With /state this is all that a run is. /history has a row at the end of each phase, and at
// every sixteenth of the places: at the same counts however the run is divided into parts, ranks and threads.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/construct/slice_construction.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

const char* construct_phase_name(ConstructPhase phase);  // "spread", "relax", ...

struct ConstructRow {
  double phase = 0;   // as in ConstructPhase
  double swaps = 0;   // done so far, in all slices
  double ranked = 0;  // pixels that have a place, in all slices
  double seconds = 0;
};

struct ConstructState {
  std::string phase;              // construct_phase_name
  std::int64_t start_points = 0;  // of a slice
  std::int64_t rounds = 0;        // of the phase
  std::int64_t swaps = 0;
  std::int64_t ranked = 0;
  double sharpness = 0;       // that the overlap is raised to
  double mean_distance = 0;   // of all samples; 0 until the end
  double relative_error = 0;  // R; 0 until the end
  std::string finished;       // "construction" when every pixel has its place
  std::vector<ConstructRow> history;
};

// Whether a run file is of this method.
bool is_construct_run(const RunFileContent& content);

// The state of a run with that progress and history.
ConstructState construct_state_of(const ConstructProgress& progress, std::int32_t num_slices, double sharpness,
                                  std::vector<ConstructRow> history);

// Adds the rows that fall between two moments of a run.
void add_construct_rows(const ConstructProgress& before, const ConstructProgress& after, const Extents& extents,
                        double seconds, std::vector<ConstructRow>& history);

// Its /state and /history, once all of it that is no slice has been found sound by the file's own config. Throws
// UserError, naming `path`, for what no such run can have.
ConstructState construct_state(const RunFileContent& content, const std::string& path);
// Throws UserError if a slice of /state/permutation is not what `state` (construct_state) says.
void check_places(const RunFileReader& file, const ConstructState& state);

// Publishes the present state at `path`, like save_run. *Collective*
std::string save_construct_run(FileOps& ops, const std::string& path, const RunConfig& config,
                               const SampleSource& source, const SliceConstruction& run, const ConstructState& state,
                               const Communicator& communicator, const std::map<std::string, Attribute>& provenance);

// Brings `run` to the state of a run file, which rank 0 has opened (nullptr elsewhere); the state, on every rank.
// Throws UserError on every rank if the file's contents make no sense (construct_state, check_places), or belong to
// another algorithm and the run is not finished. *Collective*
ConstructState restore_construct_run(const RunFileReader* file, const RunConfig& config, const SampleSource& source,
                                     SliceConstruction& run, const Communicator& communicator);

// The samples of a slice whose pixels have these places, [cell][channel]; NaN where there is none. `list`: the samples
// of the slice in the order of places, [place][channel].
std::vector<float> samples_of_places(const std::vector<std::uint32_t>& places, const std::vector<float>& list,
                                     int channels);

}  // namespace noiseloom
