// On a torus no place is special: energies move with the pattern.
#include <gtest/gtest.h>

#include <vector>

#include "construct/fields/vac_field.h"
#include "construct/fields/vac_kernel.h"
#include "support/vac_specs.h"

namespace noiseloom {
namespace {

// How many pixels have another energy after the start pattern has been shifted than before.
int energies_changed_by_shift(const VacSpec& spec, const std::vector<std::int64_t>& by) {
  const VacKernel kernel(spec);
  VacField before(spec, kernel, 0, spec.extents.num_slices());
  VacField after(spec, kernel, 0, spec.extents.num_slices());
  std::vector<std::uint64_t> points = vac_start_pattern(spec);
  before.turn(true, points);
  for (std::uint64_t& p : points) p = testing_support::shifted(spec.extents, p, by);
  std::sort(points.begin(), points.end());
  after.turn(true, points);
  int changed = 0;
  for (std::uint64_t p = 0; p < static_cast<std::uint64_t>(spec.extents.num_cells()); ++p)
    changed += before.word(p) != after.word(testing_support::shifted(spec.extents, p, by)) ? 1 : 0;
  return changed;
}

TEST(Torus, AShiftChangesNoEnergy) {
  for (const auto& groups : std::vector<std::vector<std::vector<int>>>{
           {{0, 1}, {2, 3}}, {{0, 1}, {2}, {3}}, {{0, 1, 2, 3}}, {{1, 3}, {0}}}) {
    VacSpec spec = testing_support::vac_spec({13, 11, 5, 7}, groups);
    EXPECT_EQ(energies_changed_by_shift(spec, {5, 0, 0, 0}), 0);
    EXPECT_EQ(energies_changed_by_shift(spec, {12, 7, 4, 3}), 0);
    spec.toroidal = {true, false, true, true};
    EXPECT_EQ(energies_changed_by_shift(spec, {5, 0, 3, 2}), 0);
    EXPECT_GT(energies_changed_by_shift(spec, {0, 6, 0, 0}), 0);  // an edge that moves is felt
  }
}

}  // namespace
}  // namespace noiseloom
