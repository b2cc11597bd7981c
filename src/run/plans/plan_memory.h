// What a rank of a run holds, in bytes. Every figure follows an allocation of the program that grows with the texture,
// the filter or the threads; tests/bench/plan_memory.py holds the sums against the peaks of real runs.
#pragma once

#include "noiseloom/anneal/slice_field.h"
#include "noiseloom/config/config.h"
#include "noiseloom/run/plan.h"
#include "run/plans/plan_filter.h"

namespace noiseloom {

// Costs are estimated in floating point: exact counts would overflow.
inline double as_double(std::int64_t count) { return static_cast<double>(count); }

// What the memory of a run of swaps depends on.
struct SwapSizes {
  FieldLayout slice;       // as the engine keeps slices
  FieldLayout tile;        // as a thread copies what it moves
  std::int64_t num_tiles;  // of a slice
  std::int64_t num_classes;
  bool by_ids;             // partners are looked up by the order of the samples (anneal)
  bool class_is_coupled;   // slices that move together see one another
  int features = 0;        // the most that the run comes to; 0: slices act through their taps
  int sieve_features = 0;  // that candidates are estimated with; 0: all are judged
  int channels = 1;
  bool sorts_for_mean = true;   // the mean distance is found by sorting
  std::int64_t mean_tasks = 1;  // that it is shared out in, among ranks and threads
  double mean_task_bytes = 0;   // of each
  bool has_pdf = false;
  bool is_given = false;    // the arrangement that the run begins with is kept
  std::int64_t visit = 1;   // iterations of a visit
  double file_samples = 0;  // values that a user's file brings
  bool begins_with_lattice = false;
};

// Of one rank; its slices and halo slices are known.
PlanMemory swap_memory(const SwapSizes& sizes, const FilterOutline& scored, const FilterOutline& judged,
                       std::int64_t num_slices, const PlanRequest& request, const PlanRank& rank);

// Void and cluster.
PlanMemory order_memory(const VacSpec& spec, double kernel_taps, const PlanRequest& request, const PlanRank& rank);

// Construction.
PlanMemory construct_memory(const Extents& extents, const FilterOutline& overlap, const PlanRequest& request,
                            const PlanRank& rank);

// The program with MPI and HDF5 before any texture.
double program_bytes(const PlanRequest& request);

// The rank that writes and all others of its node.
double bytes_of_node(double writer, double other, const PlanRequest& request);

}  // namespace noiseloom
