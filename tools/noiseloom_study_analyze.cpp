// analyze: the report of a texture.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "noiseloom/core/error.h"
#include "noiseloom/core/json.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/files/output_files.h"
#include "noiseloom/image/texture_file.h"
#include "noiseloom/measure/distribution.h"
#include "noiseloom/measure/quality.h"
#include "noiseloom/report/analyze.h"
#include "noiseloom_options.h"
#include "noiseloom_study.h"

namespace noiseloom {
namespace {

struct AnalyzeArguments {
  TextureArguments texture;
  std::string folder;
  bool overwrite = false;
  ResultOptions result;
};

void run_analyze(const AnalyzeArguments& arguments) {
  const std::vector<std::string>& files = arguments.texture.files;
  if (files.size() > 1)
    throw UserError("command line", fmt::format("{} files, but analyze writes the report of one; for images that are "
                                                "slices of one texture give a pattern: noise_{{}}.png",
                                                files.size()));
  refuse_unfit_folder(arguments.folder);
  const TextureFile file = load_argument(arguments.texture, files.front());
  ThreadPool pool(threads_of(arguments.texture));
  OutputFiles output(posix_file_ops(), arguments.overwrite);
  const SpectralQuality quality = analyze_texture(files.front(), file, arguments.folder, output, pool, report_origin());
  output.commit();
  std::string warning;
  if (file.config && file.source != "run file")
    warning = distribution_warning(file.texture, file.config->problem.samples);
  const std::string report = (std::filesystem::path(arguments.folder) / "report.html").string();
  const std::string warning_line = warning.empty() ? "" : fmt::format("warning: {}\n", warning);
  print_result(arguments.result, fmt::format("{}{}wrote {}\n", quality_text(quality), warning_line, report),
               fmt::format("{{\"report\": {}, {}, \"warnings\": [{}]}}\n", json_string(report), quality_json(quality),
                           warning.empty() ? "" : json_string(warning)));
}

}  // namespace

void add_analyze(CLI::App& app) {
  const auto arguments = std::make_shared<AnalyzeArguments>();
  auto* const command = app.add_subcommand("analyze", "Spectra, pictures and convergence: report.html");
  add_texture_arguments(*command, arguments->texture);
  command->add_option("-o,--output", arguments->folder, "Folder to write to (made if missing)")->required();
  command->add_flag("--overwrite", arguments->overwrite, "Replace files that exist");
  add_result_options(*command, arguments->result, ShowsProgress::no);
  command->footer(
      "  noiseloom analyze run.h5 -o report/                       then open report/report.html\n"
      "  noiseloom analyze strip.png -o report/ --config run.toml  anybody's images; without a config, no scores\n");
  command->callback([arguments] { run_analyze(*arguments); });
}

}  // namespace noiseloom
