#include "construct/plane_field.h"

#include <algorithm>
#include <array>
#include <utility>

#include "construct/plane_simd.h"

namespace noiseloom {
namespace {

using plane_simd::leaf_words;
constexpr std::size_t branch_leaves = 64;
constexpr std::size_t vector_words = 16;

plane_simd::Shape shape_of(const Extents& extents) { return {extents.width(), extents.height()}; }

}  // namespace

PlaneField::PlaneField(const StampKernel& kernel, const VacTieHash& hash, std::uint64_t first_position,
                       Retiring retiring)
    : kernel_(kernel),
      hash_(hash),
      first_position_(first_position),
      on_bits_(retiring == Retiring::yes ? vac_flag | vac_flag >> 1 : vac_flag),
      retired_bit_(on_bits_ ^ vac_flag),
      pickable_(std::uint32_t{1} << energy_bits(retiring)),
      cells_(narrow<std::uint32_t>(kernel.extents().cells_per_slice())),
      num_leaves_((cells_ + leaf_words - 1) / leaf_words),
      words_(allocate_words(num_leaves_ * leaf_words + vector_words)) {}

void PlaneField::clear() {
  std::fill_n(words_.get(), num_leaves_ * leaf_words + vector_words, kernel_.bias());
  for (Bounds& bounds : bounds_) bounds.stale = true;
}

bool PlaneField::may_fall(VacView view, bool on) const {
  return !kernel_.is_monotone() || (view == VacView::voids) != on;
}

void PlaneField::act(const SliceStamp& stamp, bool on, std::span<const std::uint32_t> cells) {
  if (cells.empty()) return;
  ++epoch_;
  plane_simd::add_stamps(shape_of(kernel_.extents()), stamp, kernel_.weights().data(), words_.get(), on, cells);
  for (const VacView view : {VacView::voids, VacView::clusters}) {
    if (may_fall(view, on)) bounds_[index(view)].stale = true;
  }
}

// Its value rises, so that bounds hold; but it may have been the one to be picked.
void PlaneField::close(std::uint32_t cell) {
  retire(cell);
  Bounds& bounds = bounds_[index(VacView::voids)];
  if (bounds.watched && !bounds.stale) bounds.winners[cell / leaf_words].epoch = 0;
}

void PlaneField::reopen(std::uint32_t cell) {
  retire(cell);
  look_again(cell);
}

void PlaneField::open_all() {
  const std::uint32_t closed = retired_bit_;
  for (std::uint32_t cell = 0; cell < cells_; ++cell) {
    if ((words_[cell] & on_bits_) == closed) words_[cell] ^= closed;
  }
  for (Bounds& bounds : bounds_) bounds.stale = true;
}

void PlaneField::turn_on(std::uint32_t cell) {
  words_[cell] ^= on_bits_;
  plane_simd::add_stamps(shape_of(kernel_.extents()), kernel_.stamps()[0], kernel_.weights().data(), words_.get(), true,
                         {&cell, 1});
  look_again(cell);
}

void PlaneField::turn_off(std::uint32_t cell) {
  words_[cell] ^= on_bits_;
  plane_simd::add_stamps(shape_of(kernel_.extents()), kernel_.stamps()[0], kernel_.weights().data(), words_.get(),
                         false, {&cell, 1});
  look_again(cell);
}

// The leaves that a pixel of this slice reaches; neighbouring rows may name a leaf again.
template <class Visit>
void PlaneField::each_leaf_in_reach(std::uint32_t cell, const Visit& visit) const {
  const std::int64_t width = kernel_.extents().width();
  const std::int64_t height = kernel_.extents().height();
  const auto x = static_cast<std::int64_t>(cell) % width;
  const auto y = static_cast<std::int64_t>(cell) / width;
  std::size_t last = num_leaves_;
  const auto visit_cells = [&](std::int64_t begin, std::int64_t end) {
    for (auto leaf = static_cast<std::size_t>(begin) / leaf_words;
         leaf <= static_cast<std::size_t>(end - 1) / leaf_words; ++leaf) {
      if (leaf == last) continue;
      last = leaf;
      visit(leaf);
    }
  };
  for (const StampRow& row : kernel_.stamps()[0].rows) {
    std::int64_t line = y + row.dy;
    line += line < 0 ? height : line >= height ? -height : 0;
    line *= width;
    const std::int64_t begin = x - row.lo;
    const std::int64_t end = x + row.hi + 1;
    const std::int64_t from = std::max<std::int64_t>(begin, 0);
    const std::int64_t to = std::min(end, width);
    if (to > from) visit_cells(line + from, line + to);
    if (begin < 0) visit_cells(line + begin + width, line + std::min<std::int64_t>(end, 0) + width);
    if (end > width) visit_cells(line + std::max(begin, width) - width, line + end - width);
  }
}

// After a pixel of this slice was turned on or off. Lowers the bounds of the leaves that it reaches, where values may
// have fallen; its own leaf in any case, as the pixel has come into view or left it.
void PlaneField::look_again(std::uint32_t cell) {
  for (const VacView view : {VacView::voids, VacView::clusters}) {
    Bounds& bounds = bounds_[index(view)];
    if (bounds.stale || !bounds.watched) continue;
    const auto look = [&](std::size_t leaf) {
      const std::uint32_t least = least_of_leaf(leaf, view);
      bounds.leaves[leaf] = least;
      bounds.winners[leaf].epoch = 0;
      std::uint32_t& branch = bounds.branches[leaf / branch_leaves];
      branch = std::min(branch, least);
    };
    look(cell / leaf_words);
    if (may_fall(view, is_on(cell))) {
      each_leaf_in_reach(cell, look);
    } else {
      each_leaf_in_reach(cell, [&](std::size_t leaf) { bounds.winners[leaf].epoch = 0; });
    }
  }
}

std::uint32_t PlaneField::least_of_leaf(std::size_t leaf, VacView view) const {
  const std::size_t begin = leaf * leaf_words;
  if (begin + leaf_words <= cells_) return plane_simd::least_of_leaf(words_.get() + begin, view);
  std::array<std::uint32_t, leaf_words> copy;
  copy.fill(~static_cast<std::uint32_t>(view));  // what no view looks for
  std::copy_n(words_.get() + begin, cells_ - begin, copy.begin());
  return plane_simd::least_of_leaf(copy.data(), view);
}

// Of the cells of a leaf with that value, the one with the least hash; requires that there is one.
PlaneField::Winner PlaneField::winner_of(std::size_t leaf, VacView view, std::uint32_t value) const {
  const auto flip = static_cast<std::uint32_t>(view);
  const auto begin = static_cast<std::uint32_t>(leaf * leaf_words);
  const auto end = std::min(cells_, begin + static_cast<std::uint32_t>(leaf_words));
  Winner winner{0, 0, epoch_};
  bool found = false;
  for (std::uint32_t cell = begin; cell < end; ++cell) {
    if ((words_[cell] ^ flip) != value) continue;
    const std::uint32_t hash = hash_(first_position_ + cell) ^ flip;
    if (found && hash >= winner.hash) continue;
    winner.cell = cell;
    winner.hash = hash;
    found = true;
  }
  NOISELOOM_CHECK(found);
  return winner;
}

void PlaneField::watch(bool voids, bool clusters) {
  for (const VacView view : {VacView::voids, VacView::clusters}) {
    Bounds& bounds = bounds_[index(view)];
    bounds.watched = view == VacView::voids ? voids : clusters;
    bounds.stale = true;
    if (bounds.watched) continue;
    bounds.leaves = {};
    bounds.branches = {};
    bounds.winners = {};
  }
}

void PlaneField::refresh(VacView view) {
  constexpr std::uint32_t none = ~std::uint32_t{0};
  Bounds& bounds = bounds_[index(view)];
  const std::size_t num_branches = (num_leaves_ + branch_leaves - 1) / branch_leaves;
  bounds.leaves.assign(num_branches * branch_leaves, none);
  bounds.winners.assign(num_branches * branch_leaves, {});
  bounds.branches.assign((num_branches + vector_words - 1) / vector_words * vector_words, none);
  const std::size_t whole = cells_ / leaf_words;
  plane_simd::leaf_minima(words_.get(), whole, view, bounds.leaves.data());
  if (whole < num_leaves_) bounds.leaves[whole] = least_of_leaf(whole, view);
  for (std::size_t branch = 0; branch < num_branches; ++branch) {
    bounds.branches[branch] = plane_simd::least_of(bounds.leaves.data() + branch * branch_leaves, branch_leaves);
  }
  bounds.stale = false;
}

std::optional<std::uint32_t> PlaneField::pick(VacView view) {
  Bounds& bounds = bounds_[index(view)];
  NOISELOOM_CHECK(bounds.watched);
  if (bounds.stale) refresh(view);
  while (true) {
    const std::uint32_t least = plane_simd::least_of(bounds.branches.data(), bounds.branches.size());
    if (least >= pickable_) return std::nullopt;
    std::optional<std::uint32_t> best;
    std::uint32_t best_hash = 0;
    for (std::size_t branch = 0; branch * branch_leaves < num_leaves_; ++branch) {
      if (bounds.branches[branch] != least) continue;
      std::uint32_t* const leaves = bounds.leaves.data() + branch * branch_leaves;
      bool holds = false;
      for (std::size_t i = 0; i < branch_leaves; ++i) {
        if (leaves[i] != least) continue;
        const std::size_t leaf = branch * branch_leaves + i;
        Winner& winner = bounds.winners[leaf];
        if (winner.epoch != epoch_) {
          leaves[i] = least_of_leaf(leaf, view);
          if (leaves[i] != least) continue;
          winner = winner_of(leaf, view, least);
        }
        holds = true;
        if (best && winner.hash >= best_hash) continue;
        best = winner.cell;
        best_hash = winner.hash;
      }
      if (!holds) bounds.branches[branch] = plane_simd::least_of(leaves, branch_leaves);
    }
    if (best) return best;
  }
}

}  // namespace noiseloom
