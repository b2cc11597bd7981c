#include "noiseloom/run/resume.h"

#include <fmt/format.h>

#include "noiseloom/anneal/schedule.h"
#include "noiseloom/anneal/swap_choices.h"
#include "noiseloom/config/stored_config.h"
#include "noiseloom/files/file_ops.h"
#include "noiseloom/run/checkpoint.h"
#include "noiseloom/run/construct_checkpoint.h"

namespace noiseloom {
namespace {

std::string rule_name(const StopSpec& stop) {
  if (stop.is_none()) return "none";
  if (stop.iterations > 0) return "iterations";
  if (stop.time_s > 0) return "time";
  return stop.score > 0 ? "score" : "improvement";
}

std::string value_of(const StopSpec& stop) {
  if (stop.is_none()) return "none";
  if (stop.iterations > 0) return fmt::format("{}", stop.iterations);
  if (stop.time_s > 0) return fmt::format("{} s", stop.time_s);
  return fmt::format("{}", stop.score > 0 ? stop.score : stop.improvement);
}

std::string why_not_more_iterations(const OptimizerSpec& before, const OptimizerSpec& now) {
  const std::int64_t first = before.stop.iterations;
  const std::int64_t second = now.stop.iterations;
  if (second < first) return "a run can be extended, not shortened";
  if (before.method != Method::fast) {
    return fmt::format(
        "annealing cools from the first iteration to the last, so a run of {} is not one of {} and {} "
        "more",
        second, first, second - first);
  }
  if (before.grow_fraction && sweeps_per_fraction(first) != sweeps_per_fraction(second)) {
    return fmt::format("the fraction grows once in {} sweeps of the one and in {} of the other (grow_fraction)",
                       sweeps_per_fraction(first), sweeps_per_fraction(second));
  }
  return "";
}

std::string reason(const OptimizerSpec& before, const OptimizerSpec& now) {
  const StopSpec& first = before.stop;
  const StopSpec& second = now.stop;
  // A construction may be annealed later.
  if (first.is_none() && before.method == Method::construct) return "";
  if (rule_name(first) != rule_name(second)) return "the rule itself must stay, as the schedule follows from it";
  if (first.time_s > 0) return "the temperature follows the clock to the end, so another end is another run";
  if (first.iterations > 0) return why_not_more_iterations(before, now);
  const bool further = second.score < first.score || second.improvement < first.improvement;
  return further ? "" : "a run can be extended (to a lower value), not shortened";
}

std::vector<Fault> config_faults(const RunFileReader& saved, RunConfig config) {
  const RunConfig stored = stored_config(saved.content(), saved.path());
  // A list that is no longer there leaves open what `auto` stands for; the run has it.
  if (config.optimizer.method == Method::automatic) {
    config.optimizer.method = stored.optimizer.method;
    if (config.optimizer.stop.is_none() && config.optimizer.method != Method::construct) config.optimizer.stop = {};
  }
  // What the one leaves open and the other says may be the same; and nothing of a construction depends on it.
  if (is_construct_run(saved.content()) || energy_cutoff(stored.optimizer) == energy_cutoff(config.optimizer)) {
    config.optimizer.cutoff = stored.optimizer.cutoff;
  }
  const std::string text = to_toml(stored);  // with what older files do not say yet
  std::vector<std::string> lines = config_differences(text, to_toml(config));
  if (lines.empty()) return {};
  RunConfig with_stored_stop = config;
  with_stored_stop.optimizer.stop = stored.optimizer.stop;
  if (config_differences(text, to_toml(with_stored_stop)).empty()) {
    // What is annealed later is constructed alike, whatever the rule.
    if (is_construct_run(saved.content())) return {};
    const std::string why = why_not_extended(stored.optimizer, config.optimizer);
    return why.empty() ? std::vector<Fault>{} : std::vector<Fault>{{saved.path(), why}};
  }
  lines.emplace_back(
      "made from another config; resume with that one (noiseloom info shows it), or choose another output");
  std::vector<Fault> faults;
  for (const std::string& line : lines) faults.push_back({saved.path(), line});
  return faults;
}

std::vector<Fault> file_faults(const RunFileReader& saved, const RunConfig& config) {
  const auto digest = saved.content().state.find("inputs");
  if (!saved.content().inputs.empty() || digest == saved.content().state.end()) return {};
  std::vector<Fault> faults;
  for (const auto& [path, written] : config.written_paths) {
    if (posix_file_ops().exists(path)) continue;
    faults.push_back(
        {saved.path(), fmt::format("names \"{}\" and is from before a run file held what it was made from: "
                                   "there is no such file: {}",
                                   written, path)});
  }
  if (faults.empty() && digest->second != Attribute(inputs_digest(config))) {
    faults.push_back({saved.path(), "a file that the config names (samples or filter table) has changed since"});
  }
  return faults;
}

}  // namespace

std::vector<Fault> resume_faults(const RunFileReader& saved, const RunConfig& config) {
  std::vector<Fault> faults = file_faults(saved, config);
  for (Fault& fault : config_faults(saved, config)) faults.push_back(std::move(fault));
  return faults;
}

std::string why_not_extended(const OptimizerSpec& before, const OptimizerSpec& now) {
  const std::string why = reason(before, now);
  if (why.empty()) return "";
  return fmt::format(
      "optimizer.stop: {} = {} in the file, {} = {} here: {}; start it afresh (another output, or "
      "--overwrite)",
      rule_name(before.stop), value_of(before.stop), rule_name(now.stop), value_of(now.stop), why);
}

}  // namespace noiseloom
