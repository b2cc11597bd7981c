// What a run would take, found without running it: memory, files, messages, time, and which parts of the program the
// config puts to work. In about a second and a few dozen megabytes, whatever the size of the texture.
//
// Counts (taps, candidates, pairs, slices, bytes) follow from the config. Speeds are measured here and now, on a small
// texture with the config's own samples and filter. Memory is modelled from what the program holds; the largest part of
// what it says was compared with the peaks of real runs (tests/bench/plan_memory.py).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/config/config.h"

namespace noiseloom {

struct PlanRequest {
  int ranks = 1;
  int threads = 1;         // of each rank
  int ranks_per_node = 0;  // 0: all on one node
};

// A part of the program that a config needs, or does not.
struct PlanEffect {
  std::string name;
  bool on;
  std::string why;
};

// Bytes of one rank.
struct PlanMemory {
  double program = 0;   // code, libraries, MPI: there without any texture
  double texture = 0;   // own slices: samples and their places
  double halo = 0;      // copies of other ranks' slices
  double filter = 0;    // footprints and kernels
  double inputs = 0;    // users' files and the tables of densities: of all ranks of a node together
  double threads = 0;   // what the threads move in
  double at_move = 0;   // more, while slices move: swaps that are not carried out or told yet
  double at_start = 0;  // more, while the samples are placed and scored
  double at_score = 0;  // more, while R is evaluated
  double at_save = 0;   // more, while the run file is written

  double held() const { return program + texture + halo + filter + inputs; }
  double peak() const;
};

struct PlanRank {
  Rank rank;
  std::int64_t slices;
  std::int64_t halo_slices;
  double bytes;  // peak
};

struct PlanFilter {
  std::int64_t taps = 0;         // of the score: every offset but zero
  std::int64_t judged_taps = 0;  // that a candidate is judged with, all slices
  std::vector<std::int64_t> reach;
  std::int64_t coupled_slices = 0;
  bool exact = true;
};

// The low-rank stand-in for other slices at one moment of the run.
struct PlanFeatures {
  int count;
  double missed;  // share of the variance
};

struct PlanExchange {
  double slice_updates = 0;  // a sweep: a slice that moved, told to one rank
  double messages = 0;       // a sweep
  double bytes = 0;          // a sweep
};

// Seconds. total is the sum; the truth mostly lies between total / spread and total * spread.
struct PlanTime {
  double start = 0;
  double moves = 0;
  double scores = 0;
  double exchange = 0;
  double saves = 0;
  double spread = 1.5;
  std::int64_t iterations = 0;  // that these seconds are for
  std::string stop;             // "iterations", "time", "score", "improvement", "order", "construction"
  double candidate_us = 0;      // one candidate (void and cluster, construction: one pick) on one thread
  double score_s = 0;           // one evaluation of R
  std::int64_t num_scores = 0;

  double total() const { return start + moves + scores + exchange + saves; }
};

// Of void and cluster.
struct PlanPhases {
  double points = 0;  // of the pattern
  double swaps = 0;
  std::string measured_on;  // the size of the texture that the speed was found with
};

struct RunPlan {
  std::string texture;  // "128 x 128 x 32"
  std::string samples;  // the name of the space
  std::string method;
  std::int64_t pixels = 0;
  std::int64_t num_slices = 0;
  int channels = 1;
  PlanRequest request;

  std::vector<PlanEffect> axes;     // what the filter does along each axis
  std::vector<PlanEffect> effects;  // parts of the program
  PlanFilter filter;
  std::vector<std::string> axis_names;
  std::vector<PlanFeatures> features;  // at the start, in the coldest quarter, in the coldest twentieth
  std::int64_t tile_width = 0;         // as wide and high as the slice: not divided
  std::int64_t tile_height = 0;
  std::int64_t num_tiles = 1;
  std::int64_t num_classes = 1;
  std::int64_t iterations_per_sweep = 1;

  std::vector<PlanRank> ranks;  // all, or a few that stand for the rest
  int idle_ranks = 0;           // without a slice
  PlanMemory most;              // of the rank that needs most
  double node_bytes = 0;        // of the node that needs most
  double input_bytes = 0;       // what PlanMemory::inputs is
  PlanExchange exchange;
  double run_file_bytes = 0;
  double disk_bytes = 0;  // at a save, when most is there
  PlanTime time;
  PlanPhases phases;
};

// Throws UserError for what the config names and cannot be used, and where the request makes no sense. MPI need not be
// initialised, but for void and cluster and construction, which are tried on a communicator.
RunPlan plan_run(const RunConfig& config, const PlanRequest& request);

}  // namespace noiseloom
