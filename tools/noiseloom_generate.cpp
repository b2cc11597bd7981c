// generate: config to run file, on any number of ranks and threads, stopped and resumed at will.

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <optional>

#include "noiseloom/core/text.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/run_lock.h"
#include "noiseloom/run/checkpoint.h"
#include "noiseloom_commands.h"
#include "noiseloom_job.h"
#include "noiseloom_progress.h"

namespace noiseloom {
namespace {

struct Options {
  std::string config;
  std::string output;
  std::vector<std::string> overrides;
  bool resume = false;
  bool overwrite = false;
  double time_limit_s = 0;
  double checkpoint_every_s = 600;
  int threads = 0;
  std::string progress = "auto";
};

constexpr int most_threads = 1024;

// Bits that the ranks tell each other at every safe point.
constexpr std::uint32_t stop_bit = 1;
constexpr std::uint32_t limit_bit = 2;
constexpr std::uint32_t checkpoint_bit = 4;

volatile sig_atomic_t stop_signal = 0;
extern "C" void note_signal(int signal_number) { stop_signal = signal_number; }

void install_signals() {
  struct sigaction action {};
  action.sa_handler = note_signal;
  for (const int number : {SIGUSR1, SIGUSR2, SIGTERM, SIGINT}) sigaction(number, &action, nullptr);
  // A file-size limit must come back as an error of write, which is reported, and not kill the process.
  signal(SIGXFSZ, SIG_IGN);
}

double parse_seconds(const std::string& option, const std::string& text) {
  const std::optional<double> seconds = parse_duration(text);
  if (!seconds || *seconds <= 0) {
    throw UserError("command line", fmt::format("{} {}: not a duration; accepted: 30s, 10m, 2h, 1h30m", option, text));
  }
  return *seconds;
}

// Returns an exit status where the command line itself ends the command (--help).
std::optional<int> parse_command_line(int argc, char** argv, bool is_root, Options& options) {
  CLI::App app(
      "Makes the texture that a config describes and writes it, with all that is needed to go on, to a run file.");
  app.name("noiseloom generate");
  std::string time_limit;
  std::string checkpoint_every;
  std::string threads;
  app.add_option("CONFIG", options.config, "what to make (TOML; every setting: noiseloom --help-config)")->required();
  app.add_option("-o,--output", options.output, "run file to write (HDF5)")->required();
  app.add_option("--set", options.overrides, "override a setting: --set texture.seed=2 (repeatable)")
      ->allow_extra_args(false);
  app.add_flag("--resume", options.resume,
               "go on from the run file if there is one, else start; any rank and thread count");
  app.add_flag("--overwrite", options.overwrite, "replace an existing run file");
  app.add_option("--time-limit", time_limit, "save and stop after this long (2h, 90m, 30s), exit 75; --resume goes on");
  app.add_option("--checkpoint-every", checkpoint_every, "save this often (default 10m)");
  app.add_option("--threads", threads, "threads of each rank (default: the node's processors shared by its ranks)");
  app.add_option("--progress", options.progress, "auto, plain, json or none");
  app.footer(
      "Under MPI: mpirun -n 4 noiseloom generate CONFIG -o RUN.h5. SIGUSR1, SIGUSR2, SIGTERM and SIGINT save at the "
      "next\n"
      "safe point and exit with 75. The samples are the same bytes for any number of ranks, threads and interruptions\n"
      "(except with stop.time, which follows the clock).");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) throw UserError("command line", error.what());
    if (is_root) app.exit(error);
    return exit_done;
  }
  if (!time_limit.empty()) options.time_limit_s = parse_seconds("--time-limit", time_limit);
  if (!checkpoint_every.empty()) options.checkpoint_every_s = parse_seconds("--checkpoint-every", checkpoint_every);
  if (!threads.empty()) {
    const auto [end, error] = std::from_chars(threads.data(), threads.data() + threads.size(), options.threads);
    if (error != std::errc() || end != threads.data() + threads.size() || options.threads < 1 ||
        options.threads > most_threads) {
      throw UserError("command line", fmt::format("--threads {}: must be from 1 to {}", threads, most_threads));
    }
  }
  if (options.resume && options.overwrite) {
    throw UserError("command line", "--resume and --overwrite exclude each other");
  }
  progress_kind(options.progress);
  return std::nullopt;
}

std::string now_text() {
  const std::time_t now = std::time(nullptr);
  std::array<char, 32> text{};
  std::tm utc{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &utc));
  return text.data();
}

// The run file to go on from, opened and checked; nothing where there is none. Falls back to the previous generation.
std::unique_ptr<RunFileReader> open_saved(const std::string& path, Progress& progress, bool& fell_back) {
  const std::string previous = previous_generation(path);
  const bool has_previous = std::filesystem::exists(previous);
  if (!std::filesystem::exists(path) && !has_previous) {
    progress.say(fmt::format("{}: nothing to resume yet; starting afresh", path));
    return nullptr;
  }
  std::string trouble = fmt::format("{}: missing (interrupted while it was being replaced)", path);
  if (std::filesystem::exists(path)) {
    try {
      return std::make_unique<RunFileReader>(path);
    } catch (const DamagedRunFile& damage) {
      if (!has_previous) throw;
      trouble = damage.what();
    }
  }
  std::unique_ptr<RunFileReader> reader;
  try {
    reader = std::make_unique<RunFileReader>(previous);
  } catch (const UserError& error) {
    throw UserError("", trouble + "\n" + error.what());
  }
  fell_back = true;
  progress.warn(fmt::format("{}; going on from the generation before it, {}", trouble, previous));
  return reader;
}

void refuse_other_config(const RunFileReader& reader, const std::string& path, const std::string& effective,
                         const std::string& inputs) {
  std::vector<Fault> faults;
  const auto stored = reader.content().state.find("inputs");
  if (stored != reader.content().state.end() && stored->second != Attribute(inputs)) {
    faults.push_back({path, "a file that the config names (samples or filter table) has changed since"});
  }
  for (const std::string& line : config_differences(reader.content().config, effective)) faults.push_back({path, line});
  if (faults.empty()) return;
  faults.push_back(
      {path, "made from another config; resume with that one (noiseloom info shows it), or choose another output"});
  throw UserError(faults);
}

// Before anything is locked or moved: what stands there must be a run file, if anything does.
void refuse_unfit_output(const std::string& path) {
  if (path.empty()) throw UserError("command line", "-o: the name of the run file is empty");
  if (!std::filesystem::exists(path)) return;
  if (!std::filesystem::is_regular_file(path)) throw UserError(path, "is not a file; choose another output");
  if (std::filesystem::file_size(path) > 0 && !looks_like_run_file(path)) {
    throw UserError(path, "is not a run file of noiseloom, and is not replaced; choose another output");
  }
}

class Run {
 public:
  Run(const Options& options, const Communicator& communicator)
      : options_(options), communicator_(communicator), begun_(std::chrono::steady_clock::now()) {}

  int run();

 private:
  void load();
  void claim_output();
  void prepare();
  int loop();
  int stop(std::uint32_t bits);
  std::uint32_t bits_due() const;
  std::string save();
  void greet() const;
  void summarise(const std::string& checksum);
  double part_s() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count(); }
  double run_s() const { return earlier_s_ + part_s(); }
  std::map<std::string, Attribute> provenance() const;

  const Options& options_;
  const Communicator& communicator_;
  const std::chrono::steady_clock::time_point begun_;
  RunConfig config_;
  int threads_ = 1;
  std::unique_ptr<RunLock> lock_;
  std::unique_ptr<RunFileReader> saved_;
  std::unique_ptr<Progress> progress_;
  std::unique_ptr<ThreadPool> pool_;
  std::unique_ptr<Job> job_;
  bool fell_back_ = false;
  bool already_done_ = false;
  bool has_moved_ = false;  // in this part
  std::string stored_checksum_;
  std::string inputs_;
  double earlier_s_ = 0;
  double last_save_s_ = 0;
  std::int64_t parts_ = 1;
};

// Rank 0 reads the config and tells the others its effective text, so that all work on the same one.
void Run::load() {
  std::string text;
  communicator_.on_root([&] { text = to_toml(load_config(options_.config, options_.overrides)); });
  communicator_.broadcast(text);
  const std::string folder = std::filesystem::path(options_.config).parent_path().string();
  communicator_.together([&] {
    config_ = parse_config(text, options_.config, folder, {});
    job_ = make_job(config_);
  });
  communicator_.on_root([&] { inputs_ = inputs_digest(config_); });
  progress_ =
      std::make_unique<Progress>(communicator_.is_root() ? progress_kind(options_.progress) : ProgressKind::none);
}

void Run::claim_output() {
  communicator_.on_root([&] {
    const std::string& path = options_.output;
    refuse_unfit_output(path);
    lock_ = std::make_unique<RunLock>(path);
    if (!lock_->enforced())
      progress_->warn(fmt::format("{}: this file system has no locks; see that no second run writes here", path));
    remove_stale_temporaries(posix_file_ops(), path);
    if (options_.resume) {
      saved_ = open_saved(path, *progress_, fell_back_);
      if (!saved_) return;
      refuse_other_config(*saved_, path, to_toml(config_), inputs_);
      const auto& provenance = saved_->content().provenance;
      if (const auto parts = provenance.find("parts"); parts != provenance.end()) {
        parts_ = 1 + std::get<std::int64_t>(parts->second);
      }
      if (const auto seconds = provenance.find("seconds_total"); seconds != provenance.end()) {
        earlier_s_ = std::get<double>(seconds->second);
      }
    } else if (!options_.overwrite && std::filesystem::exists(path)) {
      throw UserError(path, "exists; go on from it with --resume, or replace it with --overwrite");
    }
  });
}

void Run::prepare() {
  const int on_node = communicator_.ranks_on_node();
  threads_ = options_.threads > 0 ? options_.threads : std::max(1, num_available_processors() / on_node);
  communicator_.together([&] { pool_ = std::make_unique<ThreadPool>(threads_); });
  job_->prepare(communicator_, *pool_);
  greet();
  const bool resumed = communicator_.any_bits(saved_ ? 1U : 0U) != 0;
  if (!resumed) return job_->start(run_s());
  job_->restore(saved_.get());
  progress_->say("resumed at " + job_->position());
  communicator_.on_root([&] {
    if (fell_back_) restore_previous_generation(posix_file_ops(), options_.output);
  });
  already_done_ = job_->finished();
  if (saved_) stored_checksum_ = saved_->content().checksums.at("/samples");
  saved_.reset();
}

void Run::greet() const {
  if (!communicator_.is_root()) return;
  progress_->say(fmt::format("{} on {} {} of {} {}", job_->title(), communicator_.size(),
                             communicator_.size() == 1 ? "rank" : "ranks", threads_,
                             threads_ == 1 ? "thread" : "threads"));
  const SliceIndex slices = config_.problem.extents.num_slices();
  if (communicator_.size() > slices) {
    progress_->say(
        fmt::format("{} of {} ranks have no slice and only wait", communicator_.size() - slices, communicator_.size()));
  }
  if (slices > 1 && !job_->is_coupled()) {
    progress_->say("the filter does not couple slices: ranks exchange nothing");
  }
}

std::map<std::string, Attribute> Run::provenance() const {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  return {{"version", std::string(NOISELOOM_VERSION)},
          {"saved_at", now_text()},
          {"config_folder", std::filesystem::absolute(options_.config).parent_path().string()},
          {"host", std::string(host.data())},
          {"ranks", std::int64_t{communicator_.size()}},
          {"threads", std::int64_t{threads_}},
          {"parts", parts_},
          {"seconds_total", run_s()}};
}

std::string Run::save() {
  last_save_s_ = part_s();
  return job_->save({options_.output, inputs_, provenance()});
}

// Any rank may have got a signal; of the clocks only that of rank 0 counts.
std::uint32_t Run::bits_due() const {
  std::uint32_t bits = stop_signal != 0 ? stop_bit : 0;
  if (!communicator_.is_root()) return bits;
  // Not before the first step: a limit shorter than the start-up would otherwise be resumed for ever.
  if (options_.time_limit_s > 0 && has_moved_ && part_s() >= options_.time_limit_s) bits |= limit_bit;
  if (part_s() - last_save_s_ >= options_.checkpoint_every_s) bits |= checkpoint_bit;
  return bits;
}

int Run::stop(std::uint32_t bits) {
  save();
  progress_->say(fmt::format("stopped by {} at {}; everything is saved in {}; go on with --resume",
                             (bits & stop_bit) != 0 ? "a signal" : "--time-limit", job_->position(), options_.output));
  return exit_stopped;
}

int Run::loop() {
  while (!job_->finished()) {
    const std::uint32_t bits = communicator_.any_bits(bits_due());
    if ((bits & (stop_bit | limit_bit)) != 0) return stop(bits);
    if ((bits & checkpoint_bit) != 0) {
      save();
      progress_->say("saved at " + job_->position());
    }
    job_->step(run_s());
    has_moved_ = true;
    progress_->update(job_->num_rows(), part_s(), [&] { return job_->figures(run_s(), part_s()); });
  }
  return exit_done;
}

void Run::summarise(const std::string& checksum) {
  const auto lines = job_->summary(run_s());
  progress_->end();
  if (options_.progress == "none" || !communicator_.is_root()) return;
  fmt::print("\n");
  for (const auto& [label, text] : lines) fmt::print("{:<12} {}\n", label, text);
  fmt::print("file         {}   /samples {}\n", options_.output, checksum);
  fmt::print("next         noiseloom export {} -o {}\n", options_.output,
             std::filesystem::path(options_.output).stem().string());
}

int Run::run() {
  load();
  claim_output();
  prepare();
  const int status = loop();
  if (status != exit_done) return status;
  summarise(already_done_ ? stored_checksum_ : save());
  return exit_done;
}

}  // namespace

int run_generate(int& argc, char**& argv) {
  MpiSession session(argc, argv);
  const Communicator communicator = Communicator::world();
  install_signals();
  try {
    Options options;
    std::optional<int> status;
    communicator.together([&] { status = parse_command_line(argc - 1, argv + 1, communicator.is_root(), options); });
    return status ? *status : Run(options, communicator).run();
  } catch (const SharedUserError& error) {
    if (communicator.is_root()) print_faults(error.what());
    return exit_user;
  } catch (const SharedEnvironmentError& error) {
    if (communicator.is_root()) fmt::print(stderr, "noiseloom generate: {}\n", error.what());
    return exit_environment;
  } catch (const std::exception& error) {
    // This rank alone: the others wait for it in some exchange.
    fmt::print(stderr, "noiseloom generate: rank {}: {}\n", communicator.rank(), error.what());
    if (communicator.size() > 1) communicator.abort(exit_environment);
    return exit_environment;
  }
}

}  // namespace noiseloom
