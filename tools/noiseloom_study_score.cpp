// score: the relative error R of a texture.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/core/error.h"
#include "noiseloom/core/json.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/image/naming.h"
#include "noiseloom/image/sequence.h"
#include "noiseloom/image/texture_file.h"
#include "noiseloom/measure/distribution.h"
#include "noiseloom/measure/quality.h"
#include "noiseloom/measure/score_file.h"
#include "noiseloom/samples/sample_space.h"
#include "noiseloom_options.h"
#include "noiseloom_study.h"

namespace noiseloom {
namespace {

struct ScoreArguments {
  TextureArguments texture;
  ResultOptions result;
  bool slices = false;
};

// R of another channel of the file, taken for a scalar.
struct ChannelScore {
  std::string name;
  double relative_error = 1;
};

struct Scored {
  std::string name;
  TextureFile file;
  TextureScore score;
  SpectralQuality quality;
  std::vector<ChannelScore> channels;
  std::string warning;
};

std::string list_of(const std::vector<std::string>& texts) {
  std::string list;
  for (const std::string& text : texts) list += (list.empty() ? "" : ", ") + json_string(text);
  return "[" + list + "]";
}

// With what null stands for in the object.
std::vector<std::string> notes_of(const Scored& scored) {
  std::vector<std::string> notes = scored.file.notes;
  for (const GroupQuality& group : scored.quality.groups)
    if (!std::isfinite(group.low_frequency_power))
      notes.push_back(fmt::format("low_frequency_power of {} is null: no frequency is below {} cycles a pixel.",
                                  group.name, low_frequency));
  return notes;
}

std::string score_json(const Scored& scored, bool slices) {
  const TextureFile& file = scored.file;
  const TextureScore& score = scored.score;
  std::string text =
      fmt::format("{{\"relative_error\": {}, \"white_noise\": 1, \"exact\": {}, \"file\": {}, ",
                  json_number(score.relative_error), score.exact ? "true" : "false", json_string(scored.name));
  text += fmt::format("\"size\": {}, \"samples\": {}, \"filter\": {}, \"filters\": {{",
                      json_string(file.texture.extents.to_string()),
                      json_string(describe_samples(file.config->problem.samples)),
                      json_string(describe_filter(file.texture.extents, file.config->problem.filter)));
  for (std::size_t i = 0; i < score.others.size(); ++i)
    text += fmt::format("{}{}: {}", i == 0 ? "" : ", ", json_string(score.others[i].filter),
                        json_number(score.others[i].relative_error));
  text += "}, " + quality_json(scored.quality);
  text += fmt::format(", \"notes\": {}, \"warnings\": {}", list_of(notes_of(scored)),
                      list_of(scored.warning.empty() ? std::vector<std::string>{} : std::vector{scored.warning}));
  if (!scored.channels.empty()) {
    text += ", \"channels\": {";
    for (std::size_t c = 0; c < scored.channels.size(); ++c)
      text += fmt::format("{}{}: {}", c == 0 ? "" : ", ", json_string(scored.channels[c].name),
                          json_number(scored.channels[c].relative_error));
    text += "}";
  }
  if (slices) {
    text += ", \"slices\": [";
    for (std::size_t s = 0; s < score.per_slice.size(); ++s)
      text += fmt::format("{}{}", s == 0 ? "" : ", ", json_number(score.per_slice[s]));
    text += "]";
  }
  return text + "}";
}

std::string score_text(const Scored& scored, bool slices) {
  const TextureFile& file = scored.file;
  const TextureScore& score = scored.score;
  const Extents& extents = file.texture.extents;
  const SampleSpec& samples = file.config->problem.samples;
  std::string text =
      fmt::format("{}: {}, {}, {} channel{}, samples {}\n", scored.name, file.source, extents.to_string(),
                  file.texture.channels, file.texture.channels == 1 ? "" : "s", describe_samples(samples));
  for (const std::string& note : file.notes) text += "note: " + note + "\n";
  if (!scored.warning.empty()) text += "warning: " + scored.warning + "\n";
  if (file.texture.channels > 2 && distance_kind(samples, file.texture.channels) == DistanceKind::chebyshev)
    text += "note: by the largest of more than two differences R is no error, but says how unlike neighbours are\n";
  text += fmt::format("\nR = {:.4f}   after {}   (white noise: 1{})\n", score.relative_error,
                      describe_filter(extents, file.config->problem.filter),
                      score.exact ? "" : "; the mean distance is an estimate");
  for (const ChannelScore& channel : scored.channels)
    text += fmt::format("    {:.4f}   channel {}, as a scalar\n", channel.relative_error, channel.name);
  text += "\nunder other filters\n";
  for (const FilterScore& other : score.others) {
    const auto published = published_score(samples, other.filter);
    text += fmt::format("  {:.4f}   {}{}\n", other.relative_error, other.filter,
                        published ? fmt::format("   (published textures reach {:.4f})", *published) : "");
  }
  if (const std::string spectra = quality_text(scored.quality); !spectra.empty()) text += "\n" + spectra;
  if (slices) {
    text += "\nslice by slice (R is the mean)\n";
    for (std::size_t s = 0; s < score.per_slice.size(); ++s)
      text += fmt::format("  {:5}  {:.4f}\n", s, score.per_slice[s]);
  }
  return text;
}

// Without a filter nothing is averaged, and R is that of white noise. Then the texture's own filter, and the usual
// ones.
std::vector<FilterScore> with_own_and_none(const TextureFile& file, const TextureScore& score) {
  const std::string own = describe_filter(file.texture.extents, file.config->problem.filter);
  std::vector<FilterScore> all = {{"none", 1}, {own, score.relative_error}};
  for (const FilterScore& other : score.others)
    if (other.filter != own) all.push_back(other);
  return all;
}

Scored score_one(const TextureArguments& arguments, const std::string& name, ThreadPool& pool) {
  Scored scored{name, load_argument(arguments, name), {}, {}, {}, ""};
  const TextureFile& file = scored.file;
  if (!file.config)
    throw UserError(name,
                    "not a run file: say what the values mean by --set texture.samples=uniform (or vector2, "
                    "sphere, ...), or by --config with size, samples and filter");
  const ProblemSpec& problem = file.config->problem;
  const DistanceKind distance = distance_kind(problem.samples, file.texture.channels);
  scored.score = score_texture(file.texture, distance, problem.filter, standard_filters(file.texture.extents), pool);
  scored.score.others = with_own_and_none(file, scored.score);
  scored.quality = spectral_quality(file.texture, distance, &problem.filter);
  if (file.source != "run file") scored.warning = distribution_warning(file.texture, problem.samples);
  if (file.texture.channels != 1 || !arguments.reading.channels.empty()) return scored;
  for (const std::string& channel : file.further_channels) {
    TextureReading reading = arguments.reading;
    reading.channels = channel;
    const TextureFile other = load_texture(name, file.config, reading);
    const double m = mean_distance_of(other.texture, distance, pool);
    scored.channels.push_back({channel, relative_error_of(other.texture, distance, problem.filter, m, pool)});
  }
  return scored;
}

// What a shell makes of noise_*.png: slices of one texture where the config has as many, else textures of their own.
std::vector<std::string> textures_of(const TextureArguments& arguments) {
  if (arguments.files.size() < 2 || arguments.config.empty()) return arguments.files;
  const auto slices = load_config(arguments.config, arguments.overrides).problem.extents.num_slices();
  if (std::cmp_not_equal(slices, arguments.files.size()) || !is_one_sequence(arguments.files)) return arguments.files;
  return {arguments.files.front()};
}

void run_score(const ScoreArguments& arguments) {
  ThreadPool pool(threads_of(arguments.texture));
  const std::vector<std::string> names = textures_of(arguments.texture);
  std::string text;
  std::vector<Fault> faults;
  for (const std::string& name : names) {
    try {
      const Scored scored = score_one(arguments.texture, name, pool);
      if (!text.empty()) text += arguments.result.json ? ",\n " : "\n";
      text += arguments.result.json ? score_json(scored, arguments.slices) : score_text(scored, arguments.slices);
    } catch (const UserError& error) {
      faults.insert(faults.end(), error.faults().begin(), error.faults().end());
    }
  }
  throw_if_any(std::move(faults));
  print_result(arguments.result, text, names.size() == 1 ? text + "\n" : "[" + text + "]\n");
}

}  // namespace

void add_score(CLI::App& app) {
  const auto arguments = std::make_shared<ScoreArguments>();
  auto* const command = app.add_subcommand("score", "Relative error R of run files or of anybody's images");
  add_texture_arguments(*command, arguments->texture);
  add_result_options(*command, arguments->result, ShowsProgress::no, "of several files a list of them");
  command->add_flag("--slices", arguments->slices, "Also slice by slice");
  command->footer(
      "R is the mean squared error that is left after the filter, over random step integrands; white noise has 1.\n"
      "Also told: the power that is left below 0.05 cycles a pixel, over x and y, along each slice axis and over the\n"
      "axes that the filter groups, where white noise has 1; and at the three lowest frequencies of each slice "
      "axis.\n\n"
      "  noiseloom score run.h5                              under the filter it was made for, and under others\n"
      "  noiseloom score run.h5 --set filter.groups[0].size=3\n"
      "  noiseloom score noise_{}.png --config run.toml      anybody's images; the config says what they hold\n"
      "  noiseloom score mask.png --set texture.samples=uniform          the size is the image's, the filter gauss "
      "1.0\n"
      "  noiseloom score a.h5 b.h5 --config other.toml                   several, under the filter of another config\n"
      "  noiseloom score lab.h5:/noise/blue --set texture.samples=uniform --axes yxt\n\n"
      "A warning says where the values do not have the distribution of their samples (gamma, contrast, two tones). "
      "With\n"
      "several files --json prints a list.\n");
  command->callback([arguments] { run_score(*arguments); });
}

}  // namespace noiseloom
