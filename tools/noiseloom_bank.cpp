// bank: the options and the exit status; the work itself is bank/bank.h. Without a launcher, threads are processes of
// this program that share the folder as jobs on several machines do.

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <memory>
#include <optional>

#include "noiseloom/bank/bank.h"
#include "noiseloom/core/child_process.h"
#include "noiseloom/core/console.h"
#include "noiseloom/core/json.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/core/standard_streams.h"
#include "noiseloom/core/text.h"
#include "noiseloom/dist/launcher.h"
#include "noiseloom/run/stop_signals.h"
#include "noiseloom_commands.h"
#include "noiseloom_images.h"
#include "noiseloom_options.h"
#include "noiseloom_watchdog.h"

namespace noiseloom {
namespace {

constexpr int most_bank_threads = 1024;

struct BankOptions {
  std::string bank;
  std::vector<std::string> overrides;
  BankRequest request;
  bool resume = false;
  bool overwrite = false;
  int worker_threads = 0;  // more than 0: started by a process that has made the folder ready and says the result
  int threads = 0;
  std::string time_limit;
  std::string checkpoint_every;
  std::string watchdog = "auto";
  std::string pack;
  bool pack_links = false;
  std::string progress_to;
  int progress = STDERR_FILENO;  // a descriptor
  ResultOptions result;

  void tell(const std::string& event, std::vector<JsonMember> members) const {
    members.insert(members.begin(), {"event", event});
    write_text(progress, json_object(members) + "\n");
  }
  void warn(const std::string& line) const {
    if (result.progress == "json") return tell("warning", {{"message", line}});
    write_text(progress, "WARNING: " + line + "\n");
  }
};

double bank_seconds(const std::string& option, const std::string& text, double unset) {
  if (text.empty()) return unset;
  const std::optional<double> seconds = parse_duration(text);
  if (!seconds || *seconds <= 0) {
    throw UserError("command line", fmt::format("{} {}: not a duration; accepted: 30s, 10m, 2h, 1h30m", option, text));
  }
  return *seconds;
}

std::optional<int> read_bank_options(int argc, char** argv, bool prints, BankOptions& options) {
  CLI::App app("Makes many textures from one config: the members of a bank, a run file each, and an index of them.");
  app.name("noiseloom bank");
  app.add_option("BANK", options.bank, "what to make: a base config and what varies (TOML; every setting: --help-bank)")
      ->required();
  app.add_option("-o,--output", options.request.folder, "folder of the members, index.csv and index.json")->required();
  app.add_option("--set", options.overrides, "override a setting of the base: --set optimizer.stop.iterations=200")
      ->allow_extra_args(false);
  app.add_flag("--resume", options.resume, "go on with what the folder holds, if anything; what is done stays");
  app.add_flag("--overwrite", options.overwrite, "replace what the folder holds of this bank");
  app.add_option("--ranks-per-member", options.request.ranks_per_member,
                 "MPI processes that work on a member together (default 1)")
      ->check(CLI::Range(1, 1 << 20));
  app.add_option("--threads", options.threads,
                 "without a launcher: members made at a time (default: as many as processors); under MPI: threads of "
                 "each rank (default 1)")
      ->check(CLI::Range(1, most_bank_threads));
  app.add_option("--time-limit", options.time_limit, "save and stop after this long (2h, 90m), exit 75");
  app.add_option("--checkpoint-every", options.checkpoint_every, "save members this often (default 10m)");
  app.add_option("--pack-into", options.pack, "when all members are done, copy them into this HDF5 file, as one array");
  app.add_flag("--pack-links", options.pack_links,
               "with --pack-into: refer to the members' files (virtual datasets) instead of copying them");
  app.add_option("--watchdog", options.watchdog, watchdog_help);
  app.add_option("--worker", options.worker_threads)->group("");
  add_result_options(app, options.result, ShowsProgress::yes, "how many members there are, and how many are done");
  add_progress_file(app, options.progress_to);
  app.footer(
      "Under MPI: mpirun -n 8 noiseloom bank BANK.toml -o DIR --resume. Any number of such commands (an array of "
      "jobs)\n"
      "may share DIR: each takes the next member that is neither done nor held. Signals stop it as they stop "
      "generate.");
  if (const auto status = read_options(app, argc, argv, prints)) return status;
  if (options.resume && options.overwrite) {
    throw UserError("command line", "--resume and --overwrite exclude each other");
  }
  if (options.pack_links && options.pack.empty()) {
    throw UserError("command line", "--pack-links says how --pack-into packs, which is not given");
  }
  options.request.watch = watch_settings_of(options.watchdog);
  options.request.time_limit_s = bank_seconds("--time-limit", options.time_limit, 0);
  options.request.checkpoint_every_s = bank_seconds("--checkpoint-every", options.checkpoint_every, 600);
  return std::nullopt;
}

void say_member(const BankOptions& options, const std::vector<std::pair<std::string, std::string>>& labels) {
  if (options.result.quiet || options.result.progress == "none") return;
  if (options.result.progress == "json") {
    std::vector<JsonMember> members;
    for (const auto& [label, text] : labels) members.emplace_back(label, text);
    return options.tell("member", std::move(members));
  }
  const auto text = [&](std::size_t i) { return labels.at(i).second; };
  write_text(options.progress, fmt::format("{} of {} done: {}{}, {} s\n", text(3), text(4), text(0),
                                           text(1).empty() ? "" : "  R " + text(1), text(2)));
}

std::unique_ptr<AtWork> make_ready(const Bank& bank, const BankOptions& options) {
  const std::string& folder = options.request.folder;
  if (!options.pack.empty()) check_pack(bank, folder, options.pack, options.overwrite);
  return prepare_bank(bank, folder, options.resume, options.overwrite);
}

// `failed`: the exit status of what failed, else 0.
int conclude_bank(const Bank& bank, const BankOptions& options, bool stopped, int failed) {
  write_index(bank, options.request.folder);
  const auto [done, all] = count_done(bank, options.request.folder);
  const std::string index = options.request.folder + "/index.csv";
  std::string rest;
  int status = failed;
  if (done < all) {
    rest = failed != exit_done ? "; others failed" : "; the others are held by other processes, go on with --resume";
    if (stopped) rest = "; stopped, go on with --resume";
    if (!options.pack.empty()) rest += "; no pack was made";
    if (stopped || failed == exit_done) status = exit_stopped;
  } else if (!options.pack.empty()) {
    pack_bank(bank, options.request.folder, options.pack, options.pack_links ? PackKind::links : PackKind::copied);
  }
  if (options.result.progress == "json" && !options.result.quiet) {
    options.tell("summary", {{"index", index}, {"done", done}, {"members", all}, {"status", std::int64_t{status}}});
  }
  print_result(options.result, fmt::format("{} of {} members done: {}{}\n", done, all, index, rest),
               json_object({{"index", index}, {"done", done}, {"members", all}}) + "\n");
  flush_standard_output();
  return status;
}

int status_of(const std::vector<BankFault>& faults) {
  if (faults.empty()) return exit_done;
  const bool all_users =
      std::all_of(faults.begin(), faults.end(), [](const BankFault& fault) { return fault.is_users; });
  return all_users ? exit_user : exit_environment;
}

int work_under_mpi(const Communicator& communicator, int argc, char** argv) {
  BankOptions options;
  std::optional<int> status;
  Bank bank;
  communicator.together([&] {
    status = read_bank_options(argc, argv, communicator.is_root(), options);
    if (!status) bank = load_bank(options.bank, options.overrides);
  });
  if (status) return *status;
  std::unique_ptr<AtWork> presence;
  communicator.together([&] { options.progress = open_progress_file(options.progress_to); });
  communicator.on_root([&] {
    if (options.worker_threads == 0) presence = make_ready(bank, options);
  });
  options.request.threads = options.worker_threads > 0 ? options.worker_threads : std::max(1, options.threads);
  const BankResult result = work_on_bank(
      bank, options.request, communicator,
      [&](const std::vector<std::pair<std::string, std::string>>& labels) { say_member(options, labels); },
      [&](const std::string& line) { options.warn(line); });
  const int failed = status_of(result.faults);
  if (options.worker_threads > 0) return result.stopped ? exit_stopped : failed;  // it has said what failed
  int ends_with = exit_done;
  communicator.on_root([&] {
    for (const BankFault& fault : result.faults) print_error(fmt::format("noiseloom bank: {}\n", fault.words));
    ends_with = conclude_bank(bank, options, result.stopped, failed);
  });
  return static_cast<int>(communicator.broadcast(ends_with));
}

int run_bank_under_mpi(int& argc, char**& argv) {
  note_stop_signals();
  BankOptions early;
  try {
    if (!read_bank_options(argc - 1, argv + 1, false, early)) {
      const Bank bank = load_bank(early.bank, early.overrides);
      decode_images_early(bank.base, early.overrides);
    }
  } catch (const std::exception&) {  // said when all ranks have read it
  }
  MpiSession session(argc, argv);
  note_stop_signals();
  const Communicator communicator = Communicator::world();
  try {
    return work_under_mpi(communicator, argc - 1, argv + 1);
  } catch (const SharedUserError& error) {
    if (communicator.is_root()) print_faults(error.what());
    return exit_user;
  } catch (const SharedEnvironmentError& error) {
    if (communicator.is_root()) print_error(fmt::format("noiseloom bank: {}\n", error.what()));
    return exit_environment;
  } catch (const std::exception& error) {
    print_error(fmt::format("noiseloom bank: rank {}: {}\n", communicator.rank().value(), error.what()));
    if (communicator.size() > 1) communicator.abort(exit_environment);
    return exit_environment;
  }
}

// --- without a launcher ---

// What a worker is told: all that this process is, but for what is done once, before the workers and after them.
std::vector<std::string> words_of_worker(int argc, char** argv, int threads) {
  std::vector<std::string> words;
  for (int i = 0; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--pack-into") ++i;
    if (word == "--pack-into" || word.starts_with("--pack-into=") || word == "--pack-links" || word == "--overwrite")
      continue;
    words.push_back(word);
  }
  words.emplace_back("--worker");
  words.push_back(std::to_string(threads));
  return words;
}

// A process of this program. It dies with this one, at once: the next --resume finds no lock.
pid_t start_worker(int argc, char** argv, int threads, const sigset_t& mask) {
  std::vector<std::string> words = words_of_worker(argc, argv, threads);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid < 0) throw EnvironmentError("cannot start a process: " + std::system_category().message(errno));
  if (pid > 0) return pid;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(exit_environment);
  ::sigprocmask(SIG_SETMASK, &mask, nullptr);
  ::execv("/proc/self/exe", arguments.data());
  ::_exit(exit_environment);
}

// The greatest of their exit statuses that is not 75, else 75 where there is one, else 0.
struct WorkersEnd {
  int worst = exit_done;
  bool stopped = false;
};

WorkersEnd wait_for_workers(std::vector<pid_t> workers, StopSignals& signals) {
  WorkersEnd end;
  bool told = false;
  while (!workers.empty()) {
    constexpr double look_s = 1;
    signals.wait_for_child(look_s);
    if (signals.come() && !told) {
      told = true;
      for (const pid_t worker : workers) ::kill(worker, SIGTERM);
    }
    std::erase_if(workers, [&](pid_t worker) {
      int status = 0;
      const pid_t ended = ::waitpid(worker, &status, WNOHANG);
      if (ended == 0 || (ended < 0 && errno == EINTR)) return false;
      const int code = WIFEXITED(status) ? WEXITSTATUS(status) : exit_environment;
      if (!WIFEXITED(status)) {
        print_error(fmt::format("noiseloom bank: a process was ended by signal {}\n", WTERMSIG(status)));
      }
      if (code == exit_stopped)
        end.stopped = true;
      else
        end.worst = std::max(end.worst, code);
      return true;
    });
  }
  return end;
}

int run_bank_alone(int argc, char** argv) {
  BankOptions options;
  if (const auto status = read_bank_options(argc - 1, argv + 1, true, options)) {
    flush_standard_output();
    return *status;
  }
  options.progress = open_progress_file(options.progress_to);
  StopSignals signals;
  const Bank bank = load_bank(options.bank, options.overrides);
  const std::unique_ptr<AtWork> presence = make_ready(bank, options);
  const int threads = options.threads > 0 ? options.threads : num_available_processors();
  const int workers =
      std::clamp<int>(static_cast<int>(std::min<std::size_t>(bank.members.size(), most_bank_threads)), 1, threads);
  std::vector<pid_t> started;
  for (int worker = 0; worker < workers; ++worker) {
    started.push_back(start_worker(argc, argv, std::max(1, threads / workers), signals.mask_before()));
  }
  const WorkersEnd end = wait_for_workers(std::move(started), signals);
  return conclude_bank(bank, options, end.stopped, end.worst);
}

}  // namespace

int run_bank(int& argc, char**& argv) {
  const std::vector<std::string> words(argv + std::min(argc, 2), argv + argc);
  const auto has = [&](const char* word) { return std::find(words.begin(), words.end(), word) != words.end(); };
  if (has("--help-bank")) {
    fmt::print("{}", describe_bank_settings());
    flush_standard_output();
    return exit_done;
  }
  if (has_launcher() || has("--worker")) return run_bank_under_mpi(argc, argv);
  return run_bank_alone(argc, argv);
}

}  // namespace noiseloom
