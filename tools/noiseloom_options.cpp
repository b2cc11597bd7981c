#include "noiseloom_options.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <sstream>
#include <string>
#include <vector>

#include "noiseloom/core/console.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/json.h"

namespace noiseloom {
namespace {

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

// The command whose options were given: `app` itself, or the one of its subcommands that the line names.
const CLI::App& command_of(const CLI::App& app) {
  const std::vector<CLI::App*> chosen = app.get_subcommands();
  return chosen.empty() ? app : *chosen.front();
}

// Faults for options that the command does not have. A word without a dash may be the value of one: it is named only
// where there is no such option to blame.
std::vector<Fault> unexpected_words(const CLI::App& app) {
  std::vector<Fault> options;
  std::vector<Fault> words;
  for (const std::string& word : app.remaining(true)) {
    if (word.size() < 2 || word.front() != '-') {
      words.push_back({"command line", fmt::format("\"{}\" is one word too many", word)});
      continue;
    }
    const std::string name = word.substr(0, word.find('='));
    const std::string near = nearest_word(name, option_names(command_of(app)));
    options.push_back({"command line", fmt::format("{}: unknown option{}", name,
                                                   near.empty() ? "" : fmt::format("; did you mean {}?", near))});
  }
  return options.empty() ? words : options;
}

}  // namespace

void add_result_options(CLI::App& app, ResultOptions& options, ShowsProgress progress, const std::string& json) {
  if (progress == ShowsProgress::yes) {
    app.add_option("--progress", options.progress,
                   "auto, plain, json or none (none: the result and warnings alone are printed)")
        ->check(CLI::IsMember({"auto", "plain", "json", "none"}));
  }
  app.add_flag("--quiet", options.quiet, "print nothing but warnings and errors, not even the result");
  app.add_flag("--json", options.json, "the result as one JSON object" + (json.empty() ? "" : ": " + json));
}

void add_progress_file(CLI::App& app, std::string& path) {
  app.add_option("--progress-to", path,
                 "progress and warnings go to this file (appended; /dev/fd/3, a FIFO) instead of standard error: with "
                 "--progress json a stream of JSON objects and nothing else, whatever the launcher prints");
}

int open_progress_file(const std::string& path) {
  if (path.empty()) return STDERR_FILENO;
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (file < 0) {
    throw EnvironmentError(fmt::format("{}: cannot write progress: {}", path, std::system_category().message(errno)));
  }
  return file;
}

void ResultOptions::say(const std::string& line) const {
  if (quiet || progress == "none") return;
  print_error((progress == "json" ? json_object(std::vector<JsonMember>{{"message", line}}) : line) + "\n");
}

void print_result(const ResultOptions& options, const std::string& text, const std::string& json) {
  if (!options.quiet) fmt::print("{}", options.json ? json : text);
}

std::optional<int> read_options(CLI::App& app, int argc, char** argv, bool prints) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      // Through the C library, which tells why a write fails; a stream would forget.
      std::ostringstream text;
      app.exit(error, text, text);
      if (prints) fmt::print("{}", text.str());
      return 0;
    }
    std::vector<Fault> faults = unexpected_words(app);
    if (dynamic_cast<const CLI::ExtrasError*>(&error) == nullptr) faults.push_back({"command line", error.what()});
    if (faults.empty()) faults.push_back({"command line", error.what()});
    const CLI::App& command = command_of(app);
    faults.back().text +=
        fmt::format("; see {} --help", &command == &app ? app.get_name() : app.get_name() + " " + command.get_name());
    throw UserError(std::move(faults));
  }
  return std::nullopt;
}

}  // namespace noiseloom
