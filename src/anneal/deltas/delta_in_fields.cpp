#include "anneal/deltas/delta_in_fields.h"

namespace noiseloom {

DeltaInFields::DeltaInFields(const Footprint& footprint, int channels, WindowSize window,
                             const FeatureMap* between_slices, const FeatureMap* sieve)
    : fields_(footprint, channels, window, between_slices == nullptr) {
  if (between_slices != nullptr) background_.emplace(footprint, *between_slices, window);
  if (sieve != nullptr) sieve_.emplace(footprint, *sieve, window);
}

void DeltaInFields::bind(SliceIndex slice, Corner corner, const SliceField& own, const FieldOf& others) {
  fields_.bind(slice, corner, own, others);
  if (background_) background_->bind(slice, corner, fields_.own(), others);
  if (sieve_) sieve_->bind(slice, corner, fields_.own(), others);
}

void DeltaInFields::swap(CellPair pair) {
  fields_.swap(pair.i, pair.j);
  if (background_) background_->swap(pair);
  if (sieve_) sieve_->swap(pair);
}

// What lies in the nearer caches without that, planes of samples, is not worth the instructions.
void DeltaInFields::prefetch(std::span<const CellPair> pairs) const {
  for (const CellPair pair : pairs) {
    for (const std::uint32_t cell : {pair.i, pair.j}) {
      fields_.prefetch_stack(cell);
      if (background_) prefetch_floats(background_->at(cell), 2 * background_->num_lanes());
    }
  }
}

void DeltaInFields::prefetch_estimates(std::span<const CellPair> pairs) const {
  for (const CellPair pair : pairs) {
    for (const std::uint32_t cell : {pair.i, pair.j}) {
      prefetch_floats(sieve_->features(cell), sieve_->num_lanes());
      prefetch_floats(sieve_->pulls(cell), sieve_->num_lanes());
    }
  }
}

void DeltaInFields::estimate(std::span<const CellPair> pairs, double* out) const {
  float sums[most_estimates];
  sieve_->estimate(pairs, sums);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    out[k] = 2 * static_cast<double>(sums[k]);
    if (!fields_.may_be_near(pairs[k].i, pairs[k].j)) continue;
    const DeltaFields::Position at_i = fields_.position(pairs[k].i);
    const DeltaFields::Position at_j = fields_.position(pairs[k].j);
    if (const float weight = fields_.pair_weight(at_i, at_j); weight != 0) {
      out[k] = 2 * static_cast<double>(sums[k] - weight * pair_term(at_i, at_j));
    }
  }
}

}  // namespace noiseloom
