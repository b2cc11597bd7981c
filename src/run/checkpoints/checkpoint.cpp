#include "noiseloom/run/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "noiseloom/config/stored_config.h"
#include "noiseloom/files/digest.h"
#include "run/checkpoints/checkpoint_parts.h"
#include "run/checkpoints/swap_state_checks.h"

namespace noiseloom {
namespace {

constexpr auto visit_swap_state = [](auto& state, const auto& visit) {
  visit("sweep", state.sweep);
  visit("step", state.step);
  visit("accepted", state.accepted);
  visit("candidates", state.candidates);
  visit("temperature", state.temperature);
  visit("elapsed_s", state.elapsed_s);
  visit("fraction", state.fraction);
  visit("mean_magnitude", state.mean_magnitude);
  visit("mean_distance", state.mean_distance);
  visit("round_score", state.round_score);
  visit("relative_error", state.relative_error);
  visit("iterations", state.iterations);
  visit("scored_iterations", state.scored_iterations);
  visit("scored_step", state.scored_step);
  visit("is_given", state.is_given);
  visit("begun_s", state.begun_s);
  visit("join", state.join);
  visit("is_cold", state.is_cold);
  visit("given_error", state.given_error);
  visit("given_kept", state.given_kept);
  visit("finished", state.finished);
};

constexpr auto visit_swap_row = [](auto&& row, const auto& visit) {
  visit("sweep", row.sweep);
  visit("iterations", row.iterations);
  visit("temperature", row.temperature);
  visit("acceptance", row.acceptance);
  visit("relative_error", row.relative_error);
  visit("seconds", row.seconds);
};

constexpr int most_channels = 8;

// Of a list of samples only the file knows: then those of /samples, if they can be.
int stored_channels(const RunFileContent& content, const RunConfig& config) {
  if (!config.problem.samples.is_file()) return num_channels(config.problem.samples);
  for (const SliceDataset& dataset : content.datasets) {
    if (dataset.name == samples_name && dataset.channels >= 1 && dataset.channels <= most_channels) {
      return dataset.channels;
    }
  }
  return 1;
}

std::vector<float> densities(const SampleSource& source, const std::vector<float>& samples) {
  const auto channels = static_cast<std::size_t>(source.channels());
  std::vector<float> pdf(samples.size() / channels);
  for (std::size_t cell = 0; cell < pdf.size(); ++cell) {
    pdf[cell] = static_cast<float>(source.pdf(samples.data() + cell * channels));
  }
  return pdf;
}

}  // namespace

std::vector<SliceDataset> datasets_for(int channels, bool has_pdf, bool has_given) {
  std::vector<SliceDataset> datasets = {{samples_name, ElementType::float32, channels, true},
                                        {permutation_name, ElementType::uint32, 1, false}};
  if (has_given) datasets.push_back({given_name, ElementType::uint32, 1, false});
  if (has_pdf) datasets.push_back({pdf_name, ElementType::float32, 1, false});
  return datasets;
}

std::string inputs_digest(const RunConfig& config) {
  if (config.written_paths.empty()) return "";
  Digest digest;
  std::vector<std::byte> bytes;
  for (const auto& [path, written] : config.written_paths) {
    const int fd = posix_file_ops().open(path);
    bytes.resize(posix_file_ops().size(fd));
    posix_file_ops().read(fd, 0, bytes);
    posix_file_ops().close(fd);
    digest.update(bytes);
  }
  return to_hex(digest.value());
}

std::vector<SliceDataset> run_datasets(const SampleSource& source, bool has_given) {
  return datasets_for(source.channels(), source.has_pdf(), has_given);
}

std::string save_run(FileOps& ops, const std::string& path, const RunConfig& config, const SampleSource& source,
                     SwapOptimizer& engine, const Communicator& communicator,
                     const std::map<std::string, Attribute>& provenance) {
  RunFileContent content =
      content_of(config, engine.method(), engine.state(), visit_swap_state, visit_swap_row, provenance);
  content.datasets = run_datasets(source, engine.has_given());
  const auto produce = [&](std::size_t dataset, SliceIndex slice, std::vector<std::byte>& block) {
    block.clear();
    const std::string& name = content.datasets[dataset].name;
    if (name == permutation_name) {
      append(block, engine.permutation(slice));
    } else if (name == given_name) {
      append(block, engine.given_permutation(slice));
    } else if (name == pdf_name) {
      append(block, densities(source, engine.samples(slice)));
    } else {
      append(block, engine.samples(slice));
    }
  };
  return publish_run(ops, path, content, engine.distribution(), communicator, produce);
}

namespace {

// What older run files do not say: those from before a run could begin with an arrangement, and those from before there
// were algorithm numbers, which have R in their history alone.
RunFileContent with_all_fields(RunFileContent content) {
  for (const char* name : {"is_given", "is_cold", "given_kept"}) content.state.emplace(name, std::int64_t{0});
  for (const char* name : {"begun_s", "join", "given_error"}) content.state.emplace(name, 0.0);
  if (content.state.contains("algorithm")) return content;
  const auto last_of = [&](const char* name) {
    for (const auto& [column, values] : content.history) {
      if (column == name && !values.empty()) return values.back();
    }
    return 0.0;
  };
  const double iterations = last_of("iterations");
  const bool counts = is_count(iterations, 0, 0x1p40);
  content.state.emplace("relative_error", last_of("relative_error"));
  content.state.emplace("iterations", counts ? static_cast<std::int64_t>(iterations) : 0);
  content.state.emplace("scored_iterations", counts ? static_cast<std::int64_t>(iterations) : 0);
  content.state.emplace("scored_step", std::int64_t{0});
  return content;
}

}  // namespace

SwapState engine_state(const RunFileContent& content, const std::string& path) {
  const RunConfig config = stored_config(content, path);
  SwapState state = state_of<SwapState>(with_all_fields(content), path, visit_swap_state, visit_swap_row);
  stored_algorithm(content, path);
  ContentFaults faults(path);
  faults.require(config.optimizer.method != Method::void_and_cluster, "has no /order, but its /config that method");
  faults.require(config.optimizer.method != Method::construct || !config.optimizer.stop.is_none(),
                 "has no /state of construction, but its /config that method and no stop rule");
  const bool has_pdf = std::any_of(content.datasets.begin(), content.datasets.end(),
                                   [](const SliceDataset& dataset) { return dataset.name == pdf_name; });
  check_datasets(content, datasets_for(stored_channels(content, config), has_pdf, state.is_given == 1), faults);
  check_swap_state(state, config, faults);
  faults.throw_if_any();
  return state;
}

void check_permutations(const RunFileReader& file) {
  const Extents& extents = file.content().extents;
  Permutation ids(static_cast<std::size_t>(extents.cells_per_slice()));
  ContentFaults faults(file.path());
  for (const char* name : {permutation_name, given_name}) {
    if (file.dataset(name) < 0) continue;
    for (const SliceIndex slice : extents.slices()) {
      if (faults.any()) break;
      file.read_slice(file.dataset(name), slice, std::as_writable_bytes(std::span(ids)));
      const std::string fault = permutation_fault(ids);
      faults.require(fault.empty(), fmt::format("{}, slice {}: {}", name, slice.value(), fault));
    }
  }
  faults.throw_if_any();
}

namespace {

// What only the engine of the config knows.
void check_against(const SwapOptimizer& engine, const SwapState& state, const StopSpec& stop, const std::string& path) {
  ContentFaults faults(path);
  faults.require(state.step < engine.num_classes(),
                 fmt::format("/state/@step = {}: a sweep has {} steps, from 0 on", state.step, engine.num_classes()));
  const std::int64_t each = engine.iterations_per_sweep(state.is_cold != 0);
  const auto iterations_at = [&](std::int64_t sweep) {
    return stop.iterations > 0 ? std::min(sweep * each, stop.iterations) : sweep * each;
  };
  if (stop.iterations > 0) {
    const bool over = iterations_at(state.sweep) >= stop.iterations;
    faults.require(over == (state.finished == ended::by_iterations) || state.finished == ended::nothing_to_swap,
                   fmt::format("/state/@sweep = {} of {} iterations, and the run is {}finished", state.sweep, each,
                               state.finished.empty() ? "not " : ""));
  }
  for (const HistoryRow& row : state.history) {
    const auto sweep = static_cast<std::int64_t>(row.sweep);
    const auto most = static_cast<double>(iterations_at(sweep));
    // A sweep that the clock cut short counts as one and made fewer iterations.
    const bool may_be_short = row.iterations > static_cast<double>(iterations_at(sweep - 1)) && row.iterations < most;
    faults.require(row.iterations == most || (sweep > 0 && may_be_short),
                   fmt::format("/history: {} iterations after {} sweeps, must be {}", row.iterations, sweep, most));
  }
  faults.throw_if_any();
}

// Whether the run is over under a stop rule that may be another than the one it came to its end by: what the schedule
// says of its last sweep.
void move_end(SwapState& state, const StopSpec& now, std::int64_t iterations_per_sweep) {
  if (state.finished.empty() || state.finished == ended::nothing_to_swap || now.time_s > 0) return;
  if (state.sweep == 0) {  // it began with what it was to reach
    if (state.relative_error > now.score) state.finished.clear();
    return;
  }
  const Schedule schedule(now, iterations_per_sweep);
  const Moment last = schedule.moment(state.sweep - 1, 0);
  double round_score = 0;  // R at the end of the round before
  for (const HistoryRow& row : state.history) {
    if (row.sweep <= static_cast<double>(state.sweep - last.round_length)) round_score = row.relative_error;
  }
  state.finished = schedule.ended_by(last, state.history.back().relative_error, round_score);
}

SwapState checked_state(const RunFileReader& file, const RunConfig& config, const SwapOptimizer& engine) {
  const RunFileContent& content = file.content();
  SwapState state = engine_state(content, file.path());
  const StopSpec stop = stored_config(content, file.path()).optimizer.stop;
  const bool goes_on_by_itself = state.finished.empty();
  if (goes_on_by_itself) require_same_algorithm(content, engine.method(), file.path());
  // Another algorithm may have made its visits of another length.
  const bool is_ours = stored_algorithm(content, file.path()) == algorithm_of(engine.method());
  if (is_ours) check_against(engine, state, stop, file.path());
  const StopSpec& now = config.optimizer.stop;
  const bool moved =
      stop.iterations != now.iterations || stop.score != now.score || stop.improvement != now.improvement;
  if (moved) {
    constexpr const char* afresh = "there is nothing to go on from; start it afresh (another output, or --overwrite)";
    if (state.given_kept != 0) {
      throw UserError(file.path(),
                      fmt::format("annealing did not improve the arrangement that it began with, so it was "
                                  "put back: {}",
                                  afresh));
    }
    if (state.is_given != 0 && state.sweep == 0 && !state.finished.empty()) {
      throw UserError(file.path(), fmt::format("it ended before annealing began: {}", afresh));
    }
    move_end(state, now, engine.iterations_per_sweep(state.is_cold != 0));
    // The last row was there because the run ended with it.
    const bool was_end = state.finished.empty() && state.history.size() > 1 &&
                         state.history.back().sweep == static_cast<double>(state.sweep);
    if (was_end && now.time_s <= 0 && !engine.row_is_planned_after(state.sweep, state.is_cold != 0))
      state.history.pop_back();
  }
  if (state.finished.empty()) require_same_algorithm(content, engine.method(), file.path());
  return state;
}

}  // namespace

void restore_run(const RunFileReader* file, const RunConfig& config, SwapOptimizer& engine,
                 const Communicator& communicator) {
  SwapState state;
  std::string path;
  communicator.on_root([&] {
    path = file->path();
    state = checked_state(*file, config, engine);
  });
  communicator.broadcast(path);
  broadcast_state(state, visit_swap_state, communicator);

  const Extents& extents = config.problem.extents;
  const std::size_t id_bytes = static_cast<std::size_t>(extents.cells_per_slice()) * sizeof(SampleId);
  std::vector<SliceIndex> wanted = engine.slices_held();
  std::sort(wanted.begin(), wanted.end());
  std::map<SliceIndex, Permutation> permutations;
  std::map<SliceIndex, Permutation> given;
  std::map<SliceIndex, std::vector<std::byte>> stored;
  ContentFaults faults(path);
  const std::size_t of_ids = (state.is_given != 0 ? 2 : 1) * id_bytes;
  const auto produce = [&](SliceIndex slice, std::vector<std::byte>& block) {
    const int samples = file->dataset(samples_name);
    const std::size_t size = bytes_per_slice(file->content().datasets[static_cast<std::size_t>(samples)], extents);
    block.resize(of_ids + size);
    const std::span all(block);
    file->read_slice(file->dataset(permutation_name), slice, all.first(id_bytes));
    if (state.is_given != 0) file->read_slice(file->dataset(given_name), slice, all.subspan(id_bytes, id_bytes));
    file->read_slice(samples, slice, all.last(size));
  };
  const auto take_ids = [&](const char* name, SliceIndex slice, std::span<const std::byte> bytes, Permutation& ids) {
    ids.resize(bytes.size() / sizeof(SampleId));
    std::memcpy(ids.data(), bytes.data(), bytes.size());
    const std::string fault = permutation_fault(ids);
    faults.require(fault.empty(), fmt::format("{}, slice {}: {}", name, slice.value(), fault));
  };
  const auto consume = [&](SliceIndex slice, std::span<const std::byte> block) {
    take_ids(permutation_name, slice, block.first(id_bytes), permutations[slice]);
    if (!engine.distribution().owns(slice)) return;
    if (state.is_given != 0) take_ids(given_name, slice, block.subspan(id_bytes, id_bytes), given[slice]);
    if (config.optimizer.strata > 1 && !faults.any()) {
      const Permutation& begun = given[slice];
      const Permutation& now = permutations[slice];
      const auto of_stratum =
          static_cast<std::uint32_t>(begun.size()) / static_cast<std::uint32_t>(config.optimizer.strata);
      const bool kept = std::equal(begun.begin(), begun.end(), now.begin(), now.end(), [&](SampleId a, SampleId b) {
        return a.value() / of_stratum == b.value() / of_stratum;
      });
      faults.require(kept, fmt::format("{}, slice {}: has left the strata over time that the run began with",
                                       permutation_name, slice.value()));
    }
    stored[slice].assign(block.begin() + static_cast<std::ptrdiff_t>(of_ids), block.end());
  };
  communicator.stream_from_root(wanted, produce, consume);
  communicator.together([&] { faults.throw_if_any(); });
  engine.restore(
      state, [&](SliceIndex slice) { return permutations.at(slice); },
      [&](SliceIndex slice) { return given.at(slice); });
  communicator.together([&] {
    for (const auto& [slice, expected] : stored) {
      const std::vector<float> found = engine.samples(slice);
      if (expected.size() != found.size() * sizeof(float) ||
          std::memcmp(expected.data(), found.data(), expected.size()) != 0) {
        throw UserError(path,
                        fmt::format("slice {}: the stored samples are not those that the config yields now; has a "
                                    "sample file changed, or the program's version?",
                                    slice.value()));
      }
    }
  });
}

}  // namespace noiseloom
