// What a run was made from, in its run file.
#include <gtest/gtest.h>

#include "noiseloom/files/run_file.h"
#include "support/sample_run_file.h"

namespace noiseloom {
namespace {

TEST(RunFileInputs, ComeBackAsTheyWere) {
  const TemporaryFolder folder;
  RunFileContent content = sample_content();
  content.inputs = {
      {"texture.samples.file", "a b.npy",
       std::make_shared<const InputArray>(InputArray{{2, 1, 3}, std::vector<float>{1, 2, 3, -4, 5.5F, 0}})},
      {"filter.groups[1].file", "../taps.npy",
       std::make_shared<const InputArray>(InputArray{{2}, std::vector<double>{0.1, 1e-200}})}};
  write_sample_file(posix_file_ops(), folder / "run.h5", content);
  const RunFileReader reader(folder / "run.h5");
  ASSERT_EQ(reader.content().inputs.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(reader.content().inputs[i].key, content.inputs[i].key);
    EXPECT_EQ(reader.content().inputs[i].file, content.inputs[i].file);
    EXPECT_EQ(*reader.content().inputs[i].array, *content.inputs[i].array);
  }
}

}  // namespace
}  // namespace noiseloom
