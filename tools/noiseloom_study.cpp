// The program behind `noiseloom export`, `score`, `analyze` and `accuracy`: what needs image libraries and no MPI.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "noiseloom/core/error.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/io/checkpoint.h"
#include "noiseloom/io/config.h"
#include "noiseloom/io/run_file.h"
#include "noiseloom/problem/sample_space.h"
#include "noiseloom/study/analyze.h"
#include "noiseloom/study/export.h"
#include "noiseloom/study/json.h"
#include "noiseloom/study/naming.h"
#include "noiseloom/study/output_files.h"
#include "noiseloom/study/quality.h"
#include "noiseloom/study/score_file.h"
#include "noiseloom/study/texture_file.h"
#include "noiseloom_study.h"

namespace noiseloom {
namespace {

constexpr int exit_done = 0;
constexpr int exit_environment = 1;
constexpr int exit_user = 2;

struct Common {
  std::string file;
  std::string config;
  std::vector<std::string> overrides;
  int threads = 0;
};

// The config given or, where --set changes it, the run file's own.
std::optional<RunConfig> config_of(const Common& common) {
  if (!common.config.empty()) return load_config(common.config, common.overrides);
  if (common.overrides.empty()) return std::nullopt;
  if (!looks_like_run_file(common.file))
    throw UserError("command line", "--set changes a config: give one with --config");
  const RunFileReader reader(common.file);
  return parse_config(reader.content().config, common.file + ": /config", config_folder(reader.content(), common.file),
                      common.overrides, MissingFiles::accepted);
}

int threads_of(const Common& common) { return common.threads > 0 ? common.threads : num_available_processors(); }

std::string list_of_files(const std::vector<std::string>& files) {
  if (files.size() == 1) return files.front();
  if (files.size() == 2) return fmt::format("{} and {}", files.front(), files.back());
  return fmt::format("{} files: {} to {}", files.size(), files.front(), files.back());
}

void run_export(const std::string& file, const ExportOptions& options) {
  const ExportResult result = export_run_file(file, options, posix_file_ops());
  fmt::print("wrote {}\n", list_of_files(result.files));
  if (!result.tables.empty()) fmt::print("{}, in {}\n", result.points, list_of_files(result.tables));
}

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

void run_score(const Common& common, bool json, bool slices) {
  const TextureFile file = load_texture(common.file, config_of(common));
  if (!file.config)
    throw UserError(common.file, "not a run file: --config must say what the values mean (texture and filter)");
  ThreadPool pool(threads_of(common));
  const DistanceKind distance = distance_kind(file.config->problem.samples, file.texture.channels);
  const TextureScore score =
      score_texture(file.texture, distance, file.config->problem.filter, standard_filters(file.texture.extents), pool);
  const SpectralQuality quality = spectral_quality(file.texture, distance, &file.config->problem.filter);
  const std::string text = json ? score_json(common.file, file, score, quality, slices)
                                : score_text(common.file, file, score, quality, slices);
  fmt::print("{}", text);
}

void run_analyze(const Common& common, const std::string& folder, bool overwrite) {
  const TextureFile file = load_texture(common.file, config_of(common));
  ThreadPool pool(threads_of(common));
  OutputFiles output(posix_file_ops(), overwrite);
  const SpectralQuality quality = analyze_texture(common.file, file, folder, output, pool);
  output.commit();
  fmt::print("{}", quality_text(quality));
  fmt::print("wrote {}\n", (std::filesystem::path(folder) / "report.html").string());
}

void add_common(CLI::App& command, Common& common, const std::string& file_help) {
  command.add_option("FILE", common.file, file_help)->required();
  command.add_option(
      "--config", common.config,
      "What the values mean: size, samples and filter. For a run file, only the filter is taken from it");
  command
      .add_option("--set", common.overrides,
                  "Change a key of the config (or of the run file's own): filter.groups[0].size=3")
      ->allow_extra_args(false);
  command.add_option("--threads", common.threads, "Threads; all processors if not given")->check(CLI::PositiveNumber);
}

// What the command line sets; outlives parsing.
struct Arguments {
  Common common;
  ExportOptions exported;
  std::string folder;
  bool json = false;
  bool slices = false;
  bool overwrite = false;
};

void add_export(CLI::App& app, Arguments& arguments) {
  auto* const command = app.add_subcommand("export", "Run file to images and arrays");
  std::string& file = arguments.common.file;
  ExportOptions& options = arguments.exported;
  command->add_option("RUN.h5", file, "Run file")->required();
  command
      ->add_option("-o,--output", options.output,
                   "A file, a folder (made if missing), or a pattern such as out/noise_{slice:03}.png")
      ->required();
  command->add_option("--format", options.format,
                      "png, exr, tiff, hdr, npy, raw; from the output's extension if not given, else png");
  command->add_option("--layout", options.layout,
                      "slices: a file each (default); strip: all in one, downward; exr-multipart: parts of one EXR");
  command->add_option("--depth", options.depth, "png: 8 (default), 16; tiff: 8, 16, 32f; raw: 32f, 8, 16; others: 32f");
  command->add_option("--naming", options.naming, "Names in a folder: plain (default), nvidia, ea, or a pattern");
  command->add_option("--slices", options.slices, "A:B: slices A to B - 1");
  command->add_option("--range", options.range,
                      "LO:HI: what 0 and 1 of an image stand for; needed for unbounded samples (gauss, a file's)");
  command->add_option("--threshold", options.threshold,
                      "The point set of a void-and-cluster mask at that density, above 0 and up to 1: black and white "
                      "images,\nand the coordinates in their order (points.csv; npy: points.npy too)");
  command->add_flag("--pdf", options.with_density, "Density, over its maximum, in the alpha channel");
  command->add_flag("--overwrite", options.overwrite, "Replace files that exist");
  command->footer(
      "Values are stored as b = floor(256 u) (16 bit: 65536) and read back as u = (b + 0.5) / 256; u is the value, "
      "for\n"
      "directions and disks 0.5 + 0.5 of it. Two channels become red and green. exr, tiff 32f, npy and raw 32f hold "
      "the\n"
      "values themselves.\n\n"
      "  noiseloom export run.h5 -o textures/                              one PNG a slice\n"
      "  noiseloom export run.h5 -o textures/ --naming nvidia              stbn_vec2_2Dx1D_128x128x64_0.png, ...\n"
      "  noiseloom export run.h5 -o noise.png --layout strip --depth 16    all slices, one under the other\n"
      "  noiseloom export run.h5 -o noise.exr --layout exr-multipart       floats, one part a slice\n"
      "  noiseloom export mask.h5 -o points/ --threshold 0.1               the earliest tenth of the pixels, as "
      "points\n");
  command->callback([&] { run_export(file, options); });
}

constexpr const char* file_help =
    "Run file; image, first of numbered images, folder of them, or pattern (noise_{}.png); .npy; .raw";

void add_score(CLI::App& app, Arguments& arguments) {
  auto* const command = app.add_subcommand("score", "Relative error R of a run file or of anybody's images");
  add_common(*command, arguments.common, file_help);
  command->add_flag("--json", arguments.json, "One JSON object");
  command->add_flag("--slices", arguments.slices, "Also slice by slice");
  command->footer(
      "R is the mean squared error that is left after the filter, over random step integrands; white noise has 1.\n"
      "Also told: the power that is left below 0.05 cycles a pixel, over x and y, along each slice axis and over the\n"
      "axes that the filter groups, where white noise has 1; and at the three lowest frequencies of each slice "
      "axis.\n\n"
      "  noiseloom score run.h5                              under the filter it was made for, and under others\n"
      "  noiseloom score run.h5 --set filter.groups[0].size=3\n"
      "  noiseloom score noise_{}.png --config run.toml      anybody's images; the config says what they hold\n");
  command->callback([&] { run_score(arguments.common, arguments.json, arguments.slices); });
}

void add_analyze(CLI::App& app, Arguments& arguments) {
  auto* const command = app.add_subcommand("analyze", "Spectra, pictures and convergence: report.html");
  add_common(*command, arguments.common, file_help);
  command->add_option("-o,--output", arguments.folder, "Folder to write to (made if missing)")->required();
  command->add_flag("--overwrite", arguments.overwrite, "Replace files that exist");
  command->footer(
      "  noiseloom analyze run.h5 -o report/                       then open report/report.html\n"
      "  noiseloom analyze strip.png -o report/ --config run.toml  anybody's images; without a config, no scores\n");
  command->callback([&] { run_analyze(arguments.common, arguments.folder, arguments.overwrite); });
}

int run(int argc, char** argv) {
  CLI::App app("Look at sampling-noise textures, score them, and turn run files into images", "noiseloom");
  app.require_subcommand(1);
  Arguments arguments;
  add_export(app, arguments);
  add_score(app, arguments);
  add_analyze(app, arguments);
  int status = exit_done;
  add_accuracy(app, status);
  try {
    app.parse(argc, argv);
    return status;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? exit_done : exit_user;
  } catch (const UserError& error) {
    const std::size_t count = error.faults().size();
    fmt::print(stderr, "{}\n{} error{}; nothing was done\n", error.what(), count, count == 1 ? "" : "s");
    return exit_user;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return exit_environment;
  }
}

}  // namespace
}  // namespace noiseloom

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a full quota is then an error that is told
  return noiseloom::run(argc, argv);
}
