#include "accuracy/accuracy_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>
#include <map>

#include "noiseloom/core/parallel.h"
#include "noiseloom/image/encoding.h"

namespace noiseloom {
namespace {

bool needs_no_quotes(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
         std::string_view("_-./=:,+@%").find(c) != std::string::npos;
}

constexpr std::uint64_t largest_seed = std::numeric_limits<std::int64_t>::max();  // that TOML holds

}  // namespace

std::string shell_word(const std::string& word) {
  if (!word.empty() && std::all_of(word.begin(), word.end(), needs_no_quotes)) return word;
  std::string quoted = "'";
  for (const char c : word) {
    if (c == '\'') quoted += "'\\'";  // out of the quotes, a quote, and in again with the one that follows
    quoted += c;
  }
  quoted += '\'';
  return quoted;
}

PointCommands::PointCommands(const AccuracyOptions& options, const RunConfig& config)
    : options_(options),
      config_(config),
      threads_(options.threads > 0 ? options.threads : num_available_processors()) {}

std::vector<Fault> PointCommands::faults_with(const std::vector<std::string>& more) const {
  std::vector<std::string> all = options_.overrides;
  all.insert(all.end(), more.begin(), more.end());
  try {
    load_config(options_.config, all);
  } catch (const UserError& error) {
    return error.faults();
  }
  return {};
}

// Every point but the default names its method, which a config need not. Where the config has keys that another method
// has not, the table [optimizer] is replaced.
std::vector<std::string> PointCommands::overrides(const AccuracyPoint& point) const {
  if (point.is_default) return {};
  const OptimizerSpec& optimizer = config_.optimizer;
  const std::string method = "optimizer.method=" + method_name(point.method);
  const std::string count = std::to_string(point.iterations);
  if (point.method != optimizer.method) {
    if (point.iterations == 0) return {fmt::format("optimizer={{ method = \"{}\" }}", method_name(point.method))};
    if (point.method == Method::construct)
      return {fmt::format("optimizer={{ method = \"construct\", stop = {{ iterations = {} }} }}", count)};
    if (!has_iterations(optimizer.method) || !faults_with({method}).empty())
      return {fmt::format("optimizer={{ method = \"{}\", stop = {{ iterations = {} }}, precision = \"{}\"{} }}",
                          method_name(point.method), count,
                          optimizer.precision == Precision::float64 ? "double" : "float",
                          optimizer.cutoff < 0 ? "" : ", cutoff = " + shortest_number(optimizer.cutoff))};
  }
  if (point.iterations == 0) {  // construction alone, of a config that anneals what it constructs
    const std::string sharpness =
        config_.construct.sharpness > 0 ? ", sharpness = " + shortest_number(config_.construct.sharpness) : "";
    return {fmt::format("optimizer={{ method = \"construct\", density = {}{} }}",
                        shortest_number(config_.construct.density), sharpness)};
  }
  std::vector<std::string> changes{method};
  if (point.iterations != optimizer.stop.iterations) changes.push_back("optimizer.stop.iterations=" + count);
  if (point.is_knob()) changes.push_back(fmt::format("optimizer.{}={}", point.setting, point.value));
  return changes;
}

void PointCommands::check(AccuracyLadder& ladder) const {
  std::vector<AccuracyPoint> points = ladder.lines;
  for (const AccuracyKnob& knob : ladder.knobs) points.push_back({ladder.method, knob.setting, knob.value, 1, false});
  std::map<Method, std::string> impossible;
  std::vector<Fault> faults;
  for (const AccuracyPoint& point : points) {
    const std::vector<Fault> found = faults_with(overrides(point));
    if (found.empty()) continue;
    if (point.method != ladder.method) {
      impossible[point.method] = "cannot be asked of this config: " + found.front().text;
    } else {
      faults.insert(faults.end(), found.begin(), found.end());
    }
  }
  throw_if_any(std::move(faults));
  for (const auto& [method, reason] : impossible) leave_out(ladder, method, reason);
}

PointCommand PointCommands::command(const AccuracyPoint& point, int run) const {
  const std::uint64_t seed = (config_.problem.seed + static_cast<std::uint64_t>(run)) & largest_seed;
  PointCommand command;
  const std::string name = point_name(point) + (run > 0 ? fmt::format("-seed-{}", seed) : "") + ".h5";
  command.output = (std::filesystem::path(options_.folder) / "runs" / name).string();
  command.words = {options_.program, "generate", options_.config};
  std::vector<std::string> all = options_.overrides;
  const std::vector<std::string> changes = overrides(point);
  all.insert(all.end(), changes.begin(), changes.end());
  if (run > 0) all.push_back(fmt::format("texture.seed={}", seed));
  for (const std::string& change : all) command.words.insert(command.words.end(), {"--set", change});
  if (options_.threads > 0) command.words.insert(command.words.end(), {"--threads", std::to_string(options_.threads)});
  command.words.insert(command.words.end(), {"-o", command.output, "--progress", "none"});
  command.shown = "noiseloom";
  for (std::size_t i = 1; i < command.words.size(); ++i) command.shown.append(" ").append(shell_word(command.words[i]));
  return command;
}

}  // namespace noiseloom
