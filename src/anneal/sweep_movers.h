// The movers of one rank, one for each thread, and what they work with: how far partners lie, and the features that
// stand for other slices. Both follow the temperature, so they are chosen anew for every sweep.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "noiseloom/anneal/feature_map.h"
#include "noiseloom/anneal/slice_mover.h"
#include "noiseloom/anneal/spec.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

class SweepMovers {
 public:
  // `energy`: the footprint that candidates are judged with; `tile`: what a mover moves at a time. The arguments must
  // outlive the object. Ready for the start of a round.
  SweepMovers(const OptimizerSpec& optimizer, const Footprint& energy, const ValueKernel& kernel,
              const SampleSource& source, WindowSize tile, int num_threads);

  // Whether other slices act through features, and not through all taps. The same for the whole run.
  bool use_features() const { return features_.has_value(); }
  // Whether candidates are estimated before they are judged; likewise.
  bool use_sieve() const { return sieve_.has_value(); }
  // Partners and features that fit where a schedule is these fractions through.
  void prepare(double steps_at, double features_at);

  // Visits a tile of a slice, in the thread `worker`. `heat`: the temperature, or gamma with the paper's method.
  VisitResult visit(const Visit& visit, double heat, const SliceField& field, std::span<const SampleId> permutation,
                    const FieldOf& others, int worker);
  // Memory for the swaps of the next visit in that thread.
  void recycle(std::vector<Swap> swaps, int worker);
  // anneal: mean |dE| of `count` candidates of a visit, none of them carried out.
  double mean_magnitude(const Visit& visit, std::int64_t count, const SliceField& field,
                        std::span<const SampleId> permutation, const FieldOf& others);

 private:
  void make_movers();

  const OptimizerSpec& optimizer_;
  const Footprint& energy_;
  const ValueKernel& kernel_;
  const SampleSource& source_;
  WindowSize tile_;
  int num_threads_;
  std::optional<FeatureMap> sieve_;
  bool many_features_;
  int features_wanted_;
  std::optional<FeatureMap> features_;
  PartnerDraw partners_;
  std::vector<AnnealMover> anneal_movers_;    // one for each thread, or none
  std::vector<PairingMover> pairing_movers_;  // likewise
};

}  // namespace noiseloom
