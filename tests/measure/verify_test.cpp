// What verify says of numbers that are not the library's (tests/program/verify_test.py has the many kinds).
#include "noiseloom/measure/verify.h"

#include <gmock/gmock.h>

#include "noiseloom/core/random.h"

namespace noiseloom {
namespace {

using testing::Contains;
using testing::Field;
using testing::Not;

// White noise as codes of 8 bits, in `channels` channels R, G, ...
StoredTexture white_codes(int channels, std::int32_t slices) {
  StoredTexture stored;
  stored.texture = make_texture(Extents({32, 32, slices}), channels);
  for (std::size_t i = 0; i < stored.texture.values.size(); ++i) {
    const std::uint32_t code = random_block(7, Purpose::subset, 0, 0, i)[0] >> 24;
    stored.texture.values[i] = (static_cast<float>(code) + 0.5F) / 256;
  }
  for (int c = 0; c < channels; ++c) stored.channel_names.emplace_back(1, "RGBA"[c]);
  stored.codes = true;
  stored.step = 1.0 / 256;
  stored.source = "codes";
  return stored;
}

Verification verified(const StoredTexture& stored, const std::string& path = "noise.png") {
  ThreadPool pool(1);
  return verify_texture(stored, path, false, pool);
}

auto fault(const std::string& kind) {
  return testing::AllOf(Field(&Finding::kind, kind), Field(&Finding::is_fault, true));
}

TEST(Verify, FindsThatNoiseIsWhiteAndNothingElse) {
  for (const int channels : {1, 2, 3}) {
    const Verification found = verified(white_codes(channels, 8));
    EXPECT_EQ(found.samples.space, channels == 1 ? "uniform" : channels == 2 ? "vector2" : "vector3");
    ASSERT_THAT(found.findings, Contains(fault("white")));
    EXPECT_EQ(std::count_if(found.findings.begin(), found.findings.end(), [](const Finding& f) { return f.is_fault; }),
              1);
  }
}

TEST(Verify, NamesSlicesThatRepeat) {
  StoredTexture stored = white_codes(2, 8);
  std::copy_n(stored.texture.slice(SliceIndex(2)), stored.texture.floats_per_slice(),
              stored.texture.slice(SliceIndex(6)));
  EXPECT_THAT(verified(stored).findings, Contains(fault("repeated-slices")));
  EXPECT_THAT(verified(white_codes(2, 8)).findings, Not(Contains(fault("repeated-slices"))));
}

TEST(Verify, TakesTheWordOfANameForWhatItWasMadeFor) {
  EXPECT_THAT(verified(white_codes(1, 8), "stbn_vec1_2Dx1D_32x32x8_{}.png").findings, Contains(fault("white-in-time")));
  EXPECT_THAT(verified(white_codes(1, 8)).findings, Not(Contains(fault("white-in-time"))));
}

// What a file says of itself counts more than its name. Noise that says that it ends somewhere is noise all the same.
TEST(Verify, TakesAnAxisForWhatTheConfigSays) {
  StoredTexture stored = white_codes(1, 8);
  stored.config.emplace();
  ProblemSpec& problem = stored.config->problem;
  problem.extents = stored.texture.extents;
  GroupSpec group;
  group.axes = {0, 1, 2};
  group.kernel.kind = KernelKind::gauss_energy;
  problem.filter.groups = {group};
  const std::string name = "stbn_vec1_2Dx1D_32x32x8_{}.png";
  EXPECT_THAT(verified(stored, name).findings, Contains(fault("white-in-time")));
  stored.config->order.bounded = {2};
  EXPECT_THAT(verified(stored, name).findings, Contains(fault("white")));
  stored.config->order.bounded.clear();
  problem.filter.groups[0].kernel.tile_axes = {2};
  EXPECT_THAT(verified(stored, name).findings, Not(Contains(fault("white-in-time"))));
  EXPECT_THAT(verified(stored, name).findings, Contains(fault("white")));
}

TEST(Verify, SaysWhereAllIsOneValue) {
  StoredTexture stored = white_codes(1, 1);
  std::fill(stored.texture.values.begin(), stored.texture.values.end(), 0.5F);
  const Verification found = verified(stored);
  EXPECT_THAT(found.findings, testing::ElementsAre(fault("constant")));
  EXPECT_FALSE(found.is_sound());
  EXPECT_THAT(verification_json(found, stored, "a.png"), testing::HasSubstr("\"sound\": false"));
}

}  // namespace
}  // namespace noiseloom
