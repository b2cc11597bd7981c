// export: run files to images and arrays.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/core/console.h"
#include "noiseloom/core/json.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/npz.h"
#include "noiseloom/files/output_files.h"
#include "noiseloom/image/consumers.h"
#include "noiseloom/image/export.h"
#include "noiseloom/image/export_importance.h"
#include "noiseloom/image/export_pack.h"
#include "noiseloom/measure/covariance.h"
#include "noiseloom_options.h"
#include "noiseloom_study.h"

namespace noiseloom {
namespace {

struct ExportArguments {
  std::vector<std::string> files;
  std::string packing;
  ExportOptions options;
  std::string importance;
  bool covariance = false;
  ResultOptions result;
};

std::string json_list_of(const std::vector<std::string>& texts) {
  std::string list;
  for (const std::string& text : texts) list += (list.empty() ? "" : ", ") + json_string(text);
  return "[" + list + "]";
}

using Given = std::pair<const char*, std::string>;  // an option and its value, "" where it was not given

// Throws UserError, which names all that were given.
void refuse_options(const std::vector<std::vector<Given>>& groups, const std::string& why) {
  std::vector<Fault> faults;
  for (const std::vector<Given>& options : groups) {
    for (const auto& [option, value] : options) {
      if (!value.empty())
        faults.push_back({"command line", fmt::format("{} {}: does not go with {}", option, value, why)});
    }
  }
  throw_if_any(std::move(faults));
}

// How files are written.
std::vector<Given> container_options(const ExportOptions& options) {
  return {{"--for", options.consumer}, {"--format", options.format},     {"--layout", options.layout},
          {"--depth", options.depth},  {"--channels", options.channels}, {"--naming", options.naming}};
}

// Which of the values are written.
std::vector<Given> value_options(const ExportOptions& options) {
  return {{"--slices", options.slices}, {"--range", options.range},   {"--threshold", options.threshold},
          {"--pdf", options.density},   {"--values", options.values}, {"--read", options.read}};
}

void warn_of(const std::string& file, const std::string& change, const std::string& unfinished) {
  if (!change.empty()) print_error(fmt::format("warning: {}: {}\n", file, change));
  if (!unfinished.empty())
    print_error(fmt::format("warning: {}: {}; go on with generate --resume\n", file, unfinished));
}

void warn_of(const std::string& file) {
  if (!looks_like_run_file(file)) return;
  const RunFileReader reader = open_to_look_at(file);
  const RunFileContent& content = reader.content();
  const RunConfig config =
      parse_config(content.config, file + ": /config", parent_directory(file), {}, MissingFiles::accepted);
  warn_of(file, reader.change(), unfinished_run(content, config));
}

// The mean, the spectrum and the factor of the planes of a bank's members (or of one run file), for NumPy.
void run_covariance(const ExportArguments& arguments) {
  const std::string& from = arguments.files.front();
  const ExportOptions& options = arguments.options;
  const std::string& output = options.output;
  refuse_options({container_options(options), value_options(options), {{"--frames", options.frames}}},
                 "--covariance, which writes an .npz of all planes");
  if (!output.ends_with(".npz")) throw UserError(output, "--covariance writes NumPy's .npz; choose such a name");
  std::vector<std::string> paths = {from};
  if (std::filesystem::is_directory(from)) {
    paths.clear();
    for (const MemberFile& member : member_files(from)) paths.push_back(member.path);
    if (paths.empty()) throw UserError(from, "none of its members is done");
  }
  OutputFiles files(posix_file_ops(), options.overwrite);
  const std::string temporary = files.add(output);
  ThreadPool pool(num_available_processors());
  const PlaneCovariance found = plane_covariance(paths, pool);
  const std::vector<std::int64_t> plane = {found.height, found.width};
  const std::int64_t pixels = static_cast<std::int64_t>(found.height) * found.width;
  write_npz(
      temporary,
      {{"mean", plane, found.mean}, {"spectrum", plane, found.spectrum}, {"cholesky", {pixels, pixels}, found.factor}});
  files.commit();
  for (const std::string& path : paths) warn_of(path);
  print_result(arguments.result,
               fmt::format("wrote {}: mean, spectrum and cholesky of {} planes of {} members\n", output, found.planes,
                           paths.size()),
               fmt::format("{{\"files\": {}, \"tables\": [], \"planes\": {}, \"members\": {}}}\n",
                           json_list_of({output}), found.planes, paths.size()));
}

void run_pack(const ExportArguments& arguments) {
  const ExportOptions& options = arguments.options;
  refuse_options({value_options(options), {{"--frames", options.frames}, {"--importance", arguments.importance}}},
                 "--pack");
  const ExportResult result = export_packed(arguments.files, arguments.packing, options, posix_file_ops());
  print_result(arguments.result, fmt::format("wrote {}\n", list_of_files(result.files)),
               fmt::format("{{\"files\": {}, \"tables\": []}}\n", json_list_of(result.files)));
}

void run_export(const std::string& file, const ExportArguments& arguments) {
  const ExportResult result = export_run_file(file, arguments.options, posix_file_ops());
  warn_of(file, result.change, result.unfinished);
  std::string text;
  if (!result.files.empty()) text += fmt::format("wrote {}\n", list_of_files(result.files));
  if (!result.tables.empty()) text += fmt::format("{}, in {}\n", result.points, list_of_files(result.tables));
  print_result(
      arguments.result, text,
      fmt::format("{{\"files\": {}, \"tables\": {}}}\n", json_list_of(result.files), json_list_of(result.tables)));
}

// Which pixels a mask samples, frame by frame, in place of its values.
void run_importance(const ExportArguments& arguments) {
  const ExportOptions& options = arguments.options;
  refuse_options({container_options(options), value_options(options)},
                 "--importance, which writes one PNG a frame and coverage.csv into a folder");
  refuse_unfit_folder(options.output);
  const ImportanceResult result =
      export_importance(arguments.files.front(),
                        {arguments.importance, options.output, options.frames, options.overwrite}, posix_file_ops());
  const Coverage& last = result.coverage.back();
  const std::string text = fmt::format(
      "wrote {} and {}\nsampled at least once in {} {}: {:.2f} % of the pixels (white noise {:.2f} %, slices that are "
      "blue each alone {:.2f} %)\n",
      list_of_files(result.images), result.table, result.coverage.size(),
      result.coverage.size() == 1 ? "frame" : "frames", 100 * last.so_far, 100 * last.white, 100 * last.slices_alone);
  print_result(arguments.result, text,
               fmt::format("{{\"files\": {}, \"tables\": {}, \"sampled\": {}, \"white_noise\": {}, "
                           "\"slices_alone\": {}}}\n",
                           json_list_of(result.images), json_list_of({result.table}), json_number(last.so_far),
                           json_number(last.white), json_number(last.slices_alone)));
}

}  // namespace

std::string list_of_files(const std::vector<std::string>& files) {
  if (files.size() == 1) return files.front();
  if (files.size() == 2) return fmt::format("{} and {}", files.front(), files.back());
  return fmt::format("{} files: {} to {}", files.size(), files.front(), files.back());
}

void add_export(CLI::App& app) {
  auto* const command = app.add_subcommand("export", "Run file to images and arrays");
  const auto arguments = std::make_shared<ExportArguments>();
  ExportOptions& options = arguments->options;
  command->add_option("RUN.h5", arguments->files, "Run file; with --pack several");
  command->add_option("-o,--output", options.output,
                      "A file, a folder (made if missing), or a pattern such as out/noise_{slice:03}.png");
  command->add_option("--for", options.consumer,
                      "A program that is to read the files, such as unreal, godot or bevy: it decides format, layout, "
                      "channels and\nnames. --for help lists them");
  command->add_option("--format", options.format,
                      container_names() + "; from the ending of the output if not given, else png");
  command->add_option(
      "--layout", options.layout,
      "slices: a file each; strip, row: all in one image, downward or to the right; atlas (or atlas:CxR, "
      "C columns):\nin rows; exr-multipart: parts of one EXR; array, volume: layers of one texture; "
      "function: the text that reads a\ntexture, without numbers. The first is the default.\n" +
          container_layouts());
  command->add_option(
      "--depth", options.depth,
      "Bits of a number; 16f for half, 32f for float. The first is the default.\n" + container_depths());
  command->add_option(
      "--channels", options.channels,
      "R, RG, RGB or RGBA: the channels of a pixel, where a container would take others: what the samples "
      "have not\nis 0, alpha is opaque, and a scalar stands in all of R, G and B");
  command->add_option("--naming", options.naming,
                      "Names in a folder: plain (default); nvidia, ea: those of the published textures; or a pattern\n"
                      "with one place for the number: {slice}, {slice:03}, {}, %d, %03d, %i, ####");
  command->add_option("--frames", options.frames,
                      "N: frames 0 to N - 1 as a shader reads them, in place of the slices: slice after slice, and the "
                      "whole\ntexture moved on after each round of them");
  command->add_option("--values", options.values,
                      "K: values that a pixel reads in a frame; output f K + v is value v of frame f");
  command->add_option("--read", options.read,
                      "Where these are read: offsets (default; of the R2 sequence, in one slice) or slices (those that "
                      "follow)");
  command->add_option(
      "--pack", arguments->packing,
      "RG=A,B=B,A=1: channels of one file from the run files A.h5 and B.h5, which are named too; NAME.0 is the "
      "first\nchannel of a file, and numbers stand for themselves");
  command->add_option("--slices", options.slices, "A:B: slices (or frames) A to B - 1");
  command->add_option("--range", options.range,
                      "LO:HI: what 0 and 1 of an image stand for; needed for unbounded samples (gauss, a file's)");
  command->add_option(
      "--threshold", options.threshold,
      "The point set of a void-and-cluster mask at that density, above 0 and up to 1: black and white "
      "images,\nand the coordinates in their order (points_belowD.csv; with npy also .npy; csv: these alone)");
  command
      ->add_option("--pdf", options.density,
                   "Density, over its maximum: alpha (where the option stands alone), in that channel; separate, in "
                   "images\nof one channel beside (NAME_pdf.png); none")
      ->expected(0, 1)
      ->default_str("alpha");
  command->add_option(
      "--importance", arguments->importance,
      "MAP: which pixels a scalar mask samples in each frame under an importance map (an image or .npy, "
      "0 to 1):\nthose whose importance is above the mask. PNGs, and coverage.csv: the share sampled so "
      "far");
  command->add_flag(
      "--covariance", arguments->covariance,
      "Of a bank's folder (or one run file) of one channel and at most 64 x 64 pixels: mean, spectrum and "
      "Cholesky\nfactor of its planes as an .npz; L z of normal numbers z is Gaussian noise as blue as "
      "they are");
  command->add_flag("--overwrite", options.overwrite, "Replace files that exist");
  add_result_options(*command, arguments->result, ShowsProgress::no, "the files that were written");
  command->footer(
      "Values are stored as b = floor(256 u) (16 bit: 65536) and read back as u = (b + 0.5) / 256; u is the value, "
      "for\n"
      "directions and disks 0.5 + 0.5 of it. Two channels become red and green. Depths 16f and 32f, and npy, hold "
      "the\n"
      "values themselves.\n\n"
      "  noiseloom export run.h5 -o textures/                              one PNG a slice\n"
      "  noiseloom export run.h5 -o textures/ --naming nvidia              stbn_vec2_2Dx1D_128x128x64_0.png, ...\n"
      "  noiseloom export run.h5 -o textures/ --naming ea                  real_uniform_box3x3_exp0101_product_0.png, "
      "...\n"
      "  noiseloom export run.h5 -o noise.png --layout strip --depth 16    all slices, one under the other\n"
      "  noiseloom export run.h5 -o noise.exr --layout exr-multipart       floats, one part a slice\n"
      "  noiseloom export run.h5 -o noise.ktx2 --channels RGBA             a texture of as many layers as slices\n"
      "  noiseloom export lens.h5 time.h5 -o both.ktx2 --pack RG=lens,B=time,A=1\n"
      "  noiseloom export run.h5 -o textures/ --for unreal                 as Unreal Engine takes it\n"
      "  noiseloom export run.h5 -o noise.hlsl --layout function           shader code that reads such a texture\n"
      "  noiseloom export seeds/ -o seeds.npz --covariance                for noise that diffuses to such textures\n"
      "  noiseloom export mask.h5 -o points/ --threshold 0.1               the earliest tenth of the pixels, as "
      "points\n");
  command->callback([arguments] {
    if (arguments->options.consumer == "help") {
      fmt::print("{}", consumers_table());
      return;
    }
    // `--pdf run.h5`, where the option stands alone and the file follows it.
    const std::string& density = arguments->options.density;
    const bool is_word = density.empty() || density == "alpha" || density == "separate" || density == "none";
    if (arguments->files.empty() && !is_word) {
      arguments->files = {std::exchange(arguments->options.density, "alpha")};
    }
    if (arguments->files.empty()) throw UserError("command line", "RUN.h5 is required; see noiseloom export --help");
    if (arguments->options.output.empty())
      throw UserError("command line", "--output is required; see noiseloom export --help");
    if (arguments->covariance && !arguments->packing.empty())
      throw UserError("command line", "--covariance: does not go with --pack");
    if (arguments->covariance && !arguments->importance.empty())
      throw UserError("command line", "--covariance: does not go with --importance");
    if (!arguments->packing.empty()) return run_pack(*arguments);
    if (arguments->files.size() > 1)
      throw UserError("command line", fmt::format("\"{}\" is one word too many: several run files are for --pack; see "
                                                  "noiseloom export --help",
                                                  arguments->files[1]));
    if (!arguments->importance.empty()) return run_importance(*arguments);
    if (arguments->covariance) return run_covariance(*arguments);
    run_export(arguments->files.front(), *arguments);
  });
}

}  // namespace noiseloom
