// What a run file holds and that other programs can read it.
#include "noiseloom/files/run_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstdlib>
#include <limits>

#include "noiseloom/files/digest.h"
#include "support/failing_file_ops.h"
#include "support/sample_run_file.h"

namespace noiseloom {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

TEST(Digest, MatchesPublishedValuesAndIgnoresCuts) {
  EXPECT_EQ(to_hex(digest_of({})), "ef46db3751d8e999");  // XXH64 of nothing, seed 0
  const std::string text = "abc";
  const auto bytes = std::as_bytes(std::span(text));
  EXPECT_EQ(to_hex(digest_of(bytes)), "44bc2cf5ad770999");
  Digest pieces;
  pieces.update(bytes.first(1));
  pieces.update(bytes.subspan(1));
  EXPECT_EQ(pieces.value(), digest_of(bytes));
}

TEST(RunFile, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.h5";
  RunFileContent content = sample_content();
  for (int i = 0; i < 23; ++i) content.state["key" + std::to_string(i)] = 1.0 / (i + 1);
  content.state["largest"] = std::numeric_limits<std::int64_t>::max();
  content.provenance["long"] = std::string(100'000, 'x');
  write_sample_file(posix_file_ops(), path, content);

  EXPECT_EQ(sample_generation(path, content, 1), 0);
  const RunFileReader reader(path);
  EXPECT_EQ(reader.content().extents, content.extents);
  EXPECT_EQ(reader.content().config, content.config);
  EXPECT_EQ(reader.content().datasets, content.datasets);
  EXPECT_EQ(reader.content().state, content.state);
  EXPECT_EQ(reader.content().history, content.history);
  EXPECT_EQ(reader.content().provenance, content.provenance);
  EXPECT_EQ(reader.dataset("/order"), 2);
  EXPECT_EQ(reader.dataset("/nothing"), -1);
  EXPECT_THAT(folder.names(), ElementsAre("run.h5"));
}

TEST(RunFile, HoldsATextureWithoutSliceAxesDatasetsOrHistory) {
  const TemporaryFolder folder;
  RunFileContent content;
  content.extents = Extents({3, 2}, {"x", "y"});
  write_sample_file(posix_file_ops(), folder / "empty.h5", content);
  EXPECT_EQ(RunFileReader(folder / "empty.h5").content().config, "");
  EXPECT_TRUE(RunFileReader(folder / "empty.h5").content().history.empty());

  content.datasets = {{"/samples", ElementType::float32, 1, true}};
  content.history = {{"R", {}}, {"seconds", {}}};
  write_sample_file(posix_file_ops(), folder / "flat.h5", content);
  EXPECT_EQ(sample_generation(folder / "flat.h5", content, 1), 0);
  EXPECT_EQ(RunFileReader(folder / "flat.h5").content().history, content.history);
}

TEST(RunFile, ChecksumsAreDigestsOfSlicesInOrder) {
  const TemporaryFolder folder;
  const RunFileContent content = sample_content();
  write_sample_file(posix_file_ops(), folder / "run.h5", content);
  const RunFileReader reader(folder / "run.h5");
  for (int dataset = 0; dataset < 4; ++dataset) {
    std::vector<std::uint64_t> digests;
    for (const SliceIndex slice : first_indices<SliceIndex>(6)) {
      digests.push_back(digest_of(sample_slice(content, dataset, slice, 0)));
    }
    const std::string name = content.datasets[static_cast<std::size_t>(dataset)].name;
    EXPECT_EQ(reader.content().checksums.at(name), to_hex(digest_of(std::as_bytes(std::span(digests)))));
  }
}

TEST(RunFile, WriterAndReaderAgreeOnTheChecksum) {
  const TemporaryFolder folder;
  RunFileContent content;
  content.extents = Extents({5, 3, 2});
  content.datasets = {{"/samples", ElementType::float32, 1, true}};
  RunFileWriter writer(posix_file_ops(), folder / "run.h5", content);
  for (const SliceIndex slice : {SliceIndex(1), SliceIndex(0)})
    writer.write_slice(0, slice, sample_slice(content, 0, slice, 0));
  const std::string checksum = writer.checksum(0);
  writer.publish();
  EXPECT_EQ(RunFileReader(folder / "run.h5").content().checksums.at("/samples"), checksum);
}

TEST(RunFile, SameContentGivesSameBytes) {
  const TemporaryFolder folder;
  write_sample_file(posix_file_ops(), folder / "a.h5", sample_content());
  write_sample_file(posix_file_ops(), folder / "b.h5", sample_content());
  EXPECT_EQ(read_bytes(folder / "a.h5"), read_bytes(folder / "b.h5"));
}

// Addresses and sizes of all objects but /provenance, in the order of a walk through the file.
std::vector<haddr_t> addresses(const std::string& path) {
  std::vector<haddr_t> found;
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const auto visit = [](hid_t, const char* name, const H5O_info_t* info, void* out) -> herr_t {
    if (std::string(name).starts_with("provenance")) return 0;
    static_cast<std::vector<haddr_t>*>(out)->insert(static_cast<std::vector<haddr_t>*>(out)->end(),
                                                    {info->addr, info->hdr.space.total});
    return 0;
  };
  EXPECT_GE(H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, visit, &found, H5O_INFO_ALL), 0);
  EXPECT_GE(H5Fclose(file), 0);
  return found;
}

TEST(RunFile, ProvenanceMovesNothingElse) {
  const TemporaryFolder folder;
  RunFileContent content = sample_content();
  write_sample_file(posix_file_ops(), folder / "a.h5", content);
  content.provenance = {{"host", std::string(977, 'h')}, {"ranks", std::int64_t{3}}};
  for (int i = 0; i < 11; ++i) content.provenance["key" + std::to_string(i)] = 0.5;
  content.history[1].second = {7, 8, 9};
  write_sample_file(posix_file_ops(), folder / "b.h5", content);
  const std::vector<haddr_t> places = addresses(folder / "a.h5");
  EXPECT_GT(places.size(), 20U);
  EXPECT_EQ(places, addresses(folder / "b.h5"));
}

// Where two strings of equal length differ, as [first, last].
std::pair<std::size_t, std::size_t> differing_range(const std::string& a, const std::string& b, std::size_t from) {
  std::size_t first = from;
  while (first < a.size() && a[first] == b[first]) ++first;
  std::size_t last = a.size() - 1;
  while (last > first && a[last] == b[last]) --last;
  return {first, last};
}

TEST(RunFile, OnlyProvenanceBytesFollowProvenance) {
  const TemporaryFolder folder;
  RunFileContent content = sample_content();
  content.provenance = {{"host", std::string("first-host")}};
  write_sample_file(posix_file_ops(), folder / "a.h5", content);
  content.provenance = {{"host", std::string("other-host")}};
  write_sample_file(posix_file_ops(), folder / "b.h5", content);
  const std::string a = read_bytes(folder / "a.h5");
  const std::string b = read_bytes(folder / "b.h5");
  ASSERT_EQ(a.size(), b.size());
  const auto [first, last] = differing_range(a, b, 4096);
  EXPECT_EQ(first, a.find("first-host"));
  EXPECT_LT(last, first + 256);  // the header's own checksum follows
}

TEST(RunFile, ReadsOnlyItsFirstBytesToRecogniseAFile) {
  const TemporaryFolder folder;
  write_sample_file(posix_file_ops(), folder / "run.h5", sample_content());
  EXPECT_TRUE(looks_like_run_file(folder / "run.h5"));
  write_bytes(folder / "image.png", "\x89PNG\r\n\x1a\n");
  EXPECT_FALSE(looks_like_run_file(folder / "image.png"));
  EXPECT_FALSE(looks_like_run_file(folder / "missing"));
  EXPECT_FALSE(looks_like_run_file(folder.path()));
}

TEST(RunFile, StartsWithTextForPeople) {
  const TemporaryFolder folder;
  write_sample_file(posix_file_ops(), folder / "run.h5", sample_content());
  const std::string bytes = read_bytes(folder / "run.h5");
  EXPECT_THAT(bytes, StartsWith("noiseloom run file\nformat 1\nblock 4096\nlength " + std::to_string(bytes.size())));
  EXPECT_EQ(bytes.substr(4096, 8), "\x89HDF\r\n\x1a\n");
}

TEST(RunFile, SlicesLieWhereTheBlockSays) {
  const TemporaryFolder folder;
  const RunFileContent content = sample_content();
  write_sample_file(posix_file_ops(), folder / "run.h5", content);
  const std::string bytes = read_bytes(folder / "run.h5");
  std::istringstream lines(bytes.substr(0, 4096));
  int dataset = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    std::size_t offset = 0, num_slices = 0, slice_bytes = 0;
    words >> kind >> offset >> num_slices >> slice_bytes;
    if (kind != "slices") continue;
    ASSERT_EQ(num_slices, 6U);
    for (const SliceIndex slice : first_indices<SliceIndex>(6)) {
      const std::vector<std::byte> expected = sample_slice(content, dataset, slice, 0);
      ASSERT_EQ(expected.size(), slice_bytes);
      EXPECT_EQ(std::memcmp(bytes.data() + offset + static_cast<std::size_t>(slice) * slice_bytes, expected.data(),
                            slice_bytes),
                0);
    }
    ++dataset;
  }
  EXPECT_EQ(dataset, 4);
}

TEST(RunFile, H5pySeesArraysLabelsAndText) {
  if (std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") != 0) GTEST_SKIP() << "python3 has no h5py";
  const TemporaryFolder folder;
  write_sample_file(posix_file_ops(), folder / "run.h5", sample_content());
  write_bytes(folder / "check.py", R"(
import sys, h5py, numpy as np
f = h5py.File(sys.argv[1])
s = f["samples"]
assert s.shape == (2, 3, 5, 7, 3) and s.dtype == "<f4" and s.chunks is None
assert [d.label for d in s.dims] == ["z", "t", "y", "x", "channel"]
value = lambda dataset, slices, n: (dataset * 13 + np.arange(slices)[:, None]) * 1009 + np.arange(n)
assert (s[...].reshape(6, -1) == value(0, 6, 105)).all()
order = value(2, 6, 35).astype("u8")
assert f["order"].dtype == "<u8" and (f["order"][...].reshape(6, -1) == order + (order << np.uint64(40))).all()
assert f["config"][()].decode().endswith("# \u00e4\n")
assert (f["history/seconds"][...] == [0.5, 1.5, 2.5]).all() and (f["provenance/seconds"][...] == f["history/seconds"][...]).all()
assert f["state"].attrs["sweep"] == 17 and f["state"].attrs["method"] == b"anneal"
assert f["checksum/samples"].shape == (6,) and len(f["checksum"].attrs["samples"]) == 16
assert list(f.attrs["extents"]) == [7, 5, 3, 2]
)");
  EXPECT_EQ(std::system(("/usr/bin/python3 " + (folder / "check.py") + " " + (folder / "run.h5")).c_str()), 0);
}

TEST(RunFile, H5dumpReadsEveryObject) {
  if (std::system("h5dump --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "h5dump is not installed";
  const TemporaryFolder folder;
  write_sample_file(posix_file_ops(), folder / "run.h5", sample_content());
  EXPECT_EQ(std::system(("h5dump " + (folder / "run.h5") + " >" + (folder / "dump")).c_str()), 0);
  EXPECT_THAT(read_bytes(folder / "dump"), HasSubstr("SOFTLINK \"seconds\""));
}

}  // namespace
}  // namespace noiseloom
