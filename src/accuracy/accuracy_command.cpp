#include "accuracy/accuracy_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "noiseloom/core/parallel.h"
#include "noiseloom/image/encoding.h"

namespace noiseloom {
namespace {

bool needs_no_quotes(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
         std::string_view("_-./=:,+@%").find(c) != std::string::npos;
}

Method other_method(Method method) { return method == Method::fast ? Method::anneal : Method::fast; }

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
    : options_(options), config_(config), threads_(options.threads > 0 ? options.threads : num_available_processors()) {
  replaces_table_ = !accepts({"optimizer.method=" + method_name(other_method(config.optimizer.method))});
}

bool PointCommands::accepts(const std::vector<std::string>& more) const {
  std::vector<std::string> all = options_.overrides;
  all.insert(all.end(), more.begin(), more.end());
  try {
    load_config(options_.config, all);
    return true;
  } catch (const UserError&) {
    return false;
  }
}

std::vector<std::string> PointCommands::overrides(const AccuracyPoint& point) const {
  const OptimizerSpec& optimizer = config_.optimizer;
  std::vector<std::string> changes;
  const std::string count = std::to_string(point.iterations);
  if (point.method != optimizer.method && replaces_table_) {
    changes.push_back(
        fmt::format("optimizer={{ method = \"{}\", stop = {{ iterations = {} }}, precision = \"{}\", cutoff = {} }}",
                    method_name(point.method), count, optimizer.precision == Precision::float64 ? "double" : "float",
                    shortest_number(optimizer.cutoff)));
    return changes;
  }
  if (point.method != optimizer.method) changes.push_back("optimizer.method=" + method_name(point.method));
  if (!point.is_default && point.iterations != optimizer.stop.iterations)
    changes.push_back("optimizer.stop.iterations=" + count);
  if (point.is_knob()) changes.push_back(fmt::format("optimizer.{}={}", point.setting, point.value));
  return changes;
}

void PointCommands::check(const AccuracyLadder& ladder) const {
  std::vector<std::string> all;
  const auto check_one = [&](const AccuracyPoint& point) {
    all = options_.overrides;
    const std::vector<std::string> changes = overrides(point);
    all.insert(all.end(), changes.begin(), changes.end());
    load_config(options_.config, all);
  };
  for (const AccuracyPoint& point : ladder.lines) check_one(point);
  for (const AccuracyKnob& knob : ladder.knobs) check_one({ladder.method, knob.setting, knob.value, 1, false});
}

PointCommand PointCommands::command(const AccuracyPoint& point) const {
  PointCommand command;
  command.output = (std::filesystem::path(options_.folder) / "runs" / (point_name(point) + ".h5")).string();
  command.words = {options_.program, "generate", options_.config};
  std::vector<std::string> all = options_.overrides;
  const std::vector<std::string> changes = overrides(point);
  all.insert(all.end(), changes.begin(), changes.end());
  for (const std::string& change : all) command.words.insert(command.words.end(), {"--set", change});
  if (options_.threads > 0) command.words.insert(command.words.end(), {"--threads", std::to_string(options_.threads)});
  command.words.insert(command.words.end(), {"-o", command.output, "--progress", "none"});
  command.shown = "noiseloom";
  for (std::size_t i = 1; i < command.words.size(); ++i) command.shown.append(" ").append(shell_word(command.words[i]));
  return command;
}

}  // namespace noiseloom
