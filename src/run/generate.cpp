#include "noiseloom/run/generate.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <map>
#include <memory>

#include "noiseloom/config/config.h"
#include "noiseloom/config/inputs.h"
#include "noiseloom/core/console.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/core/quantity_text.h"
#include "noiseloom/dist/activity.h"
#include "noiseloom/files/output_probe.h"
#include "noiseloom/run/checkpoint.h"
#include "noiseloom/run/job.h"
#include "noiseloom/run/resume.h"
#include "noiseloom/run/shared_inputs.h"
#include "noiseloom/run/stop_signals.h"
#include "run/jobs/memory_words.h"
#include "run/output.h"

namespace noiseloom {
namespace {

std::string now_text() {
  const std::time_t now = std::time(nullptr);
  std::array<char, 32> text{};
  std::tm utc{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &utc));
  return text.data();
}

class Generation {
 public:
  Generation(const GenerateRequest& request, const Communicator& communicator, Progress& progress)
      : request_(request), communicator_(communicator), progress_(progress) {}

  GenerateResult run();

 private:
  void load();
  bool claim_output();
  void take_inputs();
  void read_provenance();
  void probe() const;
  void take_up();
  void begin();
  void greet() const;
  bool asked_to_stop() const;
  GenerateResult stopped_before_start() const;
  GenerateResult stopped(const LoopResult& end) const;
  std::string save();
  void remove_previous_generation() const;
  std::vector<std::pair<std::string, std::string>> summary(const std::string& checksum);
  std::map<std::string, Attribute> provenance() const;
  double run_s() const { return earlier_s_ + surroundings_.part_s(); }

  const GenerateRequest& request_;
  const Communicator& communicator_;
  Progress& progress_;
  const Surroundings surroundings_ = real_surroundings();
  RunConfig config_;
  std::unique_ptr<Job> job_;
  std::unique_ptr<RunLock> lock_;
  NewestGeneration saved_;  // rank 0, until it is restored
  std::unique_ptr<ThreadPool> pool_;
  int threads_ = 1;
  bool resumed_ = false;
  std::string stored_checksum_;  // of the run that was resumed
  double earlier_s_ = 0;         // that the earlier parts of the run took
  std::int64_t parts_ = 1;
  std::string run_;            // drawn when it began, the same in all its parts
  std::string config_folder_;  // absolute, as it was at the start: the working folder may go away
};

// Rank 0 reads the config and tells the others its effective text, so that all work on the same one.
void Generation::load() {
  std::string text;
  communicator_.on_root([&] {
    std::vector<Fault> faults;
    const auto collecting = [&faults](const auto& body) {
      try {
        body();
      } catch (const UserError& error) {
        faults.insert(faults.end(), error.faults().begin(), error.faults().end());
      }
    };
    // A run that goes on has in its run file what it was made from.
    std::error_code absent;  // a name that cannot be looked up is refused below, with the reason
    const bool goes_on = request_.resume && (std::filesystem::exists(request_.output, absent) ||
                                             std::filesystem::exists(previous_generation(request_.output), absent));
    const MissingFiles missing = goes_on ? MissingFiles::accepted : MissingFiles::refused;
    collecting([&] { text = to_toml(load_config(request_.config, request_.overrides, missing)); });
    collecting([&] { refuse_unfit_output(request_.output); });
    throw_if_any(std::move(faults));
  });
  communicator_.broadcast(text);
  std::error_code unknown;
  config_folder_ = std::filesystem::absolute(request_.config, unknown).parent_path().string();
  const std::string folder = std::filesystem::path(request_.config).parent_path().string();
  communicator_.together([&] { config_ = parse_config(text, request_.config, folder, {}, MissingFiles::accepted); });
}

// False where another run holds it and that is to be no fault.
bool Generation::claim_output() {
  bool held = false;
  communicator_.on_root([&] {
    const std::string& path = request_.output;
    try {
      lock_ = lock_output(path, communicator_.size(), progress_);
    } catch (const OutputHeld&) {
      held = request_.skip_if_held;
      if (held) return;
      throw;
    }
    const std::string mismatch = request_.skip_if_held ? "" : launcher_mismatch(communicator_.size());
    if (!mismatch.empty()) progress_.warn(mismatch);
    remove_stale_temporaries(posix_file_ops(), path);
    run_ = lock_->number();
    if (request_.resume) {
      saved_ = open_saved_run(path, progress_);
      if (!saved_.reader) return;
      throw_if_any(resume_faults(*saved_.reader, config_));
      read_provenance();
    } else if (!request_.overwrite) {
      refuse_existing_output(path);
    }
  });
  constexpr std::uint32_t held_bit = 2;
  const std::uint32_t bits = communicator_.any_bits((saved_.reader ? 1U : 0U) | (held ? held_bit : 0U));
  resumed_ = (bits & 1U) != 0;
  return (bits & held_bit) == 0;
}

// The files that the config names, as all ranks work from them; then the job, which checks them.
void Generation::take_inputs() {
  naming_shortage("reading the files that the config names",
                  [&] { share_inputs(config_, saved_.reader.get(), communicator_); });
  communicator_.together([&] {
    naming_shortage("reading the files that the config names", [&] {
      settle_method(config_);
      job_ = make_job(config_);
    });
  });
  if (!communicator_.is_root()) return;
  for (const InputNote& note : notes_on_inputs(config_)) progress_.warn(note.text);
  if (!saved_.reader) return;
  for (const std::string& file : changed_inputs(config_)) {
    progress_.warn(fmt::format("{} has changed since the run began; it goes on with what it began with", file));
  }
}

void Generation::read_provenance() {
  const auto& provenance = saved_.reader->content().provenance;
  if (const auto parts = provenance.find("parts"); parts != provenance.end()) {
    // What counts for nothing but a person's eye is taken where it makes sense, and else begins anew.
    const auto* count = std::get_if<std::int64_t>(&parts->second);
    constexpr std::int64_t most_parts = 1'000'000'000;
    if (count != nullptr && *count >= 0 && *count < most_parts) parts_ = 1 + *count;
  }
  if (const auto run = provenance.find("run"); run != provenance.end()) {
    if (const auto* known = std::get_if<std::string>(&run->second)) run_ = *known;
  }
  if (const auto seconds = provenance.find("seconds_total"); seconds != provenance.end()) {
    const auto* earlier = std::get_if<double>(&seconds->second);
    if (earlier == nullptr || !std::isfinite(*earlier) || *earlier < 0) {
      throw UserError(request_.output, "/provenance: seconds_total is no number of seconds; no run wrote this");
    }
    earlier_s_ = *earlier;
  }
}

void Generation::take_up() {
  const int on_node = communicator_.ranks_on_node();
  threads_ = request_.threads > 0 ? request_.threads : std::max(1, num_available_processors() / on_node);
  communicator_.together([&] {
    naming_shortage(fmt::format("starting {} threads", threads_),
                    [&] { pool_ = std::make_unique<ThreadPool>(threads_); });
  });
  job_->prepare(communicator_, *pool_);
  greet();
}

void Generation::begin() {
  if (!resumed_) {
    const double before_s = surroundings_.part_s();
    if (!job_->start_words().empty()) progress_.say("start: " + job_->start_words());
    naming_shortage("starting", [&] { job_->start(run_s()); });
    progress_.say(
        fmt::format("started in {} at {}", duration_text(surroundings_.part_s() - before_s), job_->position()));
    return;
  }
  naming_shortage("restoring the saved run", [&] { job_->restore(saved_.reader.get()); });
  progress_.say("resumed at " + job_->position());
  communicator_.on_root([&] {
    if (saved_.is_previous) restore_previous_generation(posix_file_ops(), request_.output);
    stored_checksum_ = saved_.reader->content().checksums.at("/samples");
    saved_.reader.reset();
  });
}

void Generation::greet() const {
  progress_.tell("start", {{"output", request_.output},
                           {"title", job_->title()},
                           {"ranks", std::int64_t{communicator_.size()}},
                           {"threads", std::int64_t{threads_}}});
  progress_.say(fmt::format("{} on {} {} of {} {}", job_->title(), communicator_.size(),
                            communicator_.size() == 1 ? "rank" : "ranks", threads_,
                            threads_ == 1 ? "thread" : "threads"));
  const std::int32_t slices = config_.problem.extents.num_slices();
  if (communicator_.size() > slices) {
    progress_.say(
        fmt::format("{} of {} ranks have no slice and only wait", communicator_.size() - slices, communicator_.size()));
  }
  if (slices > 1 && !job_->is_coupled()) {
    progress_.say("the filter does not couple slices: ranks exchange nothing");
  }
}

std::map<std::string, Attribute> Generation::provenance() const {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  return {{"version", std::string(NOISELOOM_VERSION)},
          {"saved_at", now_text()},
          {"config_folder", config_folder_},
          {"host", std::string(host.data())},
          {"ranks", std::int64_t{communicator_.size()}},
          {"threads", std::int64_t{threads_}},
          {"parts", parts_},
          {"run", run_},
          {"incarnation", lock_ ? lock_->number() : ""},
          {"seconds_total", run_s()}};
}

// Throws OutputLost on every rank, which no further try would mend; SharedEnvironmentError for all that one may.
std::string Generation::save() {
  std::string lost;
  communicator_.on_root([&] {
    try {
      confirm_output(request_.output);
    } catch (const OutputLost& error) {
      lost = error.what();
    }
  });
  communicator_.broadcast(lost);
  if (!lost.empty()) throw OutputLost(lost);
  return job_->save({request_.output, provenance()});
}

// Before hours are spent: whether a save will find its place.
void Generation::probe() const {
  communicator_.on_root([&] {
    const std::uint64_t bytes =
        run_file_bytes(config_.problem.extents, job_->datasets(), to_toml(config_).size() + inputs_bytes(config_));
    for (const std::string& warning : probe_output(request_.output, bytes)) progress_.warn(warning);
  });
}

// Of a run that is over, the newest generation is all there is to keep. That the other cannot be removed harms nothing.
void Generation::remove_previous_generation() const {
  communicator_.on_root([&] {
    const std::string previous = previous_generation(request_.output);
    try {
      if (!posix_file_ops().exists(previous)) return;
      if (looks_like_run_file(previous)) return posix_file_ops().remove(previous);
      progress_.warn(previous + ": is no generation of this run file, and is left as it is");
    } catch (const EnvironmentError& error) {
      progress_.warn(error.what());
    }
  });
}

bool Generation::asked_to_stop() const {
  return communicator_.any_bits(surroundings_.stop_signal() != 0 ? 1U : 0U) != 0;
}

GenerateResult Generation::stopped_before_start() const {
  const int number = surroundings_.stop_signal();
  GenerateResult result;
  result.conclusion = fmt::format("stopped by {} before anything was computed; {}; run the same command again{}",
                                  number != 0 ? signal_name(number) : "a signal to another rank",
                                  resumed_ ? request_.output + " is as it was" : "there is nothing to save yet",
                                  request_.overwrite || request_.resume ? "" : " (--resume will do, too)");
  return result;
}

GenerateResult Generation::stopped(const LoopResult& end) const {
  GenerateResult result;
  result.conclusion = fmt::format("stopped by {} at {}; everything is saved in {}; go on with --resume", end.stopped_by,
                                  job_->position(), request_.output);
  return result;
}

std::vector<std::pair<std::string, std::string>> Generation::summary(const std::string& checksum) {
  auto lines = job_->summary(run_s());
  lines.emplace_back("file", fmt::format("{}   /samples {}", request_.output, checksum));
  lines.emplace_back("next", fmt::format("noiseloom export {} -o {}", request_.output,
                                         std::filesystem::path(request_.output).stem().string()));
  return lines;
}

// A start is no step. But once steps are counted, as in a bank after its first member, a long start must not look like
// none being made.
void note_start_goes_on() {
  if (num_steps_noted() > 0) note_step();
}

GenerateResult Generation::run() {
  const Watchdog watchdog(
      communicator_, request_.watch, [this](const std::string& line) { progress_.warn(line); },
      [](const std::string& words) { print_error(fmt::format("noiseloom generate: {}\n", words)); });
  load();
  if (!claim_output()) {
    GenerateResult result;
    result.held = true;
    return result;
  }
  note_start_goes_on();
  take_inputs();
  note_start_goes_on();
  if (asked_to_stop()) return stopped_before_start();
  try {
    take_up();
    if (asked_to_stop()) return stopped_before_start();
    if (!resumed_) probe();
    note_start_goes_on();
    begin();
  } catch (const StartStopped&) {
    return stopped_before_start();
  }
  note_start_goes_on();
  if (resumed_ && !job_->finished()) probe();
  std::string checksum = stored_checksum_;
  // A run may be over as it starts, where nothing can be swapped; only a resumed one is saved already.
  if (!resumed_ || !job_->finished()) {
    const SaveRun save_now = [this] { return save(); };
    RunLoop loop(*job_, request_.loop, earlier_s_, surroundings_, save_now, communicator_, progress_);
    LoopResult end;
    naming_shortage("computing", [&] { end = loop.run(); });
    progress_.end();
    if (!end.finished) return stopped(end);
    checksum = end.checksum;
  }
  remove_previous_generation();
  GenerateResult result;
  result.finished = true;
  result.summary = summary(checksum);
  return result;
}

}  // namespace

GenerateResult generate(const GenerateRequest& request, const Communicator& communicator, Progress& progress) {
  return Generation(request, communicator, progress).run();
}

}  // namespace noiseloom
