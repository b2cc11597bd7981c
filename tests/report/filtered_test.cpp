#include "noiseloom/report/filtered.h"

#include <gtest/gtest.h>

#include "support/run_files.h"

namespace noiseloom {
namespace {

TEST(FilteredError, IsThatOfAPlainBoxFilter) {
  const RunConfig config = small_config("uniform", "x = 16, y = 16");
  const Texture texture = start_texture(config);
  const FilteredError error =
      filtered_error(texture, SliceIndex(0), Footprint(config.problem.extents, config.problem.filter));
  std::vector<double> step;
  for (const float v : texture.values) step.push_back(v < 0.5F ? 1 : 0);  // stratified: the median lies at 1/2
  const auto filtered_square = [](const std::vector<double>& values) {
    double sum = 0;
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x) {
        double mean = 0;
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx)
            mean += values[static_cast<std::size_t>((y + dy + 16) % 16 * 16 + (x + dx + 16) % 16)] / 9;
        sum += (mean - 0.5) * (mean - 0.5);
      }
    return sum;
  };
  const Permutation order = start_permutation(1, SliceIndex(0), 256);
  std::vector<double> shuffled;
  for (const SampleId id : order) shuffled.push_back(step[id.value()]);
  EXPECT_NEAR(error.ratio, filtered_square(step) / filtered_square(shuffled), 1e-9);
}

}  // namespace
}  // namespace noiseloom
