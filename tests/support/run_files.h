// A run file with values that are formulas, in a folder of its own.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/image/texture_file.h"
#include "noiseloom/samples/sample_space.h"
#include "support/sample_run_file.h"
#include "support/source_folder.h"

namespace noiseloom {

// 11 x 7 x 3 (x, y, t), box 3 over xy.
inline RunConfig small_config(const std::string& samples, const std::string& size = "x = 11, y = 7, t = 3") {
  return parse_config("[texture]\nsize = { " + size + " }\nsamples = \"" + samples +
                          "\"\n[filter]\ngroups = [ { axes = \"xy\", kernel = \"box\", size = 3 } ]\n",
                      "test.toml", "", {});
}

// The samples of the space in a random order, as generate starts from.
inline Texture start_texture(const RunConfig& config) {
  const ProblemSpec& problem = config.problem;
  const Extents& extents = problem.extents;
  const SampleSource source(problem.samples, extents.cells_per_slice(), extents.num_slices(), problem.seed);
  Texture texture = make_texture(extents, source.channels());
  const std::size_t channels = static_cast<std::size_t>(source.channels());
  for (const SliceIndex s : extents.slices()) {
    const std::vector<float> list = source.list(s);
    const Permutation order = start_permutation(problem.seed, s, extents.cells_per_slice());
    std::vector<float> slice;
    for (const SampleId id : order)
      for (std::size_t c = 0; c < channels; ++c) slice.push_back(list[id.value() * channels + c]);
    interleaved_to_planar(slice, source.channels(), texture.slice(s));
  }
  return texture;
}

// Density that the test gives cell i of slice s.
inline float test_density(SliceIndex s, std::size_t i) {
  return static_cast<float>(1 + (i + 5 * static_cast<std::size_t>(s)) % 13);
}

inline void write_run_file(const std::string& path, const RunConfig& config, const Texture& texture,
                           bool with_density = false) {
  RunFileContent content;
  content.extents = texture.extents;
  content.config = to_toml(config);
  content.datasets = {{"/samples", ElementType::float32, texture.channels, true}};
  if (with_density) content.datasets.push_back({"/pdf", ElementType::float32, 1, false});
  content.history = {{"sweep", {0, 1, 2}}, {"relative_error", {1, 0.5, 0.25}}, {"seconds", {0, 1.5, 2}}};
  RunFileWriter writer(posix_file_ops(), path, content);
  for (const SliceIndex s : texture.extents.slices()) {
    const std::vector<float> slice = interleaved_slice(texture, s);
    writer.write_slice(0, s, std::as_bytes(std::span(slice)));
    std::vector<float> density;
    for (std::size_t i = 0; i < static_cast<std::size_t>(texture.extents.cells_per_slice()); ++i)
      density.push_back(test_density(s, i));
    if (with_density) writer.write_slice(1, s, std::as_bytes(std::span(density)));
  }
  writer.publish();
}

inline double largest_difference(const Texture& a, const Texture& b) {
  EXPECT_EQ(a.extents.num_cells(), b.extents.num_cells());
  EXPECT_EQ(a.channels, b.channels);
  double largest = 0;
  for (std::size_t i = 0; i < std::min(a.values.size(), b.values.size()); ++i)
    largest = std::max(largest, std::abs(static_cast<double>(a.values[i]) - static_cast<double>(b.values[i])));
  return largest;
}

// What a UserError says, "" if nothing is thrown.
template <class Action>
std::string user_error_of(Action action) {
  try {
    action();
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

// The folder of published textures, "" where it is absent.
inline std::string published_folder() {
  const char* const given = std::getenv("NOISELOOM_PUBLISHED");
  const std::string folder = given != nullptr ? given : testing_support::source_folder() + "/../shared/published";
  return std::filesystem::is_directory(folder) ? folder : "";
}

}  // namespace noiseloom
