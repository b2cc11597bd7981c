// What export writes, pinned: the bytes of arrays and tables, and the pixels of images as they are read back. Image
// libraries may pack the same pixels differently from version to version, so the bytes of images are not pinned.
#include <fmt/format.h>

#include <filesystem>
#include <map>

#include "noiseloom/files/digest.h"
#include "noiseloom/image/export.h"
#include "noiseloom/image/image_io.h"
#include "noiseloom/image/image_reader.h"
#include "support/mask_texture.h"
#include "support/run_files.h"

namespace noiseloom {
namespace {

// Every value is an exact multiple of 1/1024, inside the range that the space fills: no arithmetic is pinned here.
Texture formula_texture(const RunConfig& config, int channels) {
  Texture texture = make_texture(config.problem.extents, channels);
  for (std::size_t i = 0; i < texture.values.size(); ++i)
    texture.values[i] = static_cast<float>((i * 389 + 57) % 1024) / 1024;
  return texture;
}

void update_with(Digest& digest, const std::string& text) { digest.update(std::as_bytes(std::span(text))); }

// Sizes, channels, number type and pixels of all parts.
void update_with_image(Digest& digest, const std::string& path) {
  ImageReader reader(path);
  for (int part = 0; part < reader.num_parts(); ++part) {
    const ImageShape& shape = reader.shape(part);
    update_with(digest, fmt::format("{} {} {} {}\n", shape.width, shape.height, to_string(shape.type), shape.alpha));
    for (const std::string& name : shape.channel_names) update_with(digest, name + " ");
    std::vector<std::byte> bytes(shape.num_bytes());
    reader.read_rows(part, 0, shape.height, bytes);
    digest.update(bytes);
  }
}

// One digest of all files that an export writes, with their names.
std::string export_digest(const std::string& run_file, ExportOptions options) {
  const TemporaryFolder folder;
  options.output = folder / options.output;
  const ExportResult result = export_run_file(run_file, options, posix_file_ops());
  Digest digest;
  std::vector<std::string> files = result.files;
  files.insert(files.end(), result.tables.begin(), result.tables.end());
  for (const std::string& file : files) {
    update_with(digest, std::filesystem::path(file).filename().string() + "\n");
    if (has_image_extension(file)) {
      update_with_image(digest, file);
      continue;
    }
    const std::string bytes = read_bytes(file);
    // The last member of a sidecar is the config, whose text may gain keys.
    update_with(digest, file.ends_with(".json") ? bytes.substr(0, bytes.find("\"config\"")) : bytes);
  }
  return to_hex(digest.value());
}

struct DigestCase {
  std::string samples;
  ExportOptions options;
  std::string digest;
};

ExportOptions options_of(const std::string& output, const std::string& format, const std::string& layout,
                         const std::string& depth, bool with_density = false) {
  ExportOptions options;
  options.output = output;
  options.format = format;
  options.layout = layout;
  options.depth = depth;
  if (with_density) options.density = "alpha";
  return options;
}

TEST(ExportDigest, IsThatOfTheFirstRelease) {
  const std::map<std::string, int> channels = {
      {"tent", 1}, {"uniform", 1}, {"vector2", 2}, {"vector3", 3}, {"vector6", 6}};
  const DigestCase cases[] = {
      {"uniform", options_of("out/", "png", "slices", "8"), "8ede992521240a67"},
      {"uniform", options_of("out/", "png", "strip", "16"), "f16371b13d63f539"},
      {"vector2", options_of("out/", "png", "slices", "16"), "9dc531197e4402a5"},
      {"tent", options_of("out/", "png", "slices", "8", true), "abce5ba1722ed3d7"},
      {"vector2", options_of("a.exr", "", "slices", ""), "722f3d1991a58453"},
      {"vector3", options_of("a.exr", "", "exr-multipart", ""), "08edb1a2489d9858"},
      {"tent", options_of("a.exr", "", "strip", "", true), "e1e436349173c1a8"},
      {"vector6", options_of("a.exr", "", "strip", "32f"), "abf2594661c43a82"},
      {"vector2", options_of("a.tif", "", "strip", "8"), "587cf83eebc4eadc"},
      {"vector6", options_of("a.tiff", "", "slices", "32f"), "fd8869157d3fcc82"},
      {"vector3", options_of("a.hdr", "", "strip", ""), "696454ed5a1fc50a"},
      {"uniform", options_of("out/", "hdr", "slices", ""), "3db3d43f807f108c"},
      {"vector2", options_of("out/", "npy", "", ""), "8f77ac676eb8d22a"},
      {"vector6", options_of("a.raw", "", "", "32f"), "eda60a97dc1a9ea2"},
      {"vector2", options_of("out/", "raw", "", "8"), "143ebc9aa43d4e24"},
      {"uniform", options_of("out/", "raw", "", "16"), "d0de87c152a8f47f"},
  };
  const TemporaryFolder folder;
  for (const DigestCase& c : cases) {
    const RunConfig config = small_config(c.samples);
    const std::string run_file = folder / (c.samples + ".h5");
    if (!std::filesystem::exists(run_file))
      write_run_file(run_file, config, formula_texture(config, channels.at(c.samples)), c.samples == "tent");
    EXPECT_EQ(export_digest(run_file, c.options), c.digest) << fmt::format(
        "{} {} {} {} {}", c.samples, c.options.output, c.options.format, c.options.layout, c.options.depth);
  }
}

// The heading of the last column of points is `place` since.
TEST(ExportDigest, OfPointSetsIsThatOfTheFirstRelease) {
  const TemporaryFolder folder;
  const Extents extents({11, 7, 3, 2});
  std::vector<std::uint64_t> places(462);
  for (std::size_t p = 0; p < places.size(); ++p) places[p] = (p * 125 + 17) % 462;
  write_mask_file(folder / "mask.h5", extents, places);
  const std::pair<ExportOptions, std::string> cases[] = {
      {options_of("a.png", "", "strip", ""), "92586727761b7f0d"},
      {options_of("a.tif", "", "slices", "16"), "81f81e428da3e859"},
      {options_of("a.npy", "", "", ""), "315984174e9a9584"},
      {options_of("a.raw", "", "", "8"), "f5ef76dfce955027"},
  };
  for (auto [options, digest] : cases) {
    options.threshold = "0.29";
    EXPECT_EQ(export_digest(folder / "mask.h5", options), digest) << options.output;
  }
}

}  // namespace
}  // namespace noiseloom
