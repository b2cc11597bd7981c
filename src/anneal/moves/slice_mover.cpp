#include "noiseloom/anneal/slice_mover.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "anneal/moves/proposals.h"
#include "anneal/moves/sieve_margin.h"
#include "noiseloom/anneal/involution.h"
#include "noiseloom/core/math.h"
#include "noiseloom/core/random.h"

namespace noiseloom {

PartnerDraw::PartnerDraw(std::int64_t num_samples, StepRange range, bool circular, int num_strata)
    : num_strata_(num_strata),
      run_(narrow<std::uint32_t>(num_samples / num_strata)),
      circular_(circular && num_strata == 1),
      lowest_step_(static_cast<float>(std::max(1.0, static_cast<double>(run_) / range.near))),
      log2_ratio_(static_cast<float>(
          math::log(std::max(1.0, static_cast<double>(run_) / range.far / double{lowest_step_})) / math::log(2))) {
  NOISELOOM_CHECK(range.far >= 2);  // partner() mirrors once
  NOISELOOM_CHECK(num_samples % num_strata == 0);
}

struct AnnealMover::Batch {
  std::array<CellPair, proposal_batch> pairs;
  Proposals proposals;
  std::size_t size;
  std::span<const CellPair> drawn() const { return std::span(pairs).first(size); }
};

static_assert(proposal_batch <= SwapDelta::most_estimates);

AnnealMover::AnnealMover(std::unique_ptr<SwapDelta> delta) : delta_(std::move(delta)) {}

namespace {

struct CellId {
  SampleId id;
  std::uint32_t cell;
};

// Least digit first: far quicker than comparing, and a visit sorts anew. Two digits serve slices of 4096x4096.
// `sorted`: as many, of any value.
void sort_by_id(std::vector<CellId>& cells, std::vector<CellId>& sorted) {
  constexpr int digit_bits = 12;
  const std::uint32_t most =
      std::max_element(cells.begin(), cells.end(), [](CellId a, CellId b) { return a.id < b.id; })->id.value();
  for (int shift = 0; shift < 32 && most >> shift != 0; shift += digit_bits) {
    const auto digit = [shift](CellId entry) { return (entry.id.value() >> shift) & ((1U << digit_bits) - 1); };
    std::array<std::uint32_t, (1U << digit_bits) + 1> begin{};
    for (const CellId entry : cells) ++begin[digit(entry) + 1];
    for (std::size_t k = 1; k < begin.size(); ++k) begin[k] += begin[k - 1];
    for (const CellId entry : cells) sorted[begin[digit(entry)]++] = entry;
    cells.swap(sorted);
  }
}

}  // namespace

IndexedVector<SampleId, std::uint32_t> cells_by_id(const FieldLayout& slice, Corner corner, const FieldLayout& window,
                                                   std::span<const SampleId> permutation) {
  IndexedVector<SampleId, std::uint32_t> by_id(static_cast<std::size_t>(window.width * window.height));
  if (window.whole()) {
    for (std::size_t cell = 0; cell < by_id.size(); ++cell) by_id[permutation[cell]] = static_cast<std::uint32_t>(cell);
    return by_id;
  }
  // Kept, as memory that is given back and taken anew costs a page fault for every 512 cells.
  thread_local std::vector<CellId> cells;
  thread_local std::vector<CellId> sorted;
  cells.resize(by_id.size());
  sorted.resize(by_id.size());
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const Cell cell = slice_cell(slice, corner, window, static_cast<Cell>(k));
    cells[k] = {permutation[static_cast<std::size_t>(cell)], static_cast<std::uint32_t>(k)};
  }
  sort_by_id(cells, sorted);
  std::transform(cells.begin(), cells.end(), by_id.begin(), [](CellId entry) { return entry.cell; });
  return by_id;
}

void AnnealMover::load(const Visit& visit, const SliceField& field, std::span<const SampleId> permutation) {
  cell_of_ = cells_by_id(field.layout(), visit.corner, delta_->layout(), permutation);
  id_at_.resize(cell_of_.size());
  std::uint32_t id = 0;
  for (const std::uint32_t cell : cell_of_) id_at_[cell] = SampleId(id++);
}

void AnnealMover::draw(const Visit& visit, std::uint64_t first, std::uint64_t end, const PartnerDraw& partners,
                       Batch& batch) const {
  const ProposalSource source{
      visit.seed,           static_cast<std::uint32_t>(visit.slice), visit.sweep, id_at_.size(), partners.lowest_step(),
      partners.log2_ratio()};
  batch.proposals = draw_proposals(source, first);
  batch.size = std::min<std::uint64_t>(proposal_batch, end - first);
  for (std::size_t k = 0; k < batch.size; ++k) {
    const std::uint32_t i = batch.proposals.cell[k];
    batch.pairs[k] = {i, cell_of_[partners.partner(id_at_[i], batch.proposals.step[k])]};
  }
  if (delta_->has_estimates()) {
    delta_->prefetch_estimates(batch.drawn());
  } else {
    delta_->prefetch(batch.drawn());
  }
}

void AnnealMover::carry_out(CellPair pair) {
  delta_->swap(pair);
  std::swap(id_at_[pair.i], id_at_[pair.j]);
  cell_of_[id_at_[pair.i]] = pair.i;
  cell_of_[id_at_[pair.j]] = pair.j;
}

namespace {

// The share of the visit's tile.
std::uint64_t num_candidates(const Visit& visit, const FieldLayout& slice) {
  const auto all = static_cast<std::uint64_t>(slice.width * slice.height * visit.iterations / 2);
  const auto tile = static_cast<std::uint64_t>(visit.tile);
  const auto tiles = static_cast<std::uint64_t>(visit.num_tiles);
  return (tile + 1) * all / tiles - tile * all / tiles;
}

}  // namespace

// The candidates of a visit and what decides about them.
struct AnnealMover::Range {
  const Visit& visit;
  std::uint64_t begin;
  std::uint64_t end;
  double temperature;
  const PartnerDraw& partners;
  const FieldLayout& slice;

  double limit(const Batch& batch, std::size_t k) const { return temperature * double{batch.proposals.threshold[k]}; }
};

void AnnealMover::judge(const Range& range, const Batch& batch, std::size_t k, VisitResult& result) {
  const CellPair pair = batch.pairs[k];
  const double change = delta_->delta(pair);
  // NaN is never accepted.
  if (!(change <= range.limit(batch, k))) return;
  carry_out(pair);
  result.energy += change;
  const auto in_slice = [&](std::uint32_t cell) {
    return static_cast<std::uint32_t>(slice_cell(range.slice, range.visit.corner, delta_->layout(), cell));
  };
  result.swaps.push_back({in_slice(pair.i), in_slice(pair.j)});
}

void AnnealMover::move_all(const Range& range, VisitResult& result) {
  Batch batch;
  for (std::uint64_t first = range.begin; first < range.end; first += proposal_batch) {
    draw(range.visit, first, range.end, range.partners, batch);
    for (std::size_t k = 0; k < batch.size; ++k) {
      if (batch.pairs[k].i == batch.pairs[k].j) continue;
      ++result.candidates;
      judge(range, batch, k, result);
    }
  }
}

// One batch ahead is drawn, so that what estimates need of memory is there in time. The first candidates are judged
// and estimated, which tells how much estimates are worth.
void AnnealMover::move_sieved(const Range& range, VisitResult& result) {
  constexpr std::uint64_t most_learnt = 256;
  const std::uint64_t learnt_end =
      range.begin + std::clamp<std::uint64_t>((range.end - range.begin) / 16, 1, most_learnt);
  SieveMargin margin;
  bool learns = true;
  Batch batch;
  Batch next;
  std::array<double, proposal_batch> estimates{};
  draw(range.visit, range.begin, range.end, range.partners, next);
  for (std::uint64_t first = range.begin; first < range.end; first += proposal_batch) {
    batch = next;
    if (first + proposal_batch < range.end) {
      draw(range.visit, first + proposal_batch, range.end, range.partners, next);
    }
    delta_->estimate(batch.drawn(), estimates.data());
    if (learns && first >= learnt_end) {
      margin.conclude();
      learns = false;
    }
    for (std::size_t k = 0; k < batch.size && learns; ++k) {
      const CellPair pair = batch.pairs[k];
      if (pair.i != pair.j) margin.learn(batch.proposals.step[k], estimates[k], delta_->delta(pair));
    }
    std::array<std::size_t, proposal_batch> judged;
    std::size_t num_judged = 0;
    for (std::size_t k = 0; k < batch.size; ++k) {
      if (batch.pairs[k].i == batch.pairs[k].j) continue;
      ++result.candidates;
      if (!learns && !margin.lets_through(batch.proposals.step[k], estimates[k], range.limit(batch, k))) continue;
      delta_->prefetch(batch.drawn().subspan(k, 1));
      judged[num_judged++] = k;
    }
    for (const std::size_t k : std::span(judged).first(num_judged)) judge(range, batch, k, result);
  }
}

VisitResult AnnealMover::visit(const Visit& visit, double temperature, const PartnerDraw& partners,
                               const SliceField& field, std::span<const SampleId> permutation, const FieldOf& others) {
  load(visit, field, permutation);
  delta_->bind(visit.slice, visit.corner, field, others);
  VisitResult result;
  result.swaps = std::move(spare_);
  result.swaps.clear();
  result.swaps.reserve(num_swaps_ + num_swaps_ / 8);  // growing it would take longer than many a swap
  const std::uint64_t begin = std::uint64_t{static_cast<std::uint32_t>(visit.tile)} << 32;
  const Range range{visit, begin, begin + num_candidates(visit, field.layout()), temperature, partners, field.layout()};
  if (delta_->has_estimates()) {
    move_sieved(range, result);
  } else {
    move_all(range, result);
  }
  num_swaps_ = result.swaps.size();
  result.num_swaps = std::ssize(result.swaps);
  return result;
}

double AnnealMover::mean_magnitude(const Visit& visit, std::int64_t count, const PartnerDraw& partners,
                                   const SliceField& field, std::span<const SampleId> permutation,
                                   const FieldOf& others) {
  load(visit, field, permutation);
  delta_->bind(visit.slice, visit.corner, field, others);
  double sum = 0;
  std::int64_t judged = 0;
  Batch batch;
  const auto end = static_cast<std::uint64_t>(count);
  for (std::uint64_t first = 0; first < end; first += proposal_batch) {
    draw(visit, first, end, partners, batch);
    for (const CellPair pair : batch.drawn()) {
      if (pair.i == pair.j) continue;
      sum += std::abs(delta_->delta(pair));
      ++judged;
    }
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
    if (delta_->delta({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)}) < 0) {
      result.swaps.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)});
    }
  }
  result.num_swaps = std::ssize(result.swaps);
  return result;
}

}  // namespace noiseloom
