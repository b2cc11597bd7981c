// Between a run of void and cluster and its run file.
//
// /order (files/order_codec.h) holds the place of every pixel, or while it has none, whether it is on. /samples follows
// from it (construct/order_samples.h): final where the pixel has a place, NaN where it has none. With /state this is
// all that a run is. /history has a row at every quarter of as many swaps as there are points, at the end of each
// phase, and at every sixteenth of the places: at the same counts however the run is divided into steps, parts, ranks
// and threads.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/construct/void_and_cluster.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/files/order_codec.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

const char* vac_phase_name(VacPhase phase);  // "swap", "drain", "fill", "done"

struct OrderRow {
  double phase = 0;   // as in VacPhase
  double swaps = 0;   // done so far
  double placed = 0;  // pixels that have a place
  double seconds = 0;
};

struct OrderState {
  std::string phase;  // vac_phase_name
  std::int64_t start_points = 0;
  std::int64_t swaps = 0;
  std::int64_t placed = 0;
  std::string finished;  // "order" when every pixel has its place
  std::vector<OrderRow> history;
};

// Adds the rows that fall between two moments of a run of `num_pixels` pixels.
void add_order_rows(const VacProgress& before, const VacProgress& after, std::int64_t num_pixels, double seconds,
                    std::vector<OrderRow>& history);

// Its /state and /history, once all of it that is no slice has been found sound by the file's own config. Throws
// UserError, naming `path`, for what no such run can have.
OrderState order_state(const RunFileContent& content, const std::string& path);
// Throws UserError if /order does not hold exactly the pixels that `state` (order_state) counts.
void check_order(const RunFileReader& file, const OrderState& state);

// What save_order_run writes.
std::vector<SliceDataset> order_run_datasets(const RunConfig& config);

// Publishes the present state at `path`, like save_run. *Collective*
std::string save_order_run(FileOps& ops, const std::string& path, const RunConfig& config, const VoidAndCluster& run,
                           const std::vector<OrderRow>& history, const Communicator& communicator,
                           const std::map<std::string, Attribute>& provenance);

// Brings `run` to the state of a run file, which rank 0 has opened (nullptr elsewhere), and returns its history on
// every rank. Throws UserError on every rank if the file's contents make no sense (order_state, check_order), or belong
// to another algorithm and the run is not finished. *Collective*
std::vector<OrderRow> restore_order_run(const RunFileReader* file, const RunConfig& config, VoidAndCluster& run,
                                        const Communicator& communicator);

}  // namespace noiseloom
