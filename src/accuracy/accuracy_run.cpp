#include "noiseloom/accuracy/accuracy_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "accuracy/accuracy_command.h"
#include "accuracy/accuracy_score.h"
#include "noiseloom/accuracy/accuracy_report.h"
#include "noiseloom/core/child_process.h"
#include "noiseloom/core/console.h"
#include "noiseloom/core/json.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/output_files.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/files/run_lock.h"
#include "noiseloom/run/checkpoint.h"

namespace noiseloom {
namespace fs = std::filesystem;
namespace {

// A run that was expected to fit is not stopped at once when it does not.
constexpr double overrun_share = 0.1;

constexpr const char* inputs_mark = "# inputs: ";

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file) text << file.rdbuf();
  if (!file) throw EnvironmentError(path + ": cannot be read");
  return std::move(text).str();
}

class Study {
 public:
  Study(const AccuracyOptions& options, std::vector<Fault> faults) : options_(options), faults_(std::move(faults)) {}

  AccuracyEnd run();

 private:
  std::string path(const std::string& file) const { return (fs::path(options_.folder) / file).string(); }
  double session_s() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count(); }
  double spent_s() const { return earlier_s_ + session_s(); }
  double left_s() const { return options_.budget_s - spent_s(); }

  void load();
  void check_folder();
  void read_earlier();
  std::string stored_config() const;
  void claim();
  void remove_partial_files() const;
  void remove_broken_runs() const;
  void publish(const std::string& state, const std::vector<LeftOut>& left_out);
  std::vector<LeftOut> not_yet(const std::string& reason) const;
  const AccuracyRow* row_to_complete() const;
  bool run_point(const AccuracyPoint& point);
  AccuracyRow& row_of(const AccuracyPoint& point);
  void add_run(const AccuracyPoint& point, const std::string& file, double seconds);
  void remove_run(const std::string& file) const;
  AccuracyEnd finish(const std::vector<LeftOut>& left_out);
  AccuracyEnd stop();
  void print_end(std::size_t num_left_out) const;

  const AccuracyOptions& options_;
  std::vector<Fault> faults_;
  const std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  RunConfig config_;
  std::string inputs_;
  AccuracyLadder ladder_;
  std::unique_ptr<PointCommands> commands_;
  std::vector<AccuracyRow> rows_;
  std::vector<LeftOut> failed_;
  double earlier_s_ = 0;
  StopSignals signals_;
  std::unique_ptr<RunLock> lock_;
  std::unique_ptr<RunScorer> scorer_;
};

// Everything that can be wrong is looked for before the folder is touched.
void Study::load() {
  try {
    config_ = load_config(options_.config, options_.overrides);
  } catch (const UserError& error) {
    faults_.insert(faults_.end(), error.faults().begin(), error.faults().end());
  }
  check_folder();
  throw_if_any(faults_);
  const Extents& extents = config_.problem.extents;
  const SampleSource source(config_.problem.samples, extents.cells_per_slice(), extents.num_slices(),
                            config_.problem.seed);
  inputs_ = inputs_digest(config_);
  ladder_ = accuracy_ladder(config_, ladder_traits(config_, source), options_.seeds);
  commands_ = std::make_unique<PointCommands>(options_, config_);
  commands_->check(ladder_);
  if (options_.resume && fs::exists(path("accuracy.csv"))) read_earlier();
}

void Study::check_folder() {
  if (fs::exists(options_.folder) && !fs::is_directory(options_.folder))
    return faults_.push_back({options_.folder, "is not a folder; choose another output"});
  for (const char* const file : {"accuracy.csv", "report.html", "config.toml"}) {
    if (fs::is_directory(path(file))) faults_.push_back({path(file), "is a folder"});
    if (options_.overwrite || !fs::exists(path(file))) continue;
    if (!options_.resume)
      return faults_.push_back({path(file), "exists; go on with --resume, or replace it with --overwrite"});
    if (!fs::exists(path("accuracy.csv")) || !fs::exists(path("config.toml")))
      return faults_.push_back({options_.folder, fmt::format("holds {}, but not both accuracy.csv and config.toml: "
                                                             "nothing to resume; --overwrite replaces what is there",
                                                             file)});
  }
}

std::string Study::stored_config() const {
  return fmt::format(
      "# What the points in accuracy.csv were measured for; `noiseloom accuracy --resume` compares it.\n{}{}\n\n{}",
      inputs_mark, inputs_.empty() ? "none" : inputs_, to_toml(config_));
}

void Study::read_earlier() {
  const std::string stored = read_file(path("config.toml"));
  std::vector<Fault> faults;
  for (const std::string& line : config_differences(stored, to_toml(config_)))
    faults.push_back({path("config.toml"), line});
  const std::string inputs = inputs_mark + (inputs_.empty() ? std::string("none") : inputs_) + "\n";
  if (faults.empty() && stored.find(inputs) == std::string::npos)
    faults.push_back({path("config.toml"), "a file that the config names (samples or filter table) has changed since"});
  if (!faults.empty())
    faults.push_back({options_.folder, "measured for another config; resume with that one, or choose another output"});
  throw_if_any(std::move(faults));
  rows_ = parse_accuracy_csv(read_file(path("accuracy.csv")), path("accuracy.csv"));
  for (AccuracyRow& row : rows_) {
    // Where the config stops by another rule, the default's count is a result and no part of the point.
    if (row.point.is_default) row.point.iterations = ladder_.default_point().iterations;
    if (!is_on_ladder(ladder_, row.point) || row.seed != config_.problem.seed)
      throw UserError(path("accuracy.csv"), fmt::format("{} (seed {}) is no point of this version's ladder; choose "
                                                        "another output, or replace it with --overwrite",
                                                        describe_row(row), row.seed));
    earlier_s_ += row.seconds * row.runs;
  }
}

// Left by a process that was killed while it wrote (output_files.h).
void Study::remove_partial_files() const {
  std::vector<fs::path> partial;
  for (const fs::directory_entry& entry : fs::directory_iterator(options_.folder))
    for (const char* const stem : {".accuracy.partial-", ".report.partial-", ".config.partial-"})
      if (entry.path().filename().string().starts_with(stem)) partial.push_back(entry.path());
  std::error_code ignored;
  for (const fs::path& file : partial) fs::remove(file, ignored);
}

void Study::claim() {
  std::error_code error;
  fs::create_directories(options_.folder, error);
  if (error) throw EnvironmentError(fmt::format("{}: cannot create the folder: {}", options_.folder, error.message()));
  lock_ = std::make_unique<RunLock>(path("accuracy.csv"));
  remove_partial_files();
  fs::create_directories(path("runs"), error);
  if (error) throw EnvironmentError(fmt::format("{}: cannot create the folder: {}", path("runs"), error.message()));
  remove_broken_runs();
  OutputFiles output(posix_file_ops(), true);
  output.write(path("config.toml"), stored_config());
  output.write(path("accuracy.csv"), accuracy_csv(rows_));
  output.commit();
}

void Study::publish(const std::string& state, const std::vector<LeftOut>& left_out) {
  OutputFiles output(posix_file_ops(), true);
  output.write(path("accuracy.csv"), accuracy_csv(rows_));
  output.write(path("report.html"), accuracy_html({options_.config, config_, rows_, left_out, options_.budget_s,
                                                   spent_s(), state, options_.origin}));
  output.commit();
}

std::vector<LeftOut> Study::not_yet(const std::string& reason) const {
  std::vector<LeftOut> left_out =
      next_step(ladder_, timed(rows_, options_.seeds), failed_, 0, options_.budget_s).left_out;
  for (LeftOut& left : left_out)
    if (!left.is_final) left.reason = reason;
  return left_out;
}

void Study::remove_run(const std::string& file) const {
  std::error_code ignored;  // what will not go is in nobody's way
  for (const char* const ending : {"", ".prev", ".lock"}) fs::remove(file + ending, ignored);
  remove_stale_temporaries(posix_file_ops(), file);
}

// Left by a run that was killed together with the command: its lock says which.
void Study::remove_broken_runs() const {
  constexpr std::string_view lock = ".lock";
  std::vector<std::string> broken;
  for (const fs::directory_entry& entry : fs::directory_iterator(path("runs"))) {
    const std::string file = entry.path().string();
    if (file.ends_with(lock)) broken.push_back(file.substr(0, file.size() - lock.size()));
  }
  for (const std::string& file : broken) remove_run(file);
}

// A point that lacks runs, because it was stopped among them or asked for with fewer seeds, and whose next is expected
// to fit.
const AccuracyRow* Study::row_to_complete() const {
  const auto found = std::find_if(rows_.begin(), rows_.end(), [&](const AccuracyRow& row) {
    return row.runs < options_.seeds && row.threads == commands_->threads() && row.seconds <= left_s();
  });
  return found == rows_.end() ? nullptr : &*found;
}

AccuracyRow& Study::row_of(const AccuracyPoint& point) {
  const auto found =
      std::find_if(rows_.begin(), rows_.end(), [&](const AccuracyRow& row) { return row.point == point; });
  if (found != rows_.end()) return *found;
  AccuracyRow row;
  row.point = point;
  row.seed = config_.problem.seed;
  row.threads = commands_->threads();
  row.command = commands_->command(point).shown;
  return rows_.emplace_back(std::move(row));
}

void Study::add_run(const AccuracyPoint& point, const std::string& file, double seconds) {
  if (!scorer_) scorer_ = std::make_unique<RunScorer>(commands_->threads());
  const RunScores scores = scorer_->score(file);
  AccuracyRow& row = row_of(point);
  row.iterations = point.iterations > 0 || !has_iterations(point.method) ? point.iterations : scores.iterations;
  row.add({seconds, scores.relative_error, scores.r_8bit, scores.r_16bit});
  // Before the row is there: a study that is killed between the two makes the run again, and leaves none behind.
  if (!options_.keep) remove_run(file);
  publish("Still running", not_yet("has not run yet"));
  if (row.runs < options_.seeds) return;
  options_.say(
      fmt::format("{:<52} {:>12}   R {}", describe_row(row), seconds_text(row.seconds), error_with_spread(row)));
}

// One run more of the point. False when it was asked to stop.
bool Study::run_point(const AccuracyPoint& point) {
  const auto before =
      std::find_if(rows_.begin(), rows_.end(), [&](const AccuracyRow& row) { return row.point == point; });
  const PointCommand command = commands_->command(point, before == rows_.end() ? 0 : before->runs);
  remove_run(command.output);
  const double limit_s = std::max(left_s(), 0.0) + overrun_share * options_.budget_s;
  const ChildResult result = run_child(command.words, limit_s, signals_);
  if (result.end != ChildResult::End::exited || result.status != 0) remove_run(command.output);
  if (result.end == ChildResult::End::stopped) return false;
  if (result.end == ChildResult::End::overran) {
    const std::string reason =
        fmt::format("was stopped after {}, when the budget was used up", seconds_text(result.seconds));
    if (before == rows_.end()) failed_.push_back({point, reason, true});
    return true;
  }
  if (result.status != 0)
    throw EnvironmentError(
        fmt::format("this run failed with exit status {}:\n  {}\nwhat ran before it is saved; go on "
                    "with --resume",
                    result.status, command.shown));
  add_run(point, command.output, result.seconds);
  return true;
}

AccuracyEnd Study::stop() {
  publish("Stopped by a signal; --resume goes on", not_yet("had not run when the command was stopped"));
  if (!options_.quiet)
    print_error(fmt::format("stopped by a signal after {} point{}; everything is saved in {}; go on with --resume\n",
                            rows_.size(), rows_.size() == 1 ? "" : "s", options_.folder));
  return AccuracyEnd::stopped;
}

AccuracyEnd Study::finish(const std::vector<LeftOut>& left_out) {
  publish("Complete", left_out);
  if (!options_.quiet) print_end(left_out.size());
  return AccuracyEnd::complete;
}

void Study::print_end(std::size_t num_left_out) const {
  std::vector<std::string> sentences = {
      fmt::format("no point fits into the budget of {}", seconds_text(options_.budget_s))};
  if (!rows_.empty()) sentences = accuracy_sentences(rows_);
  std::string list;
  for (const std::string& sentence : sentences)
    list += options_.json ? (list.empty() ? "" : ", ") + json_string(sentence) : sentence + "\n";
  if (!options_.json) {
    fmt::print("{}{} points ran, {} were left out; wrote {}\n", list, rows_.size(), num_left_out, path("report.html"));
    return;
  }
  fmt::print("{{\"points\": {}, \"left_out\": {}, \"table\": {}, \"report\": {}, \"sentences\": [{}]}}\n", rows_.size(),
             num_left_out, json_string(path("accuracy.csv")), json_string(path("report.html")), list);
}

AccuracyEnd Study::run() {
  load();
  claim();
  options_.say(fmt::format("{}: {} of {} used, {} points so far", options_.config, seconds_text(spent_s()),
                           seconds_text(options_.budget_s), rows_.size()));
  AccuracyEnd end = AccuracyEnd::stopped;
  for (;;) {
    if (signals_.come()) {
      end = stop();
      break;
    }
    const AccuracyRow* const started = row_to_complete();
    const LadderStep step =
        started != nullptr ? LadderStep{started->point, {}}
                           : next_step(ladder_, timed(rows_, options_.seeds), failed_, left_s(), options_.budget_s);
    if (!step.next) {
      end = finish(step.left_out);
      break;
    }
    if (!run_point(*step.next)) {
      end = stop();
      break;
    }
  }
  std::error_code ignored;
  fs::remove(path("runs"), ignored);  // only when it is empty
  return end;
}

}  // namespace

AccuracyEnd run_accuracy(const AccuracyOptions& options, std::vector<Fault> faults) {
  return Study(options, std::move(faults)).run();
}

}  // namespace noiseloom
