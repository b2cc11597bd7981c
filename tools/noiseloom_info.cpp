// info: what a run file holds and how far it got.

#include <fmt/format.h>
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <optional>
#include <thread>

#include "noiseloom/config/stored_config.h"
#include "noiseloom/core/console.h"
#include "noiseloom/core/json.h"
#include "noiseloom/core/standard_streams.h"
#include "noiseloom/files/file_ops.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/run_lock.h"
#include "noiseloom/run/checkpoint.h"
#include "noiseloom/run/construct_checkpoint.h"
#include "noiseloom/run/order_checkpoint.h"
#include "noiseloom_commands.h"
#include "noiseloom_options.h"

namespace noiseloom {
namespace {

std::string text_of(const Attribute& value) {
  return std::visit(
      [](const auto& held) {
        if constexpr (std::is_same_v<std::decay_t<decltype(held)>, std::string>)
          return held;
        else
          return fmt::format("{}", held);
      },
      value);
}

std::string json_of(const Attribute& value) {
  if (const auto* number = std::get_if<double>(&value)) return json_number(*number);
  return std::holds_alternative<std::string>(value) ? json_string(std::get<std::string>(value)) : text_of(value);
}

// null where there is no number: the first row of a run has no acceptance yet.
std::string json_list(const std::vector<double>& values) {
  std::string list;
  for (const double value : values) list += (list.empty() ? "" : ", ") + json_number(value);
  return "[" + list + "]";
}

std::string json_object(const std::map<std::string, Attribute>& attributes) {
  std::string out;
  for (const auto& [name, value] : attributes) {
    out += fmt::format("{}{}: {}", out.empty() ? "" : ", ", json_string(name), json_of(value));
  }
  return "{" + out + "}";
}

void print_json(const RunFileContent& content) {
  std::string sizes;
  for (int axis = 0; axis < content.extents.num_axes(); ++axis) {
    sizes += fmt::format("{}{}: {}", axis == 0 ? "" : ", ", json_string(content.extents.name(axis)),
                         content.extents.size(axis));
  }
  std::string history;
  for (const auto& [column, values] : content.history) {
    history += fmt::format("{}{}: {}", history.empty() ? "" : ", ", json_string(column), json_list(values));
  }
  std::string checksums;
  for (const auto& [dataset, digest] : content.checksums) {
    checksums += fmt::format("{}{}: {}", checksums.empty() ? "" : ", ", json_string(dataset), json_string(digest));
  }
  fmt::print(
      "{{\"size\": {{{}}}, \"state\": {}, \"checksums\": {{{}}}, \"history\": {{{}}}, \"provenance\": {}, \"config\": "
      "{}}}\n",
      sizes, json_object(content.state), checksums, history, json_object(content.provenance),
      json_string(content.config));
}

void print_history(const SwapState& state) {
  fmt::print("\n   iter.  temperature  accepted        R    seconds\n");
  const std::size_t rows = state.history.size();
  for (std::size_t row = 0; row < rows; ++row) {
    // A dozen rows say it; --json has all.
    if (rows > 14 && row % (rows / 12) != 0 && row + 1 != rows) continue;
    const HistoryRow& entry = state.history[row];
    fmt::print("{:8}  {:11.4g}  {:7.2f} %  {:.5f}  {:9.1f}\n", entry.iterations, entry.temperature,
               100 * entry.acceptance, entry.relative_error, entry.seconds);
  }
}

// " of 600" where the run ends after so many iterations.
std::string iterations_in_all(const StopSpec& stop) {
  return stop.iterations > 0 ? fmt::format(" of {}", stop.iterations) : "";
}

// What else a run that is not finished goes on to.
std::string goal_of_score(const StopSpec& stop) { return stop.score > 0 ? fmt::format(" of {:g}", stop.score) : ""; }

void print_progress(const SwapState& state, const StopSpec& stop) {
  const std::string at = state.score_is_current() ? "" : fmt::format(" at iteration {}", state.scored_iterations);
  if (state.finished.empty()) {
    fmt::print("not finished: iteration {}{}, R {:.5f}{}{} (white noise 1); go on with generate --resume\n",
               state.iterations, iterations_in_all(stop), state.relative_error, at, goal_of_score(stop));
  } else {
    fmt::print("finished after {} iterations by {}\n", state.iterations, ended_text(state.finished));
    fmt::print("R {:.5f} (white noise 1)\n", state.relative_error);
  }
}

void print_progress(const OrderState& state, std::int64_t num_pixels) {
  if (state.finished.empty()) {
    fmt::print("not finished: stopped in phase {}; go on with generate --resume\n", state.phase);
  } else {
    fmt::print("finished: every pixel has its place in the order\n");
  }
  fmt::print("{} start points, {} swaps, {} of {} pixels placed ({:.1f} %)\n", state.start_points, state.swaps,
             state.placed, num_pixels, 100 * static_cast<double>(state.placed) / static_cast<double>(num_pixels));
}

void print_history(const OrderState& state) {
  fmt::print("\n  phase        swaps         placed    seconds\n");
  for (const OrderRow& row : state.history) {
    fmt::print("  {:<6} {:11} {:14}  {:9.1f}\n", vac_phase_name(static_cast<VacPhase>(row.phase)), row.swaps,
               row.placed, row.seconds);
  }
}

void print_progress(const ConstructState& state, std::int64_t num_pixels) {
  if (state.finished.empty()) {
    fmt::print("not finished: stopped in phase {}; go on with generate --resume\n", state.phase);
  } else {
    fmt::print("finished: every pixel has its place\n");
    fmt::print("R {:.5f} (white noise 1)\n", state.relative_error);
  }
  fmt::print("sharpness {:g}, {} start points in every slice, {} swaps, {} of {} pixels placed ({:.1f} %)\n",
             state.sharpness, state.start_points, state.swaps, state.ranked, num_pixels,
             100 * static_cast<double>(state.ranked) / static_cast<double>(num_pixels));
}

void print_history(const ConstructState& state) {
  fmt::print("\n  phase        swaps         placed    seconds\n");
  for (const ConstructRow& row : state.history) {
    fmt::print("  {:<6} {:11} {:14}  {:9.1f}\n", construct_phase_name(static_cast<ConstructPhase>(row.phase)),
               row.swaps, row.ranked, row.seconds);
  }
}

// What the file says of its run, all of it checked. One of the three.
struct Checked {
  std::optional<OrderState> order;
  std::optional<SwapState> engine;
  std::optional<ConstructState> construct;
};

Checked check(const RunFileReader& reader) {
  Checked checked;
  if (is_order_run(reader.content())) {
    checked.order = order_state(reader.content(), reader.path());
    check_order(reader, *checked.order);
  } else if (is_construct_run(reader.content())) {
    checked.construct = construct_state(reader.content(), reader.path());
    check_places(reader, *checked.construct);
  } else {
    checked.engine = engine_state(reader.content(), reader.path());
    check_permutations(reader);
  }
  return checked;
}

void print_state(const RunFileContent& content, const std::string& path, const Checked& checked) {
  if (checked.order) print_progress(*checked.order, content.extents.num_cells());
  if (checked.engine) print_progress(*checked.engine, stored_config(content, path).optimizer.stop);
  if (checked.construct) print_progress(*checked.construct, content.extents.num_cells());
}

void print_text(const std::string& path, const RunFileContent& content, const Checked& checked) {
  const auto& [order, engine, construct] = checked;
  fmt::print("{}: {}", path, content.extents.to_string());
  for (int axis = 0; axis < content.extents.num_axes(); ++axis)
    fmt::print("{}{}", axis == 0 ? " (" : ", ", content.extents.name(axis));
  fmt::print(")\n");
  print_state(content, path, checked);
  if (const std::string previous = previous_generation(path); std::filesystem::exists(previous)) {
    fmt::print("  {}: the generation before it\n", previous);
  }
  for (const auto& dataset : content.datasets) {
    fmt::print("  {:20} {}  checksum {}\n", dataset.name,
               dataset.type == ElementType::float32  ? "float32"
               : dataset.type == ElementType::uint32 ? "uint32"
                                                     : "uint64",
               content.checksums.at(dataset.name));
  }
  for (const RunFileInput& input : content.inputs) fmt::print("  /inputs/{}  of {}\n", input.key, input.file);
  fmt::print("  algorithm {}\n", stored_algorithm(content, path));
  if (order) print_history(*order);
  if (engine) print_history(*engine);
  if (construct) print_history(*construct);
  fmt::print("\nprovenance\n");
  for (const auto& [name, value] : content.provenance) fmt::print("  {:14} {}\n", name, text_of(value));
  fmt::print("\nconfig\n{}", content.config);
}

// What tells a file from another one that has taken its place; "" where there is none.
std::string generation_at(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return "";
  return fmt::format("{} {}.{:09}", status.st_ino, status.st_mtim.tv_sec, status.st_mtim.tv_nsec);
}

// Says how far a run has come, whenever it is saved, until it is finished or nobody works on it any more.
int follow_run(const std::string& path, const ResultOptions& result) {
  constexpr std::chrono::milliseconds pause{300};
  LockWatch lock(path);
  std::string seen;
  for (;;) {
    const bool is_worked_on = lock.is_held();  // asked first: it ends last
    const std::string now = generation_at(path);
    // Where a save takes two renames there is no file between them.
    if (now.empty() ? !is_worked_on : now != seen) {
      const RunFileReader reader = open_to_look_at(path);
      const RunFileContent& content = reader.content();
      const Checked checked = check(reader);
      if (result.json) {
        fmt::print("{{\"saved_at\": {}, \"state\": {}}}\n", json_of(content.provenance.at("saved_at")),
                   json_object(content.state));
      } else if (!result.quiet) {
        fmt::print("{}  ", text_of(content.provenance.at("saved_at")));
        print_state(content, path, checked);
      }
      flush_standard_output();
      const auto finished = content.state.find("finished");
      if (finished != content.state.end() && !text_of(finished->second).empty()) return exit_done;
      seen = now;
    } else if (!is_worked_on) {
      print_error(fmt::format("{}: nobody works on it; go on with generate --resume\n", path));
      return exit_stopped;
    }
    std::this_thread::sleep_for(pause);
  }
}

}  // namespace

int run_info(int argc, char** argv) {
  CLI::App app("Checks a run file and says what it holds: size, state, checksums, score history, provenance, config.");
  app.name("noiseloom info");
  std::string path;
  ResultOptions result;
  bool follow = false;
  app.add_option("RUN", path, "run file")->required();
  app.add_flag("--follow", follow,
               "say how far the run is whenever it is saved, until it is finished (exit 0) or nobody works on it (75); "
               "with --json an object a line");
  add_result_options(app, result, ShowsProgress::no, "everything, the whole history too");
  if (const auto status = read_options(app, argc - 1, argv + 1)) return *status;
  if (follow) return follow_run(path, result);
  const RunFileReader reader = open_to_look_at(path);
  if (!reader.change().empty()) print_error(fmt::format("WARNING: {}: {}\n", path, reader.change()));
  const Checked checked = check(reader);
  if (result.quiet) return exit_done;  // checked, and that was all
  if (result.json) {
    print_json(reader.content());
  } else {
    print_text(path, reader.content(), checked);
  }
  return exit_done;
}

}  // namespace noiseloom
