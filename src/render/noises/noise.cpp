#include "noiseloom/render/noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "noiseloom/config/config.h"
#include "noiseloom/core/error.h"
#include "noiseloom/files/digest.h"
#include "noiseloom/files/output_files.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/files/run_lock.h"
#include "noiseloom/samples/sample_space.h"
#include "noiseloom/samples/space.h"
#include "render/noises/sampler_keys.h"
#include "render/noises/sampler_tables.h"

namespace noiseloom::render {
namespace {

// A config that says what the values of a file are, and no more that matters.
RunConfig config_around(const std::string& file, const std::string& samples) {
  const auto with_size = [&](const Extents& extents) {
    std::string size;
    for (int axis = 0; axis < extents.num_axes(); ++axis)
      size += fmt::format("{}{} = {}", axis == 0 ? "" : ", ", extents.name(axis), extents.size(axis));
    return parse_config(fmt::format("[texture]\nsize = {{ {} }}\nsamples = \"{}\"\n[filter]\ngroups = [ {{ axes = "
                                    "\"xy\", kernel = \"gauss\", sigma = 1.0 }} ]\n",
                                    size, samples),
                        file, "", {});
  };
  return with_size(suggested_extents(file, find_sample_space(samples)->traits().channels, {}));
}

TextureFile load(const NoiseSpec& spec, const std::string& path) {
  if (spec.kind != NoiseKind::file || looks_like_run_file(path)) return load_texture(path, std::nullopt);
  return load_texture(path, config_around(path, spec.samples));
}

RunConfig config_of(const NoiseSpec& spec) {
  if (spec.kind == NoiseKind::config) return load_config(spec.file, spec.changes);
  return parse_config(built_in_config(spec), spec.name, "", {});
}

// Removes a texture that was kept and whose digests no longer fit: nothing can be taken from it. Where the run has an
// earlier generation beside it, whoever makes the texture goes on from that. What else is wrong with a file, or what is
// no run file, is left to it too. Says what was done, or nothing.
std::string without_damage(const std::string& path) {
  namespace fs = std::filesystem;
  if (!fs::exists(path) || fs::exists(path + ".prev")) return "";
  try {
    const RunFileReader whole(path);
    return "";
  } catch (const DamagedRunFile& error) {
    fs::remove(path);
    return fmt::format("{}, which was kept of an earlier run, was damaged and is made anew ({})", path,
                       error.faults().front().text);
  }
}

// Held while what is kept at `path` is looked at and made. The run that makes it locks the path itself, so this is
// another name beside it.
std::unique_ptr<RunLock> lock_making(const std::string& path, const WaitForOther& wait) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed)
    throw UserError(folder.string(), std::filesystem::exists(folder)
                                         ? "exists and is not a folder"
                                         : fmt::format("cannot be created ({})", failed.message()));
  for (;;) {
    try {
      return std::make_unique<RunLock>(path + ".making");
    } catch (const OutputHeld&) {
      wait(path);
    }
  }
}

// Codes that others divide by 255 reach 1, which no effect takes: a pane that is opaque is there for all numbers below
// it. What was done is said.
void keep_below_one(Noise& noise, Texture& texture) {
  if (noise.numbers_in_value() == 0) return;
  std::int64_t changed = 0;
  for (float& value : texture.values) {
    if (value < 1) continue;
    value = 0x1.fffffep-1F;
    ++changed;
  }
  if (changed > 0)
    noise.notes.push_back(fmt::format(
        "{} of its {} numbers {} 1 and {} read as the largest below it: an effect takes numbers of 0 to 1, without 1",
        changed, texture.values.size(), changed == 1 ? "is" : "are", changed == 1 ? "is" : "are"));
}

constexpr std::int64_t most_across = 65536;  // of TextureRead

std::shared_ptr<const Texture> checked(TextureFile file, const NoiseSpec& spec, const std::string& path) {
  const Extents& extents = file.texture.extents;
  if (extents.width() > most_across || extents.height() > most_across)
    throw UserError(path, fmt::format("noise \"{}\" is {}: at most {} pixels along an axis are read", spec.name,
                                      extents.to_string(), most_across));
  return std::make_shared<const Texture>(std::move(file.texture));
}

}  // namespace

std::string cached_tables(const NoiseSpec& spec, const std::string& folder) {
  return (std::filesystem::path(folder) /
          fmt::format("{}-{}-{}-{}-{}.h", spec.name, spec.points, spec.numbers, spec.seed, sampler_keys_algorithm))
      .string();
}

// Made once, as a header that any program can take; made anew where it was damaged.
static SamplerTables made_tables(const NoiseSpec& spec, const std::string& folder, const WaitForOther& wait,
                                 std::vector<std::string>& notes) {
  const KeysSpec keys{spec.points, spec.numbers, spec.seed};
  if (folder.empty()) return make_sampler_tables(keys);
  const std::string path = cached_tables(spec, folder);
  // What is whole is published in one step and never changes: a folder that others may only read serves as well.
  if (std::filesystem::exists(path) && is_whole_source_text(path)) return load_sampler_tables(path);
  const auto lock = lock_making(path, wait);
  if (std::filesystem::exists(path)) {
    if (is_whole_source_text(path)) return load_sampler_tables(path);
    notes.push_back(fmt::format("{}, which was kept of an earlier run, was damaged and is made anew", path));
  }
  SamplerTables tables = make_sampler_tables(keys);
  OutputFiles output(posix_file_ops(), true);
  output.write(path, source_text(tables, keys));
  output.commit();
  return tables;
}

bool has_texture(NoiseKind kind) {
  return kind <= NoiseKind::config || (kind >= NoiseKind::blue_2d && kind <= NoiseKind::golden_ratio);
}

std::string built_in_config(const NoiseSpec& spec) {
  const int slices = spec.kind == NoiseKind::golden_ratio ? 1 : spec.slices;
  return fmt::format(
      "[texture]\nsize = {{ x = {0}, y = {0}, t = {1} }}\nsamples = \"uniform\"\nseed = {2}\n\n[filter]\ncombine = "
      "\"sum\"\ngroups = [ {{ axes = \"{3}\", kernel = \"gauss-energy\", sigma = 1.9 }} ]\n\n[optimizer]\nmethod = "
      "\"void-and-cluster\"\nequalize = \"{4}\"\n",
      spec.size, slices, spec.seed, spec.kind == NoiseKind::blue_3d ? "xyt" : "xy",
      spec.kind == NoiseKind::blue_3d ? "volume" : "slice");
}

// The digest of a file, which whoever makes the texture says more of if it cannot be read.
static std::string contents_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  Digest digest;
  std::vector<char> block(1 << 16);
  while (file.read(block.data(), std::ssize(block)), file.gcount() > 0) {
    digest.update(std::as_bytes(std::span(block.data(), static_cast<std::size_t>(file.gcount()))));
  }
  return to_hex(digest.value());
}

std::string cached_texture(const NoiseSpec& spec, const std::string& folder) {
  const RunConfig config = config_of(spec);
  std::string text = to_toml(config);
  // What a config reads may change behind the same name.
  std::vector<std::string> inputs = {config.problem.samples.file, config.start.file};
  for (const GroupSpec& group : config.problem.filter.groups) inputs.push_back(group.kernel.file);
  for (const std::string& input : inputs) {
    if (!input.empty()) text += contents_of(input);
  }
  const std::string digest = to_hex(digest_of(std::as_bytes(std::span(text.data(), text.size()))));
  return (std::filesystem::path(folder) / fmt::format("{}-{}.h5", spec.name, digest.substr(0, 8))).string();
}

int Noise::numbers_in_value() const {
  if (!has_texture(spec.kind)) return 1;
  // Of a list, an image's density or a tent the estimate has another mean: its truth is not that of the effect.
  if (samples.is_file() || samples.is_image() || has_pdf(samples)) return 0;
  if (samples.space != "sobol-owen" && samples.space != "uniform" && samples.space != "circle" &&
      !samples.space.starts_with("vector")) {
    return 0;
  }
  return space_traits(samples).support == Support::unit_interval ? channels : 0;
}

Directions Noise::directions() const {
  if (!has_texture(spec.kind)) return Directions::none;
  if (samples.space == "hemisphere-cosine") return Directions::cosine;
  if (samples.space == "hemisphere") return Directions::hemisphere;
  return samples.space == "sphere" ? Directions::sphere : Directions::none;
}

void wait_a_moment(const std::string&) { std::this_thread::sleep_for(std::chrono::milliseconds(50)); }

Noise open_noise(const NoiseSpec& spec, const std::string& folder, const MakeTexture& make, const WaitForOther& wait) {
  Noise noise{.spec = spec};
  if (spec.kind == NoiseKind::tables)
    noise.tables = std::make_shared<const SamplerTables>(load_sampler_tables(spec.file));
  if (spec.kind == NoiseKind::sobol_blue)
    noise.tables = std::make_shared<const SamplerTables>(made_tables(spec, folder, wait, noise.notes));
  if (!has_texture(spec.kind)) return noise;
  std::string path = spec.file;
  std::string damage;
  if (spec.kind != NoiseKind::file) {
    path = cached_texture(spec, folder);
    const auto lock = lock_making(path, wait);
    damage = without_damage(path);
    if (spec.kind == NoiseKind::config) {
      make(spec.file, spec.changes, path);
    } else {
      make(built_in_config(spec), {}, path);
    }
  }
  TextureFile file = load(spec, path);
  noise.notes = file.notes;
  if (!damage.empty()) noise.notes.insert(noise.notes.begin(), damage);
  noise.samples = file.config->problem.samples;
  noise.channels = file.texture.channels;
  noise.num_values = std::ssize(file.texture.values);
  keep_below_one(noise, file.texture);
  noise.texture = checked(std::move(file), spec, path);
  noise.extents = noise.texture->extents;
  return noise;
}

Noise describe_noise(const NoiseSpec& spec) {
  if (spec.kind == NoiseKind::file) return open_noise(spec, "", nullptr);
  Noise noise{.spec = spec};
  if (!has_texture(spec.kind)) return noise;
  const ProblemSpec problem = config_of(spec).problem;
  noise.samples = problem.samples;
  noise.channels = num_channels(problem.samples, problem.extents.cells_per_slice(), problem.extents.num_slices());
  noise.num_values = problem.extents.num_cells() * noise.channels;
  noise.extents = problem.extents;
  return noise;
}

MaskPlace mask_place(const Noise& noise, const Move& move, std::int64_t frame) {
  if (noise.spec.kind == NoiseKind::golden_ratio) return {move.x, move.y, (frame + move.t) % noise.spec.slices};
  const TextureRead read = {
      .width = noise.extents.width(), .height = noise.extents.height(), .num_slices = noise.extents.num_slices()};
  const TextureRead::Place place = read.place(frame, 0);
  return {(move.x + place.dx) % read.width, (move.y + place.dy) % read.height,
          (place.slice.value() + move.t) % read.num_slices};
}

Move move_of_repeat(std::uint64_t seed, int repeat) {
  if (repeat == 0) return {};
  const RandomBlock block = random_block(seed, purpose_of_move, 0, 0, static_cast<std::uint64_t>(repeat));
  return {block[0] >> 12, block[1] >> 12, block[2] >> 12};
}

}  // namespace noiseloom::render
