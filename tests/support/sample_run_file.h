// A small run file whose every value is a formula, and a folder to put it in.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "noiseloom/files/run_file.h"

namespace noiseloom {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = testing::TempDir() + "noiseloom-XXXXXX";
    if (!::mkdtemp(name.data())) throw EnvironmentError("mkdtemp " + name);
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path_)) names.push_back(entry.path().filename());
    return names;
  }

 private:
  std::string path_;
};

// 7 x 5 x 3 x 2 with four datasets; `generation` changes every slice.
inline RunFileContent sample_content() {
  RunFileContent content;
  content.extents = Extents({7, 5, 3, 2});
  content.config = "[texture]\nsize = { x = 7, y = 5, t = 3, z = 2 }  # \u00e4\n";
  content.datasets = {{"/samples", ElementType::float32, 3, true},
                      {"/pdf", ElementType::float32, 1, false},
                      {"/order", ElementType::uint64, 1, false},
                      {"/state/permutation", ElementType::uint32, 1, false}};
  content.state = {{"sweep", std::int64_t{17}}, {"temperature", 0.1}, {"method", std::string("anneal")}};
  content.history = {{"sweep", {1, 2, 3}}, {"seconds", {0.5, 1.5, 2.5}}, {"R", {1.0, 0.5, 0.25}}};
  content.provenance = {{"version", std::string("0.1.0")}, {"ranks", std::int64_t{5}}, {"note", std::string()}};
  return content;
}

// Element i of a slice: different for each dataset, slice, element and generation; for uint64, past 32 bits.
inline std::uint64_t sample_value(int dataset, SliceIndex slice, std::size_t element, int generation) {
  const auto low = static_cast<std::uint64_t>(((generation * 11 + dataset) * 13 + slice.value()) * 1009) + element;
  return low + (std::uint64_t{low} << 40);
}

inline std::vector<std::byte> sample_slice(const RunFileContent& content, int dataset, SliceIndex slice,
                                           int generation) {
  const SliceDataset& spec = content.datasets[static_cast<std::size_t>(dataset)];
  std::vector<std::byte> bytes(bytes_per_slice(spec, content.extents));
  const std::size_t width = bytes_per_element(spec.type);
  for (std::size_t i = 0; i < bytes.size() / width; ++i) {
    const std::uint64_t value = sample_value(dataset, slice, i, generation);
    const float real = static_cast<float>(value & 0xffffff);
    const void* source = spec.type == ElementType::float32 ? static_cast<const void*>(&real) : &value;
    std::memcpy(bytes.data() + i * width, source, width);
  }
  return bytes;
}

inline void write_sample_file(FileOps& ops, const std::string& path, const RunFileContent& content,
                              int generation = 0) {
  RunFileWriter writer(ops, path, content);
  for (int dataset = 0; dataset < static_cast<int>(content.datasets.size()); ++dataset) {
    for (std::int32_t s = content.extents.num_slices(); s-- > 0;) {
      const SliceIndex slice(s);
      writer.write_slice(dataset, slice, sample_slice(content, dataset, slice, generation));
    }
  }
  writer.publish();
}

// The generation whose slices a file holds throughout; -1 for none. Throws as RunFileReader does.
inline int sample_generation(const std::string& path, const RunFileContent& content, int num_generations) {
  const RunFileReader reader(path);
  for (int generation = 0; generation < num_generations; ++generation) {
    bool same = true;
    for (int dataset = 0; dataset < static_cast<int>(content.datasets.size()); ++dataset) {
      for (const SliceIndex slice : content.extents.slices()) {
        const std::vector<std::byte> expected = sample_slice(content, dataset, slice, generation);
        std::vector<std::byte> found(expected.size());
        reader.read_slice(dataset, slice, found);
        same = same && found == expected;
      }
    }
    if (same) return generation;
  }
  return -1;
}

inline std::string read_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Overwrites or appends in place: no truncation, which some file systems answer by waiting for the disk.
inline void put_bytes(const std::string& path, std::size_t offset, const std::string& bytes) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(offset));
  file << bytes;
}

inline void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

}  // namespace noiseloom
