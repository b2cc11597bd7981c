#include "anneal/sweep_movers.h"

#include <utility>

#include "noiseloom/anneal/swap_choices.h"

namespace noiseloom {

SweepMovers::SweepMovers(const OptimizerSpec& optimizer, const Footprint& energy, const ValueKernel& kernel,
                         const SampleSource& source, WindowSize tile, int num_threads)
    : optimizer_(optimizer),
      energy_(energy),
      kernel_(kernel),
      source_(source),
      tile_(tile),
      num_threads_(num_threads),
      sieve_(features_of_sieve(optimizer, energy, kernel, source)),
      many_features_(wants_many_features(energy, sieve_.has_value())),
      features_wanted_(num_features(optimizer, 0, many_features_)),
      features_(features_between_slices(optimizer, energy, kernel, source, features_wanted_)),
      partners_(partners_for(source.distance(), source.channels(), tile, 0, optimizer.strata)) {
  make_movers();
}

void SweepMovers::make_movers() {
  for (int worker = 0; worker < num_threads_; ++worker) {
    auto delta = make_swap_delta(energy_, kernel_, optimizer_.precision, features_ ? &*features_ : nullptr, tile_,
                                 sieve_ ? &*sieve_ : nullptr);
    if (optimizer_.method == Method::anneal) {
      anneal_movers_.emplace_back(std::move(delta));
    } else {
      pairing_movers_.emplace_back(std::move(delta));
    }
  }
}

void SweepMovers::prepare(double steps_at, double features_at) {
  partners_ = partners_for(source_.distance(), source_.channels(), tile_, steps_at, optimizer_.strata);
  const int wanted = num_features(optimizer_, features_at, many_features_);
  if (!features_ || wanted == features_wanted_) return;
  features_wanted_ = wanted;
  anneal_movers_.clear();  // before the features that they look at
  features_ = features_between_slices(optimizer_, energy_, kernel_, source_, wanted);
  make_movers();
}

VisitResult SweepMovers::visit(const Visit& visit, double heat, const SliceField& field,
                               std::span<const SampleId> permutation, const FieldOf& others, int worker) {
  const auto thread = static_cast<std::size_t>(worker);
  if (optimizer_.method == Method::fast) return pairing_movers_[thread].visit(visit, heat, field, others);
  return anneal_movers_[thread].visit(visit, heat, partners_, field, permutation, others);
}

void SweepMovers::recycle(std::vector<Swap> swaps, int worker) {
  if (!anneal_movers_.empty()) anneal_movers_[static_cast<std::size_t>(worker)].recycle(std::move(swaps));
}

double SweepMovers::mean_magnitude(const Visit& visit, std::int64_t count, const SliceField& field,
                                   std::span<const SampleId> permutation, const FieldOf& others) {
  return anneal_movers_.front().mean_magnitude(visit, count, partners_, field, permutation, others);
}

}  // namespace noiseloom
