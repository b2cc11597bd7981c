// The files that a config names, read once and kept.
#include "noiseloom/config/inputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "noiseloom/files/npy.h"
#include "support/sample_run_file.h"

namespace noiseloom {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* text = R"([texture]
size = { x = 2, y = 2 }
samples = { file = "mine.npy" }
[filter]
groups = [ { axes = "x", kernel = "box", size = 3 }, { axes = "y", kernel = "table", file = "taps.npy" } ]
)";

class Inputs : public testing::Test {
 protected:
  void SetUp() override {
    write_npy(folder_ / "mine.npy", std::vector<std::int64_t>{4}, std::vector<float>{3, 1, 4, 1.5F});
    write_npy(folder_ / "taps.npy", std::vector<std::int64_t>{3}, std::vector<float>{1, 2, 1});
  }
  RunConfig config(const std::vector<std::string>& overrides = {}) const {
    return parse_config(text, "run.toml", folder_.path(), overrides, MissingFiles::accepted);
  }
  RunConfig read(const std::vector<std::string>& overrides = {}) const {
    RunConfig result = config(overrides);
    read_inputs(result);
    return result;
  }
  void remove(const char* name) const { std::filesystem::remove(folder_ / name); }

  TemporaryFolder folder_;
};

std::vector<std::string> names(const std::vector<RunFileInput>& inputs) {
  std::vector<std::string> all;
  for (const RunFileInput& input : inputs) all.push_back(input.key + " of " + input.file);
  return all;
}

TEST_F(Inputs, AreNamedByTheirKeysAndAsTheConfigSpellsThem) {
  EXPECT_THAT(inputs_of(config()), IsEmpty());
  const std::vector<RunFileInput> inputs = inputs_of(read());
  EXPECT_THAT(names(inputs), ElementsAre("texture.samples.file of mine.npy", "filter.groups[1].file of taps.npy"));
  EXPECT_EQ(*inputs[0].array, (InputArray{{4}, std::vector<float>{3, 1, 4, 1.5F}}));
  EXPECT_EQ(*inputs[1].array, (InputArray{{3}, std::vector<double>{1, 2, 1}}));
}

TEST_F(Inputs, FaultsOfAllFilesComeTogether) {
  remove("mine.npy");
  write_bytes(folder_ / "taps.npy", "no array");
  try {
    read();
    ADD_FAILURE() << "was accepted";
  } catch (const UserError& error) {
    EXPECT_EQ(error.faults().size(), 2U);
    EXPECT_THAT(error.what(), HasSubstr("mine.npy: cannot be opened"));
    EXPECT_THAT(error.what(), HasSubstr("taps.npy: not a .npy file"));
  }
}

TEST_F(Inputs, AreTakenFromARunFileWithoutTheFiles) {
  const std::vector<RunFileInput> stored = inputs_of(read());
  remove("mine.npy");
  remove("taps.npy");
  RunConfig again = config();
  take_inputs(again, stored, "run.h5");
  read_inputs(again);
  EXPECT_EQ(again.problem.samples.array, stored[0].array);
  EXPECT_EQ(again.problem.filter.groups[1].kernel.array, stored[1].array);
}

TEST_F(Inputs, AFileOfAnotherNameIsReadAnew) {
  const std::vector<RunFileInput> stored = inputs_of(read());
  write_npy(folder_ / "other.npy", std::vector<std::int64_t>{2}, std::vector<float>{1, 5});
  RunConfig other = config({"filter.groups[1].file=other.npy"});
  take_inputs(other, stored, "run.h5");
  EXPECT_EQ(other.problem.filter.groups[1].kernel.array, nullptr);
  read_inputs(other);
  EXPECT_EQ(*other.problem.filter.groups[1].kernel.array, (InputArray{{2}, std::vector<double>{1, 5}}));
  EXPECT_EQ(other.problem.samples.array, stored[0].array);
}

TEST_F(Inputs, OfAnotherTypeAreRefusedByTheRunFilesName) {
  std::vector<RunFileInput> stored = inputs_of(read());
  stored[0].array = std::make_shared<const InputArray>(InputArray{{4}, std::vector<double>{1, 2, 3, 4}});
  RunConfig again = config();
  try {
    take_inputs(again, stored, "run.h5");
    ADD_FAILURE() << "was accepted";
  } catch (const UserError& error) {
    EXPECT_STREQ(error.what(), "run.h5: /inputs/texture.samples.file: holds float64, but must be float32");
  }
}

TEST_F(Inputs, ThatHaveChangedAreNamed) {
  const RunConfig begun = read();
  EXPECT_THAT(changed_inputs(begun), IsEmpty());
  write_npy(folder_ / "taps.npy", std::vector<std::int64_t>{1, 3}, std::vector<float>{1, 2, 1});
  EXPECT_THAT(changed_inputs(begun), ElementsAre("taps.npy"));
  remove("taps.npy");
  EXPECT_THAT(changed_inputs(begun), IsEmpty()) << "what is not there has not changed";
}

TEST_F(Inputs, NegativeTapsAreToldOf) {
  EXPECT_THAT(notes_on_inputs(read()), IsEmpty());
  write_npy(folder_ / "taps.npy", std::vector<std::int64_t>{3}, std::vector<float>{-0.5F, 2, -0.5F});
  EXPECT_THAT(notes_on_inputs(read()),
              ElementsAre(testing::Field(&InputNote::text,
                                         HasSubstr("filter.groups[1].file = \"taps.npy\": 2 of 3 taps are negative"))));
}

TEST_F(Inputs, ValuesThatFloatCannotComeNearAreRefused) {
  const std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,)}";
  for (const auto& [value, words] : {std::pair{1e300, "value 1 = 1e+300: too large for float32"},
                                     std::pair{-1e-300, "value 1 = -1e-300: too small for float32"}}) {
    const double values[] = {1, value};
    std::string bytes = std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size()) + '\0' + header;
    bytes.append(reinterpret_cast<const char*>(values), sizeof(values));
    write_bytes(folder_ / "mine.npy", bytes);
    try {
      read();
      ADD_FAILURE() << "was accepted";
    } catch (const UserError& error) {
      EXPECT_THAT(error.what(), HasSubstr(words));
    }
  }
}

}  // namespace
}  // namespace noiseloom
