// Threads and ranks that pick apart pick what one selector picks among all, in its order.
#include "construct/order/vac_selection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "support/vac_specs.h"

namespace noiseloom {
namespace {

using namespace testing_support;

// Pixels drawn at random. The fewer energies there are, the more candidates tie.
std::vector<VacCandidate> draw_candidates(const VacSpec& spec, const VacKernel& kernel, double share,
                                          std::uint32_t num_energies, bool hash_ties, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<VacCandidate> result;
  const auto step = static_cast<std::uint32_t>(kernel.weight_sum() / 2 / num_energies);
  for (std::uint64_t p = 0; p < static_cast<std::uint64_t>(spec.extents.num_cells()); ++p) {
    if (static_cast<double>(random() % 1000) >= 1000 * share) continue;
    const auto energy = static_cast<std::uint32_t>(random() % num_energies) * step;
    result.push_back({p, energy, hash_ties ? 5 : static_cast<std::uint32_t>(random())});
  }
  return result;
}

std::vector<VacPick> pick_alone(const VacSpec& spec, const VacKernel& kernel, VacView view,
                                std::span<const VacCandidate> candidates, std::uint64_t limit) {
  VacSelector selector(spec, kernel);
  selector.begin(view, candidates, 0, candidates.size(), limit);
  selector.pick();
  EXPECT_TRUE(selector.waiting().empty());
  return selector.picks();
}

void expect_the_same_apart(const VacSpec& spec, const Communicator& world) {
  SCOPED_TRACE(spec.extents.to_string());
  const VacKernel kernel(spec);
  const Partition partition(spec.extents.num_slices(), world.size());
  const auto cells = static_cast<std::uint64_t>(spec.extents.cells_per_slice());
  VacExchange exchange(world);
  const std::uint64_t limit = (std::uint64_t{kernel.weight_sum() / 2} << 32) | 0xFFFFFFFFU;
  for (const int threads : {1, 2, 3}) {
    ThreadPool pool(1 + (world.rank().value() + threads) % 3);  // ranks need not have as many
    VacSelection selection(spec, kernel, partition, world.rank().value(), exchange, pool, 1);
    std::uint64_t seed = 0;
    for (const VacView view : {VacView::voids, VacView::clusters}) {
      for (const bool hash_ties : {false, true}) {
        for (const double share : {spec.extents.num_cells() > 100'000 ? 0.01 : 0.4, 0.03, 0.0}) {
          const auto candidates = draw_candidates(spec, kernel, share, hash_ties ? 4 : 100'000, hash_ties, ++seed);
          const auto expected = pick_alone(spec, kernel, view, candidates, limit);
          for (const std::size_t most : {candidates.size(), expected.size() / 2}) {
            VacPortion picks;
            selection.take(view, candidates, limit, most, picks);
            ASSERT_EQ(picks.positions.size(), expected.size());
            std::vector<std::uint32_t> number(candidates.size());
            for (std::uint32_t n = 0; n < expected.size(); ++n) number[expected[n].index(view)] = n;
            const bool all_numbers = most < expected.size();
            for (std::size_t i = 0; i < picks.positions.size(); ++i) {
              const std::uint64_t position = picks.positions[i];
              const auto at = std::ranges::lower_bound(candidates, position, {}, &VacCandidate::position);
              ASSERT_EQ(at->position, position);
              ASSERT_TRUE(i == 0 || picks.positions[i - 1] < position);
              const auto slice = static_cast<std::int32_t>(position / cells);
              if (!all_numbers && partition.part_of(slice) != world.rank().value()) continue;
              ASSERT_EQ(picks.numbers[i], number[static_cast<std::size_t>(at - candidates.begin())]) << position;
            }
          }
        }
      }
    }
  }
}

TEST(VacSelection, PicksWhatOneSelectorPicksAmongAll) {
  const Communicator world = Communicator::world();
  expect_the_same_apart(vac_spec({17, 13}, {{0, 1}}, 1.5), world);  // one slice
  expect_the_same_apart(vac_spec({13, 11, 9}, {{0, 1}, {2}}), world);
  expect_the_same_apart(vac_spec({40, 33, 6}, {{0, 1}, {2}}, 1.3), world);
  expect_the_same_apart(vac_spec({7, 5, 5, 11}, {{0, 1}, {2, 3}}), world);
  expect_the_same_apart(vac_spec({7, 5, 11, 3}, {{0, 1}, {2}, {3}}), world);
  expect_the_same_apart(vac_spec({5, 3, 37}, {{2}}, 1.3), world);  // no group within slices
  expect_the_same_apart(vac_spec({9, 8, 12}, {{0}, {1}, {2}}), world);
  expect_the_same_apart(vac_spec({11, 7, 9}, {{0, 1, 2}}, 1.2), world);  // not divided
  VacSpec open = vac_spec({9, 8, 7, 6}, {{0, 1}, {2, 3}});
  open.toroidal = {true, false, false, true};
  expect_the_same_apart(open, world);
}

// Otherwise the other test would show nothing.
TEST(VacSelector, LetsFewWaitForOthersWhereSlicesTouchLittle) {
  const VacSpec spec = vac_spec({64, 64, 16}, {{0, 1}, {2}});
  const VacKernel kernel(spec);
  const auto candidates = draw_candidates(spec, kernel, 0.01, 100'000, false, 1);
  const std::uint64_t limit = std::uint64_t{kernel.weight_sum() / 2} << 32;
  const auto half = static_cast<std::size_t>(
      std::ranges::lower_bound(candidates, 64U * 64U * 8U, {}, &VacCandidate::position) - candidates.begin());
  std::size_t num_waiting = 0;
  std::size_t num_picks = 0;
  for (const bool first : {true, false}) {
    VacSelector selector(spec, kernel);
    selector.begin(VacView::voids, candidates, first ? 0 : half, first ? half : candidates.size(), limit);
    selector.pick();
    num_waiting += selector.waiting().size();
    num_picks += selector.picks().size();
  }
  EXPECT_GT(num_waiting, 0U);
  EXPECT_LT(num_waiting, num_picks / 4);
}

}  // namespace
}  // namespace noiseloom
