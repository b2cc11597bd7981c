// generate: the options and the exit status of a run; the run itself is run/generate.h.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "noiseloom/core/console.h"
#include "noiseloom/core/json.h"
#include "noiseloom/core/standard_streams.h"
#include "noiseloom/core/text.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/run_lock.h"
#include "noiseloom/run/generate.h"
#include "noiseloom/run/stop_signals.h"
#include "noiseloom_commands.h"
#include "noiseloom_images.h"
#include "noiseloom_options.h"
#include "noiseloom_watchdog.h"

namespace noiseloom {
namespace {

constexpr int most_threads = 1024;

// The options as they are written.
struct Words {
  std::string time_limit;
  std::string checkpoint_every;
  std::string threads;
  std::string watchdog = "auto";
  std::string progress_to;
  ResultOptions result;
};

// What is shown while the run goes on, where, and at its end.
struct Shown {
  ProgressKind kind = ProgressKind::silent;
  std::string progress_to;
  bool json = false;
};

double seconds_of(const std::string& option, const std::string& text) {
  const std::optional<double> seconds = parse_duration(text);
  if (!seconds || *seconds <= 0) {
    throw UserError("command line", fmt::format("{} {}: not a duration; accepted: 30s, 10m, 2h, 1h30m", option, text));
  }
  return *seconds;
}

int threads_of(const std::string& text) {
  int threads = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), threads);
  if (error != std::errc() || end != text.data() + text.size() || threads < 1 || threads > most_threads) {
    throw UserError("command line", fmt::format("--threads {}: must be from 1 to {}", text, most_threads));
  }
  return threads;
}

void describe_options(CLI::App& app, GenerateRequest& request, Words& words) {
  app.name("noiseloom generate");
  app.add_option("CONFIG", request.config, "what to make (TOML; every setting: noiseloom --help-config)")->required();
  app.add_option("-o,--output", request.output, "run file to write (HDF5; *.h5 or *.hdf5)")->required();
  app.add_option("--set", request.overrides, "override a setting: --set texture.seed=2 (repeatable)")
      ->allow_extra_args(false);
  app.add_flag("--resume", request.resume,
               "go on from the run file if there is one, else start; any rank and thread count");
  app.add_flag("--overwrite", request.overwrite, "replace an existing run file");
  app.add_option("--time-limit", words.time_limit,
                 "save and stop after this long (2h, 90m, 30s), exit 75; --resume goes on");
  app.add_option("--checkpoint-every", words.checkpoint_every, "save this often (default 10m)");
  app.add_option("--threads", words.threads,
                 "threads of each rank (default: the node's processors shared by its ranks)");
  app.add_option("--watchdog", words.watchdog, watchdog_help);
  add_result_options(app, words.result, ShowsProgress::yes);
  add_progress_file(app, words.progress_to);
  app.footer(
      "Under MPI: mpirun -n 4 noiseloom generate CONFIG -o RUN.h5. A signal (USR1, USR2, TERM, INT, HUP, XCPU) or a "
      "log\n"
      "whose reader goes away (| head) stops the run at the next safe point, saved, with exit status 75. A save that\n"
      "fails is tried again. The samples are the same bytes for any number of ranks, threads and interruptions "
      "(except\n"
      "with stop.time, which follows the clock).");
}

// Returns an exit status where the command line itself ends the command (--help).
std::optional<int> read_command_line(int argc, char** argv, bool is_root, GenerateRequest& request, Shown& shown) {
  CLI::App app(
      "Makes the texture that a config describes and writes it, with all that is needed to go on, to a run file.");
  Words words;
  describe_options(app, request, words);
  if (const auto status = read_options(app, argc, argv, is_root)) return status;
  if (!words.time_limit.empty()) request.loop.time_limit_s = seconds_of("--time-limit", words.time_limit);
  if (!words.checkpoint_every.empty()) {
    request.loop.checkpoint_every_s = seconds_of("--checkpoint-every", words.checkpoint_every);
  }
  request.watch = watch_settings_of(words.watchdog);
  if (!words.threads.empty()) request.threads = threads_of(words.threads);
  if (request.resume && request.overwrite) {
    throw UserError("command line", "--resume and --overwrite exclude each other");
  }
  shown.json = words.result.json;
  shown.progress_to = words.progress_to;
  const bool to_file = !words.progress_to.empty() && words.result.progress == "auto";
  shown.kind = to_file ? ProgressKind::plain : progress_kind(words.result.progress);
  if (words.result.quiet) shown.kind = ProgressKind::quiet;
  if (!is_root) shown.kind = ProgressKind::silent;
  return std::nullopt;
}

// The numbers from the run file, then what people read.
std::vector<JsonMember> json_summary(const GenerateResult& result, const std::string& output) {
  const RunFileReader reader = open_to_look_at(output);
  const RunFileContent& content = reader.content();
  std::vector<JsonMember> members = {{"output", output}};
  if (const auto found = content.state.find("relative_error"); found != content.state.end())
    if (const double* const value = std::get_if<double>(&found->second)) members.emplace_back("relative_error", *value);
  if (const auto found = content.checksums.find("/samples"); found != content.checksums.end())
    members.emplace_back("checksum", found->second);
  for (const auto& [label, text] : result.summary) members.emplace_back(label, text);
  return members;
}

// The run file is complete by now: that its summary cannot be printed is worth a warning only.
void print_summary(const GenerateResult& result, const std::string& output, bool json, Progress& progress) {
  try {
    progress.tell("summary", progress.is_json() ? json_summary(result, output) : std::vector<JsonMember>());
    if (json) {
      fmt::print("{}\n", json_object(json_summary(result, output)));
    } else {
      fmt::print("\n");
      for (const auto& [label, text] : result.summary) fmt::print("{:<12} {}\n", label, text);
    }
    flush_standard_output();
  } catch (const std::exception& error) {
    progress.warn(fmt::format("{}; the run file is complete", error.what()));
  }
}

// Open MPI's mpirun takes every exit status but 0 for a failure.
std::string words_for_mpirun() {
  return std::getenv("OMPI_COMM_WORLD_SIZE") == nullptr
             ? ""
             : " (mpirun will say that the job was aborted: it means exit status 75, no more)";
}

int run_job(const Communicator& communicator, int argc, char** argv) {
  GenerateRequest request;
  Shown shown;
  std::optional<int> status;
  communicator.together([&] { status = read_command_line(argc, argv, communicator.is_root(), request, shown); });
  if (status) {
    communicator.on_root(flush_standard_output);
    return *status;
  }
  int descriptor = STDERR_FILENO;
  communicator.on_root([&] { descriptor = open_progress_file(shown.progress_to); });
  Progress progress(shown.kind, descriptor);
  const GenerateResult result = generate(request, communicator, progress);
  if (!result.finished) {
    progress.conclude(result.conclusion + words_for_mpirun());
    return exit_stopped;
  }
  if (communicator.is_root() && shown.kind != ProgressKind::quiet) {
    print_summary(result, request.output, shown.json, progress);
  }
  return exit_done;
}

}  // namespace

// A run that goes on has its images in its run file.
void prepare_images(int argc, char** argv) {
  GenerateRequest request;
  Shown shown;
  try {
    if (read_command_line(argc, argv, false, request, shown)) return;
  } catch (const std::exception&) {
    return;  // said when all ranks have read it
  }
  std::error_code unknown;
  if (request.resume && std::filesystem::exists(request.output, unknown)) return;
  decode_images_early(request.config, request.overrides);
}

int run_generate(int& argc, char**& argv) {
  note_stop_signals();
  prepare_images(argc - 1, argv + 1);
  MpiSession session(argc, argv);
  note_stop_signals();
  const Communicator communicator = Communicator::world();
  try {
    return run_job(communicator, argc - 1, argv + 1);
  } catch (const SharedUserError& error) {
    if (communicator.is_root()) print_faults(error.what());
    return exit_user;
  } catch (const SharedEnvironmentError& error) {
    if (communicator.is_root()) print_error(fmt::format("noiseloom generate: {}\n", error.what()));
    return exit_environment;
  } catch (const OutputLost& error) {
    if (communicator.is_root()) print_error(fmt::format("noiseloom generate: {}\n", error.what()));
    return exit_environment;
  } catch (const std::exception& error) {
    // This rank alone: the others wait for it in some exchange.
    print_error(fmt::format("noiseloom generate: rank {}: {}\n", communicator.rank().value(), error.what()));
    if (communicator.size() > 1) communicator.abort(exit_environment);
    return exit_environment;
  }
}

}  // namespace noiseloom
