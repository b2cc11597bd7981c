// Files that other programs have written to: read, with a word about it, and not resumed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstdlib>
#include <functional>

#include "noiseloom/files/generations.h"
#include "noiseloom/files/run_file.h"
#include "support/sample_run_file.h"

namespace noiseloom {
namespace {

using testing::HasSubstr;

class ChangedFile : public testing::Test {
 protected:
  void SetUp() override { write_sample_file(posix_file_ops(), path_, content_); }

  // As any program that uses HDF5 would.
  void edit(const std::function<void(hid_t)>& body) const {
    const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    body(file);
    H5Fclose(file);
  }
  static void add_text(hid_t file, const char* object, const char* name, const char* value) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    const hid_t space = H5Screate(H5S_SCALAR);
    if (H5Aexists_by_name(file, object, name, H5P_DEFAULT) > 0) H5Adelete_by_name(file, object, name, H5P_DEFAULT);
    const hid_t attribute = H5Acreate_by_name(file, object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(H5Awrite(attribute, type, &value), 0);
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
  }
  static void add_list(hid_t file, const char* object, const char* name) {
    const hsize_t size = 3;
    const double values[] = {1, 2, 3};
    const hid_t space = H5Screate_simple(1, &size, nullptr);
    const hid_t attribute =
        H5Acreate_by_name(file, object, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(H5Awrite(attribute, H5T_NATIVE_DOUBLE, values), 0);
    H5Aclose(attribute);
    H5Sclose(space);
  }

  // Every slice as it was written, and a word; refused where a run would go on from it.
  void expect_readable() const {
    const RunFileReader reader(path_, Changed::accepted);
    EXPECT_THAT(reader.change(), HasSubstr("another program"));
    EXPECT_EQ(reader.content().extents, content_.extents);
    EXPECT_EQ(reader.content().config, content_.config);
    for (const SliceDataset& dataset : content_.datasets) {
      const int there = reader.dataset(dataset.name);
      ASSERT_GE(there, 0) << dataset.name;
      const auto index = static_cast<int>(&dataset - content_.datasets.data());
      for (const SliceIndex slice : content_.extents.slices()) {
        const std::vector<std::byte> expected = sample_slice(content_, index, slice, 0);
        std::vector<std::byte> found(expected.size());
        reader.read_slice(there, slice, found);
        EXPECT_EQ(found, expected) << dataset.name << " " << slice;
      }
    }
    EXPECT_THROW(RunFileReader{path_}, ChangedRunFile);
    std::filesystem::copy_file(path_, path_ + ".prev", std::filesystem::copy_options::overwrite_existing);
    EXPECT_THROW(open_newest_generation(path_), ChangedRunFile);  // the user decides which of the two it is
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "run.h5";
  RunFileContent content_ = sample_content();
};

TEST_F(ChangedFile, AsItWasWrittenNeedsNoWord) {
  const RunFileReader reader(path_, Changed::accepted);
  EXPECT_EQ(reader.change(), "");
}

TEST_F(ChangedFile, AnAddedAttributeOfARootOrADataset) {
  edit([](hid_t file) {
    add_text(file, "/", "author", "somebody");
    add_list(file, "/samples", "histogram");
  });
  expect_readable();
}

TEST_F(ChangedFile, AttributesAmongThoseThatNoiseloomReads) {
  edit([](hid_t file) {
    add_text(file, "/provenance", "version", "a much longer text than what was there before");
    add_list(file, "/provenance", "quality");
    add_list(file, "/state", "note");
    add_list(file, "/checksum", "note");
  });
  expect_readable();
  const RunFileReader reader(path_, Changed::accepted);
  EXPECT_EQ(reader.content().provenance.at("version"), Attribute("a much longer text than what was there before"));
  EXPECT_FALSE(reader.content().provenance.contains("quality"));
}

TEST_F(ChangedFile, ADatasetThatNoiseloomDoesNotKnow) {
  edit([](hid_t file) {
    const hsize_t size = 4;
    const hid_t space = H5Screate_simple(1, &size, nullptr);
    H5Dclose(H5Dcreate2(file, "/mine", H5T_NATIVE_INT, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    H5Sclose(space);
  });
  expect_readable();
}

TEST_F(ChangedFile, Repacked) {
  if (std::system("command -v h5repack >/dev/null") != 0) GTEST_SKIP() << "needs h5repack (hdf5-tools)";
  const std::string good = read_bytes(path_);
  for (const std::string options : {"", "-f GZIP=6", "-f SHUF -f GZIP=1", "-l CHUNK=1x1x5x7x3 -f GZIP=9"}) {
    SCOPED_TRACE("h5repack " + options);
    write_bytes(path_, good);
    const std::string command = "h5repack " +
                                (options.find("CHUNK") == std::string::npos ? options : "-l /samples:CHUNK=1x1x5x7x3") +
                                " " + path_ + " " + path_ + ".new && mv " + path_ + ".new " + path_;
    ASSERT_EQ(std::system(command.c_str()), 0);
    expect_readable();
  }
}

// Smaller than it was, but not cut off.
TEST_F(ChangedFile, RepackedSmaller) {
  if (std::system("command -v h5repack >/dev/null") != 0) GTEST_SKIP() << "needs h5repack (hdf5-tools)";
  content_.extents = Extents({70, 50, 3, 2});
  write_sample_file(posix_file_ops(), path_, content_);
  const auto before = std::filesystem::file_size(path_);
  ASSERT_EQ(
      std::system(("h5repack -f GZIP=9 " + path_ + " " + path_ + ".new && mv " + path_ + ".new " + path_).c_str()), 0);
  ASSERT_LT(std::filesystem::file_size(path_), before);
  expect_readable();
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) - 1);
  EXPECT_THROW(RunFileReader{path_}, DamagedRunFile);
  EXPECT_THROW(RunFileReader(path_, Changed::accepted), DamagedRunFile);
}

TEST_F(ChangedFile, ChangedSamplesAreDamage) {
  edit([](hid_t file) {
    const hid_t dataset = H5Dopen2(file, "/samples", H5P_DEFAULT);
    std::vector<float> values(7 * 5 * 3 * 2 * 3, 0.5F);
    EXPECT_GE(H5Dwrite(dataset, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
    H5Dclose(dataset);
    add_text(file, "/", "author", "somebody");
  });
  EXPECT_THROW(RunFileReader(path_, Changed::accepted), DamagedRunFile);
  EXPECT_THROW(RunFileReader{path_}, DamagedRunFile);
}

// A few hundred bytes that claim to be the largest texture.
TEST_F(ChangedFile, AClaimThatTheFileCannotHoldTakesNoMemory) {
  edit([](hid_t file) {
    const hsize_t size = hsize_t{1} << 40;
    const hsize_t chunk = 1 << 16;
    const hid_t space = H5Screate_simple(1, &size, nullptr);
    const hid_t list = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(list, 1, &chunk);
    H5Ldelete(file, "/history/R", H5P_DEFAULT);
    H5Dclose(H5Dcreate2(file, "/history/R", H5T_IEEE_F64LE, space, H5P_DEFAULT, list, H5P_DEFAULT));
    H5Pclose(list);
    H5Sclose(space);
  });
  EXPECT_THROW(RunFileReader(path_, Changed::accepted), DamagedRunFile);
}

}  // namespace
}  // namespace noiseloom
