#include "noiseloom/anneal/tile_grid.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <numeric>
#include <set>

#include "anneal/texture_fixture.h"
#include "anneal/tile_oracle.h"
#include "noiseloom/anneal/slice_mover.h"

namespace noiseloom {
namespace {

using namespace testing_support;
using test::Texture;

Footprint box_footprint(const Extents& extents, int size) {
  return Footprint(extents, product({group({0, 1}, box(size))}));
}

// Cells of a tile of the slice.
std::vector<Cell> cells_of(const Footprint& footprint, const TileGrid& grid, std::uint32_t sweep, int tile) {
  const FieldLayout slice(footprint, 1);
  const FieldLayout window(footprint, 1, grid.window());
  std::vector<Cell> cells;
  for (Cell cell = 0; cell < window.width * window.height; ++cell) {
    cells.push_back(slice_cell(slice, grid.corner(7, SliceIndex(3), sweep, tile), window, cell));
  }
  return cells;
}

TEST(TileGrid, TilesAreFurtherApartThanTheFootprintReaches) {
  for (const Extents& extents : {Extents({131, 97}), Extents({256, 67}), Extents({509, 311})}) {
    const Footprint footprint = box_footprint(extents, 4);
    const TileGrid grid(footprint, 1);
    ASSERT_GT(grid.num_tiles(), 1) << extents.to_string();
    for (std::uint32_t sweep = 0; sweep < 5; ++sweep) {
      std::vector<int> tile_of(static_cast<std::size_t>(extents.cells_per_slice()), -1);
      for (int tile = 0; tile < grid.num_tiles(); ++tile) {
        for (const Cell cell : cells_of(footprint, grid, sweep, tile)) {
          ASSERT_EQ(tile_of[static_cast<std::size_t>(cell)], -1);
          tile_of[static_cast<std::size_t>(cell)] = tile;
        }
      }
      EXPECT_FALSE(test::a_tap_joins_two_tiles(footprint, tile_of)) << extents.to_string();
    }
  }
}

TEST(TileGrid, EveryCellMovesSoonerOrLater) {
  const Footprint footprint = box_footprint(Extents({131, 97}), 5);
  const TileGrid grid(footprint, 1);
  std::set<Cell> moved;
  for (std::uint32_t sweep = 0; sweep < 12; ++sweep) {
    for (int tile = 0; tile < grid.num_tiles(); ++tile) {
      for (const Cell cell : cells_of(footprint, grid, sweep, tile)) moved.insert(cell);
    }
  }
  EXPECT_EQ(std::ssize(moved), footprint.extents().cells_per_slice());
}

TEST(TileGrid, StaysWholeWhereTilesWouldLeaveLittle) {
  EXPECT_EQ(TileGrid(box_footprint(Extents({63, 63}), 3), 1).num_tiles(), 1);
  EXPECT_EQ(TileGrid(box_footprint(Extents({128, 128, 64}), 5), 16).num_tiles(), 1);
  EXPECT_EQ(TileGrid(box_footprint(Extents({128, 128}), 40), 1).num_tiles(), 1);
  EXPECT_EQ(TileGrid(box_footprint(Extents({1, 1}), 3), 1).num_tiles(), 1);
}

TEST(TileGrid, TilesOfLargeSlicesFitTheCaches) {
  const TileGrid grid(box_footprint(Extents({4096, 4096}), 5), 1);
  EXPECT_LE(grid.window().width * grid.window().height, 20'000);
  EXPECT_GT(grid.window().width * grid.window().height * grid.num_tiles(), 4096 * 4096 * 9 / 10);
}

// A window of 9x7 in 23x19, across the edges of the torus; with slices coupled in every way.
class Windows : public ::testing::TestWithParam<Precision> {
 protected:
  static std::vector<FilterSpec> filters() {
    return {product({group({0, 1}, gauss(0.8)), group({2}, box(2))}),
            sum({group({0, 1}, box(3)), group({2}, ema(0.1, 0.1))}), product({group({0, 1, 2}, gauss_energy(1.1))})};
  }
};

TEST_P(Windows, JudgeSwapsAsTheWholeSliceDoes) {
  const Extents extents({23, 19, 3});
  for (const FilterSpec& filter : filters()) {
    const Footprint footprint(extents, filter);
    for (const test::Space& space : {test::all_spaces()[0], test::all_spaces()[4]}) {
      const ValueKernel kernel = test::kernel_of(space, ValueKernelKind::distance, 3);
      const Texture texture(footprint, kernel, 5);
      const auto whole = make_swap_delta(footprint, kernel, GetParam());
      whole->bind(SliceIndex(1), texture.field(SliceIndex(1)), texture.field_of());
      for (const WindowSize size : {WindowSize{9, 7}, WindowSize{23, 7}, WindowSize{9, 19}}) {
        const auto part = make_swap_delta(footprint, kernel, GetParam(), nullptr, size);
        const Corner corner{size.width == 23 ? 0 : 20, size.height == 19 ? 0 : 15};
        part->bind(SliceIndex(1), corner, texture.field(SliceIndex(1)), texture.field_of());
        const auto in_slice = [&](Cell cell) {
          return slice_cell(texture.field(SliceIndex(1)).layout(), corner, part->layout(), cell);
        };
        const Cell cells = size.width * size.height;
        for (Cell i = 0; i < cells; ++i) {
          const Cell j = (i * 5 + 1) % cells;
          if (i == j) continue;
          EXPECT_NEAR(part->delta(test::pair(i, j)), whole->delta(test::pair(in_slice(i), in_slice(j))), 1e-5);
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Both, Windows, ::testing::Values(Precision::float32, Precision::float64),
                         [](const auto& test) { return test.param == Precision::float32 ? "float" : "double"; });

TEST(Windows, WithABackgroundJudgeSwapsAsTheWholeSliceDoes) {
  const Extents extents({23, 19, 8});
  const Footprint footprint(extents, product({group({0, 1}, gauss(0.8)), group({2}, ema(0.1, 0.1))}));
  const ValueKernel kernel = test::kernel_of(test::all_spaces()[0], ValueKernelKind::distance, 3);
  const Texture texture(footprint, kernel, 5);
  std::vector<float> list(static_cast<std::size_t>(extents.cells_per_slice()));
  texture.field(SliceIndex(0)).interleaved(list);
  const FeatureMap map(kernel, 8, list);
  const auto whole = make_swap_delta(footprint, kernel, Precision::float32, &map);
  whole->bind(SliceIndex(1), texture.field(SliceIndex(1)), texture.field_of());
  const WindowSize size{9, 7};
  const auto part = make_swap_delta(footprint, kernel, Precision::float32, &map, size);
  part->bind(SliceIndex(1), {20, 15}, texture.field(SliceIndex(1)), texture.field_of());
  for (Cell i = 1; i < 63; ++i) {
    const auto in_slice = [&](Cell cell) {
      return slice_cell(texture.field(SliceIndex(1)).layout(), {20, 15}, part->layout(), cell);
    };
    EXPECT_NEAR(part->delta(test::pair(0, i)), whole->delta(test::pair(in_slice(0), in_slice(i))), 1e-4);
  }
}

// Cold, so that no swap may raise the energy: neither alone nor with those of the other tiles.
TEST(Tiles, SwapsOfAllTilesTogetherChangeTheEnergyByTheirSum) {
  const Footprint footprint = box_footprint(Extents({83, 71}), 4);
  const ValueKernel kernel = test::kernel_of(test::all_spaces()[0], ValueKernelKind::distance, 2);
  Texture texture(footprint, kernel, 3);
  const TileGrid grid(footprint, 1);
  ASSERT_GT(grid.num_tiles(), 1);
  const Permutation ids = identity_permutation(83 * 71);
  AnnealMover mover(make_swap_delta(footprint, kernel, Precision::float64, nullptr, grid.window()));
  const PartnerDraw partners(grid.window().width * grid.window().height, {8}, false);
  const double start = texture.energy();
  double change = 0;
  std::int64_t candidates = 0;
  std::vector<VisitResult> results;
  for (int tile = 0; tile < grid.num_tiles(); ++tile) {
    const Visit visit{SliceIndex(0), 0, 9, 2, tile, grid.num_tiles(), grid.corner(9, SliceIndex(0), 0, tile)};
    results.push_back(mover.visit(visit, 0, partners, texture.field(SliceIndex(0)), ids, texture.field_of()));
  }
  for (const VisitResult& result : results) {
    EXPECT_GT(result.swaps.size(), 0U);
    change += result.energy;
    candidates += result.candidates;
    for (const Swap& swap : result.swaps) texture.field(SliceIndex(0)).swap(swap.a, swap.b);
  }
  EXPECT_LT(change, 0);
  EXPECT_NEAR(texture.energy() - start, change, 1e-9 * std::abs(start));
  // Two iterations, less the candidates that drew themselves.
  EXPECT_LE(candidates, 83 * 71);
  EXPECT_GT(candidates, 83 * 71 * 9 / 10);
}

TEST(CellsById, AreTheCellsOfTheWindowInTheOrderOfTheirIds) {
  const Footprint footprint = box_footprint(Extents({83, 71}), 4);
  const FieldLayout slice(footprint, 1);
  const FieldLayout window(footprint, 1, {30, 20});
  Permutation permutation(83 * 71);
  for (std::size_t k = 0; k < permutation.size(); ++k) permutation[k] = SampleId(k * 2999 % 5893);
  const Corner corner{70, 60};
  const IndexedVector<SampleId, std::uint32_t> cells = cells_by_id(slice, corner, window, permutation);
  ASSERT_EQ(cells.size(), 600U);
  EXPECT_EQ(std::set<std::uint32_t>(cells.begin(), cells.end()).size(), 600U);
  const auto id = [&](std::uint32_t cell) {
    return permutation[static_cast<std::size_t>(slice_cell(slice, corner, window, cell))];
  };
  for (std::size_t k = 1; k < cells.size(); ++k) {
    EXPECT_LT(id(cells[SampleId(k - 1)]), id(cells[SampleId(k)]));
  }
}

}  // namespace
}  // namespace noiseloom
