#include "noiseloom/render/output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <span>

#include "noiseloom/image/image_io.h"

namespace noiseloom::render {
namespace {

struct Codes {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

// value_of(channel, pixel) of 0 to 1, rounded to 8 bits.
template <class ValueOf>
Codes codes_of(const ResultPicture& picture, ValueOf value_of) {
  Codes codes{picture.width, picture.height, {}};
  const std::size_t pixels = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
  codes.rgb.resize(3 * pixels);
  for (std::size_t i = 0; i < pixels; ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = value_of((picture.channels == 3 ? c : 0) * pixels + i);
      codes.rgb[3 * i + c] = static_cast<std::uint8_t>(255 * std::clamp(value, 0.0, 1.0) + 0.5);
    }
  return codes;
}

Codes shown(const ResultPicture& picture) {
  return codes_of(picture, [&](std::size_t i) { return static_cast<double>(picture.values[i]); });
}

Codes shown_error(const ResultPicture& picture, const ResultPicture& truth, double scale) {
  return codes_of(picture, [&](std::size_t i) {
    return 0.5 + scale * (static_cast<double>(picture.values[i]) - static_cast<double>(truth.values[i]));
  });
}

void write(OutputFiles& output, const std::string& path, const Codes& codes) {
  ImageJob job;
  job.block = {codes.width, codes.height, 3, PixelType::uint8, {"R", "G", "B"}, -1};
  write_image(output.add(path), job, [&](int) { return std::as_bytes(std::span(codes.rgb)); });
}

// As a part of a file's name.
std::string file_word(const Stage& stage) {
  return stage.space == "none" ? stage.time : stage.time + "_" + stage.space;
}

void add_pictures(const Result& result, const std::string& folder, OutputFiles& output) {
  const std::size_t stages = result.stages.size();
  const auto path = [&](const std::string& name) {
    return (std::filesystem::path(folder) / "pictures" / (name + ".png")).string();
  };
  for (std::size_t effect = 0; effect < result.effects.size(); ++effect) {
    const std::string name = name_of(result.effects[effect]);
    write(output, path(name + "_truth"), shown(result.truths[effect * stages]));
    for (std::size_t stage = 0; stage < stages; ++stage) {
      double largest = 0;
      for (std::size_t noise = 0; noise < result.noises.size(); ++noise)
        largest = std::max(largest, result.rmse(effect, noise, stage, result.frames - 1).mean);
      const double scale = largest > 0 ? 0.5 / (4 * largest) : 0;
      for (std::size_t noise = 0; noise < result.noises.size(); ++noise) {
        const ResultPicture& picture = result.pictures[(effect * result.noises.size() + noise) * stages + stage];
        const std::string file = fmt::format("{}_{}_{}", name, result.noises[noise], file_word(result.stages[stage]));
        write(output, path(file), shown(picture));
        write(output, path(file + "_error"), shown_error(picture, result.truths[effect * stages + stage], scale));
      }
    }
  }
}

}  // namespace

void add_outputs(const Scene& scene, const Result& result, const std::string& folder, OutputFiles& output) {
  const auto path = [&](const char* name) { return (std::filesystem::path(folder) / name).string(); };
  output.write(path("results.csv"), results_csv(result));
  if (scene.puts_out("curves")) output.write(path("curves.csv"), curves_csv(result));
  output.write(path("plan.json"), plan_json(scene, result.passes, result.seconds, result.threads));
  if (scene.puts_out("spectra")) output.write(path("spectra.csv"), spectra_csv(result));
  if (scene.puts_out("images")) add_pictures(result, folder, output);
}

}  // namespace noiseloom::render
