#include "run/checkpoints/start_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace noiseloom {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(StartFile, FindsTheIdOfEverySample) {
  const std::vector<float> list = {0.1F, 0.2F, 0.2F, 0.7F};
  EXPECT_THAT(ids_of_arrangement({0.7F, 0.2F, 0.1F, 0.2F}, list, 1),
              ElementsAre(SampleId(3), SampleId(1), SampleId(0), SampleId(2)))
      << "equal ones in order";
  const std::vector<float> pairs = {0, 1, 1, 0, -1, 0.5F};
  EXPECT_THAT(ids_of_arrangement({1, 0, -1, 0.5F, 0, 1}, pairs, 2), ElementsAre(SampleId(1), SampleId(2), SampleId(0)));
}

TEST(StartFile, TakesNoOtherSamples) {
  const std::vector<float> list = {0.1F, 0.2F, 0.2F, 0.7F};
  EXPECT_THAT(ids_of_arrangement({0.7F, 0.2F, 0.1F, 0.1F}, list, 1), IsEmpty()) << "another count of equal ones";
  EXPECT_THAT(ids_of_arrangement({0.7F, 0.2F, 0.1F, 0.20000002F}, list, 1), IsEmpty()) << "another bit";
  EXPECT_THAT(ids_of_arrangement({0.7F, 0.2F}, list, 1), IsEmpty());
}

}  // namespace
}  // namespace noiseloom
