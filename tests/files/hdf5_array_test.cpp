// Datasets of HDF5 files that others made.
#include "noiseloom/files/hdf5_array.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include "support/sample_run_file.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string message_of(const std::string& name) {
  try {
    read_hdf5_array(name);
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

// A file of datasets, closed at the end of the scope.
class Made {
 public:
  explicit Made(const std::string& path) : file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)) {}
  ~Made() { H5Fclose(file_); }
  Made(const Made&) = delete;
  Made& operator=(const Made&) = delete;

  void group(const char* name) { H5Gclose(H5Gcreate2(file_, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)); }
  void dataset(const char* name, hid_t type, std::vector<hsize_t> shape, const std::vector<double>& values,
               std::vector<hsize_t> chunk = {}) {
    const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
    const hid_t list = H5Pcreate(H5P_DATASET_CREATE);
    if (!chunk.empty()) {
      H5Pset_chunk(list, static_cast<int>(chunk.size()), chunk.data());
      H5Pset_deflate(list, 6);
    }
    const hid_t dataset = H5Dcreate2(file_, name, type, space, H5P_DEFAULT, list, H5P_DEFAULT);
    if (!values.empty()) H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(dataset);
    H5Pclose(list);
    H5Sclose(space);
  }

 private:
  hid_t file_;
};

std::vector<double> numbers(int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(i * 3 % 127);
  return values;
}

TEST(Hdf5Array, ReadsEveryNumberType) {
  const TemporaryFolder folder;
  const std::vector<double> values = numbers(15);
  const std::pair<hid_t, NumberType> types[] = {{H5T_IEEE_F32LE, {NumberType::Kind::floating, 4, false}},
                                                {H5T_IEEE_F64BE, {NumberType::Kind::floating, 8, true}},
                                                {H5T_STD_U8LE, {NumberType::Kind::unsigned_integer, 1, false}},
                                                {H5T_STD_I16BE, {NumberType::Kind::signed_integer, 2, true}},
                                                {H5T_STD_U64LE, {NumberType::Kind::unsigned_integer, 8, false}}};
  for (const auto& [type, expected] : types) {
    {
      Made file(folder / "a.h5");
      file.group("noise");
      file.dataset("noise/blue", type, {3, 5}, values);
      file.dataset("times", H5T_IEEE_F64LE, {4}, numbers(4));
    }
    for (const std::string& name : {folder / "a.h5:/noise/blue", folder / "a.h5"}) {
      const Hdf5Array array = read_hdf5_array(name);
      EXPECT_EQ(array.shape, (std::vector<std::int64_t>{3, 5})) << name;
      EXPECT_EQ(array.values, values);
      EXPECT_EQ(array.type.bytes, expected.bytes);
      EXPECT_EQ(array.type.kind, expected.kind);
    }
  }
}

TEST(Hdf5Array, ReadsChunksThatWereCompressed) {
  const TemporaryFolder folder;
  const std::vector<double> values = numbers(7 * 11 * 2);
  Made(folder / "a.h5").dataset("a", H5T_IEEE_F32LE, {7, 11, 2}, values, {4, 4, 1});
  EXPECT_EQ(read_hdf5_array(folder / "a.h5:/a").values, values);
  EXPECT_EQ(hdf5_array_shape(folder / "a.h5"), (std::vector<std::int64_t>{7, 11, 2}));
}

TEST(Hdf5Array, ListsWhatThereIs) {
  const TemporaryFolder folder;
  {
    Made file(folder / "a.h5");
    file.group("g");
    file.dataset("g/one", H5T_IEEE_F32LE, {3, 5}, numbers(15));
    file.dataset("two", H5T_STD_U8LE, {4, 2, 7}, numbers(56));
    file.dataset("line", H5T_IEEE_F32LE, {9}, numbers(9));
  }
  const auto both = AllOf(HasSubstr("a.h5:/g/one (3 x 5)"), HasSubstr("a.h5:/two (4 x 2 x 7)"), Not(HasSubstr("line")));
  EXPECT_THAT(message_of(folder / "a.h5"), both);
  EXPECT_THAT(message_of(folder / "a.h5:/g/none"), AllOf(HasSubstr("no dataset /g/none"), both));
  EXPECT_THAT(message_of(folder / "a.h5:/g"), HasSubstr("no dataset /g"));
}

TEST(Hdf5Array, RefusesWhatHoldsNoNumbers) {
  const TemporaryFolder folder;
  {
    Made file(folder / "a.h5");
    file.dataset("unwritten", H5T_IEEE_F32LE, {300, 500}, {}, {10, 10});
    file.dataset("text", H5T_C_S1, {3, 5}, {});
  }
  EXPECT_THAT(message_of(folder / "a.h5:/unwritten"), HasSubstr("none were ever written"));
  EXPECT_THAT(message_of(folder / "a.h5:/text"), HasSubstr("no array of plain numbers"));
  write_bytes(folder / "b.h5", "\x89HDF\r\n\x1a\n and then nothing");
  EXPECT_THAT(message_of(folder / "b.h5"), HasSubstr("cannot be read as HDF5 either"));
  EXPECT_FALSE(split_dataset_name(folder / "none.h5:/a"));
}

TEST(Hdf5Array, RefusesClaimsBeyondWhatIsStored) {
  const TemporaryFolder folder;
  {
    // One chunk of a claimed 160 GB is written.
    Made file(folder / "a.h5");
    file.dataset("a", H5T_IEEE_F32LE, {200000, 200000}, {}, {16, 16});
  }
  const hid_t file = H5Fopen((folder / "a.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, "a", H5P_DEFAULT);
  const hid_t space = H5Dget_space(dataset);
  const hsize_t start[] = {0, 0};
  const hsize_t count[] = {16, 16};
  H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr);
  const hid_t memory = H5Screate_simple(2, count, nullptr);
  const std::vector<double> values = numbers(256);
  H5Dwrite(dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values.data());
  H5Sclose(memory);
  H5Sclose(space);
  H5Dclose(dataset);
  H5Fclose(file);
  EXPECT_THAT(message_of(folder / "a.h5:/a"), HasSubstr("200000 x 200000 claims 160000000000 bytes"));
}

}  // namespace
}  // namespace noiseloom
