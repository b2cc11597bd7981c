// score: the relative error R of a texture.
#include <fmt/format.h>

#include <memory>
#include <string>

#include "noiseloom/core/error.h"
#include "noiseloom/core/json.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/image/naming.h"
#include "noiseloom/image/texture_file.h"
#include "noiseloom/measure/quality.h"
#include "noiseloom/measure/score_file.h"
#include "noiseloom/samples/sample_space.h"
#include "noiseloom_study.h"

namespace noiseloom {
namespace {

struct Arguments {
  TextureArguments texture;
  bool json = false;
  bool slices = false;
};

std::string score_json(const std::string& name, const TextureFile& file, const TextureScore& score,
                       const SpectralQuality& quality, bool slices) {
  std::string text = fmt::format("{{\"relative_error\": {}, \"white_noise\": 1, \"exact\": {}, \"file\": {}, ",
                                 json_number(score.relative_error), score.exact ? "true" : "false", json_string(name));
  text += fmt::format("\"size\": {}, \"samples\": {}, \"filter\": {}, \"filters\": {{",
                      json_string(file.texture.extents.to_string()),
                      json_string(sample_space_name(file.config->problem.samples)),
                      json_string(describe_filter(file.texture.extents, file.config->problem.filter)));
  for (std::size_t i = 0; i < score.others.size(); ++i)
    text += fmt::format("{}{}: {}", i == 0 ? "" : ", ", json_string(score.others[i].filter),
                        json_number(score.others[i].relative_error));
  text += "}, " + quality_json(quality);
  if (slices) {
    text += ", \"slices\": [";
    for (std::size_t s = 0; s < score.per_slice.size(); ++s)
      text += fmt::format("{}{}", s == 0 ? "" : ", ", json_number(score.per_slice[s]));
    text += "]";
  }
  return text + "}\n";
}

std::string score_text(const std::string& name, const TextureFile& file, const TextureScore& score,
                       const SpectralQuality& quality, bool slices) {
  const Extents& extents = file.texture.extents;
  std::string text = fmt::format("{}: {}, {}, {} channel{}, samples {}\n", name, file.source, extents.to_string(),
                                 file.texture.channels, file.texture.channels == 1 ? "" : "s",
                                 sample_space_name(file.config->problem.samples));
  for (const std::string& note : file.notes) text += "note: " + note + "\n";
  text += fmt::format("\nR = {:.4f}   after {}   (white noise: 1{})\n\n", score.relative_error,
                      describe_filter(extents, file.config->problem.filter),
                      score.exact ? "" : "; the mean distance is an estimate");
  text += "under other filters\n";
  for (const FilterScore& other : score.others)
    text += fmt::format("  {:.4f}   {}\n", other.relative_error, other.filter);
  if (const std::string spectra = quality_text(quality); !spectra.empty()) text += "\n" + spectra;
  if (slices) {
    text += "\nslice by slice (R is the mean)\n";
    for (std::size_t s = 0; s < score.per_slice.size(); ++s)
      text += fmt::format("  {:5}  {:.4f}\n", s, score.per_slice[s]);
  }
  return text;
}

void run_score(const Arguments& arguments) {
  const TextureArguments& common = arguments.texture;
  const TextureFile file = load_texture(common.file, config_of(common));
  if (!file.config)
    throw UserError(common.file, "not a run file: --config must say what the values mean (texture and filter)");
  ThreadPool pool(threads_of(common));
  const DistanceKind distance = distance_kind(file.config->problem.samples, file.texture.channels);
  const TextureScore score =
      score_texture(file.texture, distance, file.config->problem.filter, standard_filters(file.texture.extents), pool);
  const SpectralQuality quality = spectral_quality(file.texture, distance, &file.config->problem.filter);
  const std::string text = arguments.json ? score_json(common.file, file, score, quality, arguments.slices)
                                          : score_text(common.file, file, score, quality, arguments.slices);
  fmt::print("{}", text);
}

}  // namespace

void add_score(CLI::App& app) {
  const auto arguments = std::make_shared<Arguments>();
  auto* const command = app.add_subcommand("score", "Relative error R of a run file or of anybody's images");
  add_texture_arguments(*command, arguments->texture);
  command->add_flag("--json", arguments->json, "One JSON object");
  command->add_flag("--slices", arguments->slices, "Also slice by slice");
  command->footer(
      "R is the mean squared error that is left after the filter, over random step integrands; white noise has 1.\n"
      "Also told: the power that is left below 0.05 cycles a pixel, over x and y, along each slice axis and over the\n"
      "axes that the filter groups, where white noise has 1; and at the three lowest frequencies of each slice "
      "axis.\n\n"
      "  noiseloom score run.h5                              under the filter it was made for, and under others\n"
      "  noiseloom score run.h5 --set filter.groups[0].size=3\n"
      "  noiseloom score noise_{}.png --config run.toml      anybody's images; the config says what they hold\n");
  command->callback([arguments] { run_score(*arguments); });
}

}  // namespace noiseloom
