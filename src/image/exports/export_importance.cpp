#include "noiseloom/image/export_importance.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>

#include "noiseloom/config/config.h"
#include "noiseloom/core/random.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/output_files.h"
#include "noiseloom/files/pixel_order.h"
#include "noiseloom/image/image_io.h"
#include "noiseloom/image/texture_read.h"
#include "noiseloom/samples/luminance.h"
#include "noiseloom/samples/space.h"

namespace noiseloom {
namespace {

constexpr std::uint64_t seed = 1;  // of what the mask is compared with

struct Map {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<float> importance;  // [y][x]
};

Map read_map(const std::string& path) {
  SampleSpec spec;
  spec.space = "image";
  spec.file = path;
  const InputArrayPtr luminance = read_luminance(spec);
  const auto& values = std::get<SharedValues<float>>(luminance->values);
  Map map = {static_cast<std::size_t>(luminance->shape[1]),
             static_cast<std::size_t>(luminance->shape[0]),
             {values.begin(), values.end()}};
  for (std::size_t i = 0; i < map.importance.size(); ++i) {
    if (map.importance[i] >= 0 && map.importance[i] <= 1) continue;
    throw UserError(path, fmt::format("importance must be from 0 to 1; pixel {}, {} (column, row, from 0) has {}",
                                      i % map.width, i / map.width, map.importance[i]));
  }
  return map;
}

void require_uniform_scalars(const RunFileReader& reader, const RunConfig& config, const std::string& path) {
  const SampleSpec& samples = config.problem.samples;
  if (reader.dataset("/samples") < 0) throw UserError(path, "holds no /samples");
  const bool is_uniform = !samples.is_file() && !samples.is_image() && space_traits(samples).channels == 1 &&
                          space_traits(samples).has_constant_density && space_traits(samples).range == ValueRange{};
  if (is_uniform) return;
  throw UserError(path, fmt::format("--importance: samples \"{}\" are no scalars that are uniform in [0, 1); those of "
                                    "\"uniform\" are, and of every void-and-cluster mask",
                                    samples.space));
}

// What a mask has sampled in the frames so far.
class Sampling {
 public:
  explicit Sampling(const Map& map) : map_(map), now_(map.importance.size()), so_far_(map.importance.size()) {}

  // value(x, y) is the mask's.
  template <class Value>
  void frame(const Value& value) {
    for (std::size_t y = 0; y < map_.height; ++y) {
      for (std::size_t x = 0; x < map_.width; ++x) {
        const std::size_t pixel = y * map_.width + x;
        now_[pixel] = map_.importance[pixel] > value(x, y) ? std::byte{255} : std::byte{0};
        so_far_[pixel] |= now_[pixel];
      }
    }
  }

  const std::vector<std::byte>& now() const { return now_; }
  double share_now() const { return share(now_); }
  double share_so_far() const { return share(so_far_); }

 private:
  static double share(const std::vector<std::byte>& pixels) {
    const auto sampled = std::count(pixels.begin(), pixels.end(), std::byte{255});
    return static_cast<double>(sampled) / static_cast<double>(pixels.size());
  }

  const Map& map_;
  std::vector<std::byte> now_;
  std::vector<std::byte> so_far_;
};

float white_value(std::int32_t frame, std::size_t pixel) {
  return to_unit_float(random_block(seed, Purpose::subset, static_cast<std::uint32_t>(frame), 0, pixel)[0]);
}

std::int32_t frames_of(const std::string& text, const Extents& extents) {
  if (text.empty()) return extents.num_slices();
  constexpr std::int32_t most = 1'000'000;
  std::int32_t frames = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), frames);
  if (error != std::errc{} || stop != text.data() + text.size() || frames < 1 || frames > most) {
    throw UserError("command line", fmt::format("--frames {}: must be from 1 to {}", text, most));
  }
  return frames;
}

std::string table_text(const std::vector<Coverage>& coverage) {
  std::string text = "frame,sampled_now,sampled_so_far,white_noise_so_far,slices_alone_so_far\n";
  for (std::size_t f = 0; f < coverage.size(); ++f) {
    const Coverage& c = coverage[f];
    text += fmt::format("{},{},{},{},{}\n", f, c.now, c.so_far, c.white, c.slices_alone);
  }
  return text;
}

}  // namespace

ImportanceResult export_importance(const std::string& path, const ImportanceOptions& options, FileOps& ops) {
  const RunFileReader reader = open_to_look_at(path);
  const RunFileContent& content = reader.content();
  const RunConfig config =
      parse_config(content.config, path + ": /config", parent_directory(path), {}, MissingFiles::accepted);
  require_uniform_scalars(reader, config, path);
  require_finished_order(content, path);
  const Map map = read_map(options.map);
  const Extents& extents = content.extents;
  const std::int32_t frames = frames_of(options.frames, extents);

  const std::filesystem::path folder(options.output);
  ImportanceResult result;
  for (std::int32_t f = 0; f < frames; ++f) {
    const auto digits = fmt::formatted_size("{}", frames - 1);
    result.images.push_back((folder / fmt::format("sampled_{:0{}}.png", f, digits)).string());
  }
  result.table = (folder / "coverage.csv").string();
  OutputFiles files(ops, options.overwrite);
  std::vector<std::string> targets = result.images;
  targets.push_back(result.table);
  files.check(targets);

  const auto width = static_cast<std::size_t>(extents.width());
  const auto height = static_cast<std::size_t>(extents.height());
  const TextureRead read = {extents.width(), extents.height(), extents.num_slices()};
  const ImageJob job = {.block = {.width = static_cast<int>(map.width),
                                  .height = static_cast<int>(map.height),
                                  .channels = 1,
                                  .channel_names = {"Y"}},
                        .description = "white where a pixel is sampled: importance above the mask",
                        .part_names = {}};
  std::vector<float> slice(width * height);
  Sampling mask(map);
  Sampling white(map);
  Sampling alone(map);
  for (std::int32_t f = 0; f < frames; ++f) {
    const TextureRead::Place place = read.place(f, 0);
    reader.read_slice(reader.dataset("/samples"), place.slice, std::as_writable_bytes(std::span(slice)));
    const auto tiled = [&](std::size_t dx, std::size_t dy) {
      return [&slice, dx, dy, width, height](std::size_t x, std::size_t y) {
        return slice[(y + dy) % height * width + (x + dx) % width];
      };
    };
    mask.frame(tiled(static_cast<std::size_t>(place.dx), static_cast<std::size_t>(place.dy)));
    const RandomBlock shift = random_block(seed, Purpose::tile_shift, static_cast<std::uint32_t>(f), 0, 0);
    alone.frame(tiled(shift[0] % width, shift[1] % height));
    white.frame([&](std::size_t x, std::size_t y) { return white_value(f, y * map.width + x); });
    write_image(files.add(result.images[static_cast<std::size_t>(f)]), job,
                [&](int) { return std::span<const std::byte>(mask.now()); });
    result.coverage.push_back({mask.share_now(), mask.share_so_far(), white.share_so_far(), alone.share_so_far()});
  }
  files.write(result.table, table_text(result.coverage));
  files.commit();
  return result;
}

}  // namespace noiseloom
