// accuracy: what accuracy costs for one config, run by run.

#include <fmt/format.h>

#include <charconv>
#include <memory>
#include <string>

#include "noiseloom/accuracy/accuracy_run.h"
#include "noiseloom/config/config.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/text.h"
#include "noiseloom_options.h"
#include "noiseloom_study.h"

namespace noiseloom {
namespace {

constexpr int exit_stopped = 75;
constexpr int most_threads = 1024;
constexpr int most_seeds = 1000;

struct AccuracyArguments {
  AccuracyOptions options;
  std::string budget = "5m";
  std::string threads;
  std::string seeds;
  ResultOptions result;
};

void read_count(const std::string& option, const std::string& text, int most, int& count, std::vector<Fault>& faults) {
  if (text.empty()) return;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error != std::errc() || end != text.data() + text.size() || count < 1 || count > most)
    faults.push_back({"command line", fmt::format("{} {}: must be from 1 to {}", option, text, most)});
}

int run_accuracy_command(AccuracyArguments& arguments) {
  std::vector<Fault> faults;
  AccuracyOptions& options = arguments.options;
  if (const auto seconds = parse_duration(arguments.budget); seconds && *seconds > 0) {
    options.budget_s = *seconds;
  } else {
    faults.push_back(
        {"command line", fmt::format("--budget {}: not a duration; accepted: 30s, 10m, 2h, 1h30m", arguments.budget)});
  }
  read_count("--threads", arguments.threads, most_threads, options.threads, faults);
  read_count("--seeds", arguments.seeds, most_seeds, options.seeds, faults);
  try {
    refuse_unfit_folder(options.folder);
  } catch (const UserError& error) {
    faults.insert(faults.end(), error.faults().begin(), error.faults().end());
  }
  if (options.resume && options.overwrite)
    faults.push_back({"command line", "--resume and --overwrite exclude each other"});
  options.say = [&arguments](const std::string& line) { arguments.result.say(line); };
  options.quiet = arguments.result.quiet;
  options.json = arguments.result.json;
  options.program = program_beside();
  options.origin = report_origin();
  return run_accuracy(options, std::move(faults)) == AccuracyEnd::stopped ? exit_stopped : 0;
}

}  // namespace

void add_accuracy(CLI::App& app, int& status) {
  auto* const command = app.add_subcommand("accuracy", "What accuracy costs: R against seconds for a config");
  const auto arguments = std::make_shared<AccuracyArguments>();
  AccuracyOptions& options = arguments->options;
  command->add_option("CONFIG", options.config, "Config (TOML)")->required();
  command->add_option("-o,--output", options.folder, "Folder to write to (made if missing)")->required();
  command->add_option("--budget", arguments->budget, "Time for all runs together: 30s, 10m, 2h (default 5m)");
  command->add_option("--set", options.overrides, "Override a setting of the config, as for generate")
      ->allow_extra_args(false);
  command->add_option("--threads", arguments->threads, "Threads of each run; all processors if not given");
  command->add_option("--seeds", arguments->seeds,
                      "Runs of each point, with the config's seed and those after it (default 3): R is their mean");
  command->add_flag("--resume", options.resume, "Go on with what is in the folder, or start where there is nothing");
  command->add_flag("--overwrite", options.overwrite, "Replace what is in the folder");
  add_result_options(*command, arguments->result, ShowsProgress::yes);
  command->add_flag("--keep", options.keep, "Keep the run file of every point in DIR/runs (else deleted once scored)");
  command->footer(
      "Runs `noiseloom generate` again and again: more and fewer iterations, with anneal and with the paper's method\n"
      "(fast), and once with construct where the samples are scalars; then cut-off, background features and precision\n"
      "changed one at a time. Each point has several seeds: R and seconds (wall time of a whole process) are means, "
      "and\n"
      "the smallest and largest R stand beside them. Points run cheapest first; those that would not fit into the "
      "budget\n"
      "are left out and listed.\n"
      "Writes accuracy.csv and report.html, brought up to date after every point; SIGINT, SIGTERM or SIGUSR1 stop it\n"
      "(exit 75), --resume goes on, with a larger --budget further.\n\n"
      "  noiseloom accuracy run.toml -o accuracy/                        five minutes; then open accuracy/report.html\n"
      "  noiseloom accuracy run.toml -o accuracy/ --resume --budget 1h   go on from there\n");
  command->callback([arguments, &status] { status = run_accuracy_command(*arguments); });
}

}  // namespace noiseloom
