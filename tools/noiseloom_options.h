// Command lines of both programs: read by CLI11, with words that help where they are wrong.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

namespace noiseloom {

// Reads `argv` (without the program's name: argv[0] is the command) into the variables that `app` was given. Returns 0
// where the command line itself ends the command (--help, printed if `prints`). Throws UserError for a wrong one: every
// word that was not expected, with the option that may have been meant.
std::optional<int> read_options(CLI::App& app, int argc, char** argv, bool prints = true);

// What is printed, in the same words for every command. Progress and warnings go to standard error, the result to
// standard output.
struct ResultOptions {
  std::string progress = "auto";
  bool quiet = false;
  bool json = false;

  // A line of progress, where that is shown; with "json" as an object, as those of generate are.
  void say(const std::string& line) const;
};
enum class ShowsProgress { no, yes };
// --quiet and --json, and --progress for commands that show some. `json` says what the object holds, or "".
void add_result_options(CLI::App& app, ResultOptions& options, ShowsProgress progress, const std::string& json = "");
// --progress-to FILE: where progress and warnings go instead of standard error, which launchers write to as well.
void add_progress_file(CLI::App& app, std::string& path);
// A descriptor of that file, to append to; standard error where none is named. Throws EnvironmentError.
int open_progress_file(const std::string& path);
// The one of the two texts that is wanted, or neither.
void print_result(const ResultOptions& options, const std::string& text, const std::string& json);

}  // namespace noiseloom
