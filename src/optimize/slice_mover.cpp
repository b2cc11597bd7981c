#include "noiseloom/optimize/slice_mover.h"

#include <algorithm>
#include <cmath>

#include "noiseloom/core/math.h"
#include "noiseloom/core/random.h"
#include "noiseloom/optimize/involution.h"

namespace noiseloom {
namespace {

constexpr std::size_t num_steps = 1024;  // the upper 10 of 31 bits choose a quantile, the rest interpolate

}  // namespace

PartnerDraw::PartnerDraw(std::int64_t num_samples, double lowest_divisor, bool circular)
    : num_samples_(num_samples), circular_(circular), steps_(num_steps + 1) {
  const double n = static_cast<double>(num_samples);
  const double low = std::max(1.0, n / lowest_divisor);
  const double ratio = std::max(1.0, n / 2) / low;
  for (std::size_t k = 0; k <= num_steps; ++k) {
    steps_[k] = low * math::pow(std::max(ratio, 1.0), static_cast<double>(k) / static_cast<double>(num_steps));
  }
}

std::uint32_t PartnerDraw::partner(std::uint32_t id, std::uint32_t bits) const {
  const std::size_t k = bits >> 22;
  const double part = static_cast<double>((bits >> 1) & 0x1fffffU) * 0x1p-21;
  const auto step = static_cast<std::int64_t>(steps_[k] + part * (steps_[k + 1] - steps_[k]));
  std::int64_t other = (bits & 1U) != 0 ? std::int64_t{id} + step : std::int64_t{id} - step;
  if (circular_) {
    other = (other % num_samples_ + num_samples_) % num_samples_;
  } else {
    if (other < 0) other = -other;
    if (other >= num_samples_) other = 2 * (num_samples_ - 1) - other;
  }
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(other, 0, num_samples_ - 1));
}

struct AnnealMover::Candidate {
  Cell i;
  Cell j;
  std::uint32_t acceptance_bits;
};

AnnealMover::AnnealMover(std::unique_ptr<SwapDelta> delta) : delta_(std::move(delta)) {}

void AnnealMover::load(std::span<const std::uint32_t> permutation) {
  id_at_.assign(permutation.begin(), permutation.end());
  cell_of_.resize(id_at_.size());
  for (std::size_t cell = 0; cell < id_at_.size(); ++cell) cell_of_[id_at_[cell]] = static_cast<std::uint32_t>(cell);
}

AnnealMover::Candidate AnnealMover::draw(const Visit& visit, std::uint64_t index, const PartnerDraw& partners) const {
  const RandomBlock bits =
      random_block(visit.seed, Purpose::proposal, static_cast<std::uint32_t>(visit.slice), visit.sweep, index);
  const std::uint32_t i = to_below(bits[0], id_at_.size());
  const std::uint32_t j = cell_of_[partners.partner(id_at_[i], bits[1])];
  return {i, j, bits[2]};
}

VisitResult AnnealMover::visit(const Visit& visit, double temperature, const PartnerDraw& partners,
                               const SliceField& field, std::span<const std::uint32_t> permutation,
                               const FieldOf& others) {
  load(permutation);
  delta_->bind(visit.slice, field, others);
  VisitResult result;
  const std::uint64_t count = id_at_.size() / 2;
  for (std::uint64_t index = 0; index < count; ++index) {
    const Candidate candidate = draw(visit, index, partners);
    if (candidate.i == candidate.j) continue;
    ++result.candidates;
    const double change = delta_->delta(candidate.i, candidate.j);
    // exp(-24) is below the resolution of the acceptance bits. NaN is never accepted.
    if (!(change <= 24 * temperature)) continue;
    if (change > 0) {
      const double uniform = (static_cast<double>(candidate.acceptance_bits) + 0.5) * 0x1p-32;
      if (change >= -temperature * math::log(uniform)) continue;
    }
    delta_->swap(candidate.i, candidate.j);
    std::swap(id_at_[static_cast<std::size_t>(candidate.i)], id_at_[static_cast<std::size_t>(candidate.j)]);
    cell_of_[id_at_[static_cast<std::size_t>(candidate.i)]] = static_cast<std::uint32_t>(candidate.i);
    cell_of_[id_at_[static_cast<std::size_t>(candidate.j)]] = static_cast<std::uint32_t>(candidate.j);
    result.swaps.push_back({static_cast<std::uint32_t>(candidate.i), static_cast<std::uint32_t>(candidate.j)});
  }
  return result;
}

double AnnealMover::mean_magnitude(const Visit& visit, std::int64_t count, const PartnerDraw& partners,
                                   const SliceField& field, std::span<const std::uint32_t> permutation,
                                   const FieldOf& others) {
  load(permutation);
  delta_->bind(visit.slice, field, others);
  double sum = 0;
  std::int64_t judged = 0;
  for (std::int64_t index = 0; index < count; ++index) {
    const Candidate candidate = draw(visit, static_cast<std::uint64_t>(index), partners);
    if (candidate.i == candidate.j) continue;
    sum += std::abs(delta_->delta(candidate.i, candidate.j));
    ++judged;
  }
  return judged > 0 ? sum / static_cast<double>(judged) : 0;
}

VisitResult PairingMover::visit(const Visit& visit, double fraction, const SliceField& field, const FieldOf& others) {
  delta_->bind(visit.slice, field, others);
  const auto cells = static_cast<std::uint64_t>(field.layout().width * field.layout().height);
  const Involution pairing(visit.seed, static_cast<std::uint32_t>(visit.slice), visit.sweep, cells);
  VisitResult result;
  for (std::uint64_t i = 0; i < cells; ++i) {
    const std::uint64_t j = pairing(i);
    if (j <= i) continue;
    if (fraction < 1) {
      const RandomBlock bits =
          random_block(visit.seed, Purpose::fraction, static_cast<std::uint32_t>(visit.slice), visit.sweep, i);
      if (to_unit_double(bits[0], bits[1]) >= fraction) continue;
    }
    ++result.candidates;
    if (delta_->delta(static_cast<Cell>(i), static_cast<Cell>(j)) < 0) {
      result.swaps.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)});
    }
  }
  return result;
}

}  // namespace noiseloom
