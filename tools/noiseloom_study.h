// Commands of noiseloom-study, one file each. Each adds itself to the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/image/texture_file.h"
#include "noiseloom/measure/members.h"
#include "noiseloom/report/report.h"

namespace noiseloom {

void add_export(CLI::App& app);
void add_score(CLI::App& app);
void add_analyze(CLI::App& app);
void add_compare(CLI::App& app);
void add_pixels(CLI::App& app);
// `status` becomes the exit status when the command has run.
void add_verify(CLI::App& app, int& status);
void add_accuracy(CLI::App& app, int& status);

void add_render(CLI::App& app, int& status);

// A line of a published program (published/line.h), whose grammar is not that of the other commands. `words` stand
// behind the command. Returns the exit status.
int run_published(const std::string& command, const std::vector<std::string>& words);

// "a.png", "a.png and b.png", "32 files: a_0.png to a_31.png".
std::string list_of_files(const std::vector<std::string>& files);

// The members of a bank's folder that are done. Throws UserError where it holds none.
std::vector<MemberFile> member_files(const std::string& folder);

// noiseloom beside this program, else the one in PATH.
std::string program_beside();

// What score and analyze both take: textures of any kind, and what their values mean.
struct TextureArguments {
  std::vector<std::string> files;
  std::string config;
  std::vector<std::string> overrides;
  TextureReading reading;
  int threads = 0;  // 0: all processors
};

void add_texture_arguments(CLI::App& command, TextureArguments& arguments);
// The config given or, where --set changes it, the run file's own; from --set alone, the size is what the file
// suggests. None where nothing is given.
std::optional<RunConfig> config_of(const TextureArguments& arguments, const std::string& file);
TextureFile load_argument(const TextureArguments& arguments, const std::string& file);
int threads_of(const TextureArguments& arguments);

// Throws UserError where `folder`, given for a report, is plainly meant as something else: standard output, or one
// file.
void refuse_unfit_folder(const std::string& folder);

// What a page says it was made by: the version, today's date, and the command line as a shell takes it.
ReportOrigin report_origin();

}  // namespace noiseloom
