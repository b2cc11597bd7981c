#include "noiseloom/run/construct_checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "noiseloom/config/stored_config.h"
#include "noiseloom/core/decimal.h"
#include "noiseloom/run/checkpoint.h"
#include "run/checkpoints/checkpoint_parts.h"

namespace noiseloom {
namespace {

constexpr const char* construct_phase_names[] = {"spread", "relax", "drain", "fill", "exchange", "done"};
constexpr const char* finished_word = "construction";
constexpr int rows_of_places = 16;

constexpr auto visit_construct_state = [](auto& state, const auto& visit) {
  visit("phase", state.phase);
  visit("start_points", state.start_points);
  visit("rounds", state.rounds);
  visit("swaps", state.swaps);
  visit("ranked", state.ranked);
  visit("sharpness", state.sharpness);
  visit("mean_distance", state.mean_distance);
  visit("relative_error", state.relative_error);
  visit("finished", state.finished);
};

constexpr auto visit_construct_row = [](auto&& row, const auto& visit) {
  visit("phase", row.phase);
  visit("swaps", row.swaps);
  visit("ranked", row.ranked);
  visit("seconds", row.seconds);
};

// More than any run makes, and still whole as a double.
constexpr std::int64_t most_counted = std::int64_t{1} << 53;

ConstructPhase phase_of(const ConstructState& state, const std::string& path) {
  const auto found = std::find(std::begin(construct_phase_names), std::end(construct_phase_names), state.phase);
  if (found == std::end(construct_phase_names)) {
    throw UserError(path, fmt::format("/state: phase \"{}\" is none of construction", state.phase));
  }
  return static_cast<ConstructPhase>(found - std::begin(construct_phase_names));
}

ConstructProgress progress_of(const ConstructState& state, const Extents& extents, const std::string& path) {
  return {.phase = phase_of(state, path),
          .num_start_points = state.start_points,
          .num_placed = state.ranked / extents.num_slices(),
          .rounds = state.rounds,
          .num_swaps = state.swaps};
}

void check_counts(const ConstructState& state, const RunConfig& config, const std::string& path) {
  const Extents& extents = config.problem.extents;
  const std::int64_t cells = extents.cells_per_slice();
  const ConstructProgress progress = progress_of(state, extents, path);
  const std::int64_t placed = progress.num_placed;
  ContentFaults faults(path);
  const auto require = [&](bool sound, const char* name, const auto& value, const std::string& must) {
    faults.require(sound, fmt::format("/state/@{} = {}: {}", name, value, must));
  };
  const bool circular = scale_of(config.problem.samples, 1) == SampleScale::circle;
  const std::int64_t points = circular ? cells / 2 : decimal_of(config.construct.density).floor_of_times(cells);
  const bool of_circle = progress.phase == ConstructPhase::spread || progress.phase == ConstructPhase::exchange;
  const bool of_line = progress.phase == ConstructPhase::drain || progress.phase == ConstructPhase::fill;
  require(circular ? !of_line : !of_circle, "phase", fmt::format("\"{}\"", state.phase),
          fmt::format("samples \"{}\" have no such phase", config.problem.samples.space));
  require(state.start_points == points, "start_points", state.start_points,
          fmt::format("the config asks for {}", points));
  require(state.ranked >= 0 && state.ranked % extents.num_slices() == 0 && placed <= cells, "ranked", state.ranked,
          "must be as many pixels of every slice");
  require(state.rounds >= 0 && state.rounds <= most_counted, "rounds", state.rounds, "must be a number of rounds");
  require(state.swaps >= 0 && state.swaps <= most_counted, "swaps", state.swaps, "must be a number of swaps");
  bool fits = true;
  switch (progress.phase) {
    case ConstructPhase::spread:
    case ConstructPhase::relax:
      fits = placed == 0;
      break;
    case ConstructPhase::exchange:
      fits = placed % 2 == 0;
      break;
    case ConstructPhase::drain:
      fits = placed <= points;
      break;
    case ConstructPhase::fill:
      fits = placed >= points;
      break;
    case ConstructPhase::done:
      fits = placed == cells;
      break;
  }
  require(fits, "ranked", state.ranked, fmt::format("no run has this in phase {}", state.phase));
  require(state.finished == (progress.phase == ConstructPhase::done ? finished_word : ""), "finished",
          fmt::format("\"{}\"", state.finished), fmt::format("does not go with phase {}", state.phase));
  require(state.sharpness > 0 && state.sharpness <= 8, "sharpness", state.sharpness, "must be above 0 and at most 8");
  require(config.construct.sharpness == 0 || config.construct.sharpness == state.sharpness, "sharpness",
          state.sharpness, fmt::format("the config asks for {}", config.construct.sharpness));
  require(is_finite_positive_or_zero(state.mean_distance), "mean_distance", state.mean_distance,
          "must be a finite number from 0 on");
  require(std::isfinite(state.relative_error), "relative_error", state.relative_error, "must be finite");
  faults.throw_if_any();
}

void check_rows(const ConstructState& state, const std::string& path) {
  ContentFaults faults(path);
  ConstructRow least;
  for (std::size_t index = 0; index < state.history.size(); ++index) {
    const ConstructRow& row = state.history[index];
    const auto require = [&](bool sound, const char* column, double value, const char* must) {
      faults.require(sound, fmt::format("/history/{}, row {} = {}: {}", column, index, value, must));
    };
    require(is_count(row.phase, least.phase, static_cast<double>(phase_of(state, path))), "phase", row.phase,
            "must be a phase of construction, each row the same or a later one, up to that of /state");
    require(is_count(row.swaps, least.swaps, static_cast<double>(state.swaps)), "swaps", row.swaps,
            "must count the swaps, never falling, up to those of /state");
    require(is_count(row.ranked, least.ranked, static_cast<double>(state.ranked)), "ranked", row.ranked,
            "must count the pixels with a place, never falling, up to those of /state");
    require(is_finite_positive_or_zero(row.seconds), "seconds", row.seconds, "must be a finite number from 0 on");
    least = row;
  }
  faults.throw_if_any();
}

std::string places_fault(const ConstructProgress& progress, SliceIndex slice, std::span<const std::uint32_t> places) {
  if (is_sound(progress, places)) return "";
  return fmt::format("{}, slice {}: its places are not those of phase {} with {} pixels placed", permutation_name,
                     slice.value(), construct_phase_names[static_cast<std::size_t>(progress.phase)],
                     progress.num_placed);
}

}  // namespace

const char* construct_phase_name(ConstructPhase phase) {
  return construct_phase_names[static_cast<std::size_t>(phase)];
}

bool is_construct_run(const RunFileContent& content) { return content.state.contains("sharpness"); }

ConstructState construct_state_of(const ConstructProgress& progress, std::int32_t num_slices, double sharpness,
                                  std::vector<ConstructRow> history) {
  return {.phase = construct_phase_name(progress.phase),
          .start_points = progress.num_start_points,
          .rounds = progress.rounds,
          .swaps = progress.num_swaps,
          .ranked = progress.num_placed * num_slices,
          .sharpness = sharpness,
          .finished = progress.phase == ConstructPhase::done ? finished_word : "",
          .history = std::move(history)};
}

void add_construct_rows(const ConstructProgress& before, const ConstructProgress& after, const Extents& extents,
                        double seconds, std::vector<ConstructRow>& history) {
  const auto add = [&](ConstructPhase phase, std::int64_t placed) {
    history.push_back({static_cast<double>(phase), static_cast<double>(after.num_swaps),
                       static_cast<double>(placed * extents.num_slices()), seconds});
  };
  const auto is_on_circle = [](ConstructPhase phase) {
    return phase == ConstructPhase::spread || phase == ConstructPhase::exchange;
  };
  const bool circular = is_on_circle(before.phase) || is_on_circle(after.phase);
  const ConstructPhase last = circular ? ConstructPhase::exchange : ConstructPhase::fill;
  const std::int64_t drained = circular ? 0 : after.num_start_points;
  const auto ended = [&](ConstructPhase phase) { return before.phase <= phase && after.phase > phase; };
  if (ended(ConstructPhase::spread)) add(ConstructPhase::relax, 0);
  if (ended(ConstructPhase::relax)) add(circular ? ConstructPhase::exchange : ConstructPhase::drain, 0);
  if (!circular && ended(ConstructPhase::drain)) add(ConstructPhase::fill, after.num_start_points);
  const std::int64_t cells = extents.cells_per_slice();
  for (int part = 1; part < rows_of_places; ++part) {
    const auto placed = static_cast<std::int64_t>(static_cast<__int128>(cells) * part / rows_of_places);
    const bool passed =
        placed > drained && after.num_placed >= placed && (before.phase < last || before.num_placed < placed);
    if (passed && after.phase >= last) add(last, placed);
  }
  if (ended(last)) add(ConstructPhase::done, cells);
}

ConstructState construct_state(const RunFileContent& content, const std::string& path) {
  const RunConfig config = stored_config(content, path);
  ConstructState state = state_of<ConstructState>(content, path, visit_construct_state, visit_construct_row);
  stored_algorithm(content, path);
  ContentFaults faults(path);
  faults.require(config.optimizer.method == Method::construct,
                 "has a /state of construction, but its /config another "
                 "method");
  const bool has_pdf = std::any_of(content.datasets.begin(), content.datasets.end(),
                                   [](const SliceDataset& dataset) { return dataset.name == pdf_name; });
  check_datasets(content, datasets_for(num_channels(config.problem.samples), has_pdf), faults);
  faults.throw_if_any();
  check_counts(state, config, path);
  check_rows(state, path);
  return state;
}

void check_places(const RunFileReader& file, const ConstructState& state) {
  const Extents& extents = file.content().extents;
  const ConstructProgress progress = progress_of(state, extents, file.path());
  std::vector<std::uint32_t> places(static_cast<std::size_t>(extents.cells_per_slice()));
  ContentFaults faults(file.path());
  for (const SliceIndex slice : extents.slices()) {
    if (faults.any()) break;
    file.read_slice(file.dataset(permutation_name), slice, std::as_writable_bytes(std::span(places)));
    const std::string fault = places_fault(progress, slice, places);
    faults.require(fault.empty(), fault);
  }
  faults.throw_if_any();
}

std::vector<float> samples_of_places(const std::vector<std::uint32_t>& places, const std::vector<float>& list,
                                     int channels) {
  const auto step = static_cast<std::size_t>(channels);
  std::vector<float> samples(places.size() * step, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t cell = 0; cell < places.size(); ++cell) {
    if (places[cell] >= list.size() / step) continue;
    std::copy_n(list.begin() + static_cast<std::ptrdiff_t>(places[cell] * step), step,
                samples.begin() + static_cast<std::ptrdiff_t>(cell * step));
  }
  return samples;
}

std::string save_construct_run(FileOps& ops, const std::string& path, const RunConfig& config,
                               const SampleSource& source, const SliceConstruction& run, const ConstructState& state,
                               const Communicator& communicator, const std::map<std::string, Attribute>& provenance) {
  RunFileContent content =
      content_of(config, Method::construct, state, visit_construct_state, visit_construct_row, provenance);
  content.datasets = run_datasets(source);
  const auto produce = [&](std::size_t dataset, SliceIndex slice, std::vector<std::byte>& block) {
    block.clear();
    const std::string& name = content.datasets[dataset].name;
    const std::vector<std::uint32_t>& places = run.places(slice);
    if (name == permutation_name) return append(block, places);
    const auto step = static_cast<std::size_t>(source.channels());
    std::vector<float> values = samples_of_places(places, source.list(slice), source.channels());
    if (name == pdf_name) {
      for (std::size_t cell = 0; cell < places.size(); ++cell) {
        const float* const sample = &values[cell * step];
        values[cell] = std::isnan(*sample) ? *sample : static_cast<float>(source.pdf(sample));
      }
      values.resize(places.size());
    }
    append(block, values);
  };
  return publish_run(ops, path, content, run.distribution(), communicator, produce);
}

ConstructState restore_construct_run(const RunFileReader* file, const RunConfig& config, const SampleSource& source,
                                     SliceConstruction& run, const Communicator& communicator) {
  const Extents& extents = config.problem.extents;
  ConstructState state;
  std::string path;
  communicator.on_root([&] {
    path = file->path();
    state = construct_state(file->content(), path);
    if (state.finished.empty()) require_same_algorithm(file->content(), Method::construct, path);
  });
  communicator.broadcast(path);
  broadcast_state(state, visit_construct_state, communicator);
  const ConstructProgress progress = progress_of(state, extents, path);

  const std::size_t bytes = static_cast<std::size_t>(extents.cells_per_slice()) * sizeof(std::uint32_t);
  const std::size_t sample_bytes = bytes * static_cast<std::size_t>(source.channels());
  std::vector<SliceIndex> wanted = run.slices_held();
  std::sort(wanted.begin(), wanted.end());
  std::map<SliceIndex, std::vector<std::uint32_t>> held;
  ContentFaults faults(path);
  const auto produce = [&](SliceIndex slice, std::vector<std::byte>& block) {
    block.resize(bytes + sample_bytes);
    file->read_slice(file->dataset(permutation_name), slice, std::span(block).first(bytes));
    file->read_slice(file->dataset(samples_name), slice, std::span(block).last(sample_bytes));
  };
  const auto consume = [&](SliceIndex slice, std::span<const std::byte> block) {
    std::vector<std::uint32_t>& places = held[slice];
    places.resize(bytes / sizeof(std::uint32_t));
    std::memcpy(places.data(), block.data(), bytes);
    const std::string fault = places_fault(progress, slice, places);
    faults.require(fault.empty(), fault);
    if (!fault.empty() || !run.distribution().owns(slice)) return;
    std::vector<float> stored(sample_bytes / sizeof(float));
    std::memcpy(stored.data(), block.data() + bytes, sample_bytes);
    const std::vector<float> expected = samples_of_places(places, source.list(slice), source.channels());
    const bool same = std::equal(stored.begin(), stored.end(), expected.begin(), expected.end(), [](float a, float b) {
      return (std::isnan(a) && std::isnan(b)) || std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
    });
    faults.require(same, fmt::format("slice {}: the stored samples are not those that the config yields now; has a "
                                     "sample file changed, or the program's version?",
                                     slice.value()));
  };
  communicator.stream_from_root(wanted, produce, consume);
  communicator.together([&] { faults.throw_if_any(); });
  run.restore(progress, [&](SliceIndex slice) { return std::move(held.at(slice)); });
  return state;
}

}  // namespace noiseloom
