#include "noiseloom/run/order_checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "noiseloom/config/stored_config.h"
#include "noiseloom/construct/order_samples.h"
#include "noiseloom/run/checkpoint.h"
#include "noiseloom/samples/sample_space.h"
#include "run/checkpoints/checkpoint_parts.h"

namespace noiseloom {
namespace {

constexpr const char* order_phase_names[] = {"swap", "drain", "fill", "done"};

constexpr auto visit_order_state = [](auto& state, const auto& visit) {
  visit("phase", state.phase);
  visit("start_points", state.start_points);
  visit("swaps", state.swaps);
  visit("ranked", state.placed);
  visit("finished", state.finished);
};

constexpr auto visit_order_row = [](auto&& row, const auto& visit) {
  visit("phase", row.phase);
  visit("swaps", row.swaps);
  visit("ranked", row.placed);
  visit("seconds", row.seconds);
};

OrderCensus expected_census(const OrderState& state, std::int64_t num_pixels) {
  const auto census = [&](std::int64_t begin, std::int64_t end, std::int64_t num_on) {
    return OrderCensus::of_places(num_pixels, begin, end, num_on);
  };
  const std::int64_t points = state.start_points;
  if (state.phase == order_phase_names[0]) return census(0, 0, points);
  if (state.phase != order_phase_names[1]) return census(0, state.placed, 0);
  return census(points - state.placed, points, points - state.placed);
}

VacPhase phase_of(const OrderState& state, const std::string& path) {
  const auto found = std::find(std::begin(order_phase_names), std::end(order_phase_names), state.phase);
  if (found == std::end(order_phase_names)) {
    throw UserError(path, fmt::format("/state: phase \"{}\" is none of void and cluster", state.phase));
  }
  return static_cast<VacPhase>(found - std::begin(order_phase_names));
}

// More swaps than a double of /history can count no run makes.
constexpr std::int64_t most_swaps = std::int64_t{1} << 53;

void check_counts(const OrderState& state, std::int64_t num_pixels, const std::string& path) {
  const VacPhase phase = phase_of(state, path);
  const std::int64_t points = state.start_points;
  bool sound = points >= 0 && points <= num_pixels && state.swaps >= 0 && state.swaps <= most_swaps;
  switch (phase) {
    case VacPhase::swap:
      sound = sound && state.placed == 0;
      break;
    case VacPhase::drain:
      sound = sound && state.placed >= 0 && state.placed <= points;
      break;
    case VacPhase::fill:
      sound = sound && state.placed >= points && state.placed <= num_pixels;
      break;
    case VacPhase::done:
      sound = sound && state.placed == num_pixels;
      break;
  }
  if (!sound || state.finished != (phase == VacPhase::done ? "order" : "")) {
    throw UserError(path,
                    fmt::format("/state: phase {}, {} start points, {} swaps, {} of {} pixels with a place, finished "
                                "\"{}\": no run has this",
                                state.phase, points, state.swaps, state.placed, num_pixels, state.finished));
  }
}

void check_rows(const OrderState& state, const std::string& path) {
  ContentFaults faults(path);
  OrderRow least;
  for (std::size_t index = 0; index < state.history.size(); ++index) {
    const OrderRow& row = state.history[index];
    const auto require = [&](bool sound, const char* column, double value, const char* must) {
      faults.require(sound, fmt::format("/history/{}, row {} = {}: {}", column, index, value, must));
    };
    require(is_count(row.phase, least.phase, static_cast<double>(phase_of(state, path))), "phase", row.phase,
            "must be a phase of void and cluster, each row the same or a later one, up to that of /state");
    require(is_count(row.swaps, least.swaps, static_cast<double>(state.swaps)), "swaps", row.swaps,
            "must count the swaps, never falling, up to those of /state");
    require(is_count(row.placed, least.placed, static_cast<double>(state.placed)), "ranked", row.placed,
            "must count the pixels with a place, never falling, up to those of /state");
    require(is_finite_positive_or_zero(row.seconds), "seconds", row.seconds, "must be a finite number from 0 on");
    least = row;
  }
  faults.throw_if_any();
}

void check_census(const OrderCensus& census, const OrderState& state, const std::string& path) {
  const OrderCensus expected = expected_census(state, census.num_pixels());
  if (census == expected) return;
  const bool same_counts = census.num_placed() == expected.num_placed() && census.num_on() == expected.num_on();
  throw UserError(
      path, fmt::format("/order does not fit /state: it has {} pixels with a place and {} that are on, expected {} and "
                        "{}{}; the file was not written by generate",
                        census.num_placed(), census.num_on(), expected.num_placed(), expected.num_on(),
                        same_counts ? ", and every place once" : ""));
}

}  // namespace

const char* vac_phase_name(VacPhase phase) { return order_phase_names[static_cast<std::size_t>(phase)]; }

void add_order_rows(const VacProgress& before, const VacProgress& after, std::int64_t num_pixels, double seconds,
                    std::vector<OrderRow>& history) {
  const auto add = [&](VacPhase phase, std::int64_t swaps, std::int64_t placed) {
    history.push_back({static_cast<double>(phase), static_cast<double>(swaps), static_cast<double>(placed), seconds});
  };
  const auto ended = [&](VacPhase phase) { return before.phase <= phase && after.phase > phase; };
  const std::int64_t points = after.num_start_points;
  const std::int64_t swaps_a_row = std::max<std::int64_t>(1, (points + 3) / 4);
  for (std::int64_t swaps = before.num_swaps + 1; swaps <= after.num_swaps; ++swaps) {
    if (swaps % swaps_a_row == 0) add(VacPhase::swap, swaps, 0);
  }
  if (ended(VacPhase::swap)) add(VacPhase::drain, after.num_swaps, 0);
  if (ended(VacPhase::drain)) add(VacPhase::fill, after.num_swaps, points);
  for (std::int64_t part = 1; part < 16; ++part) {
    const auto placed = static_cast<std::int64_t>(static_cast<__int128>(num_pixels) * part / 16);
    if (placed > points && before.num_placed < placed && after.num_placed >= placed) {
      add(VacPhase::fill, after.num_swaps, placed);
    }
  }
  if (ended(VacPhase::fill)) add(VacPhase::done, after.num_swaps, num_pixels);
}

OrderState order_state(const RunFileContent& content, const std::string& path) {
  const RunConfig config = stored_config(content, path);
  OrderState state = state_of<OrderState>(content, path, visit_order_state, visit_order_row);
  stored_algorithm(content, path);
  ContentFaults faults(path);
  faults.require(config.optimizer.method == Method::void_and_cluster, "has an /order, but its /config another method");
  check_datasets(content, order_run_datasets(config), faults);
  faults.throw_if_any();
  check_counts(state, content.extents.num_cells(), path);
  const std::int64_t points = vac_num_start_points(vac_spec(config));
  if (state.start_points != points) {
    throw UserError(path,
                    fmt::format("/state has {} start points, but the config asks for {}", state.start_points, points));
  }
  check_rows(state, path);
  return state;
}

void check_order(const RunFileReader& file, const OrderState& state) {
  check_census(census_of_order(file), state, file.path());
}

std::vector<SliceDataset> order_run_datasets(const RunConfig& config) {
  return {{samples_name, ElementType::float32, num_channels(config.problem.samples), true},
          order_dataset(config.problem.extents.num_cells())};
}

std::string save_order_run(FileOps& ops, const std::string& path, const RunConfig& config, const VoidAndCluster& run,
                           const std::vector<OrderRow>& history, const Communicator& communicator,
                           const std::map<std::string, Attribute>& provenance) {
  const VacProgress& progress = run.progress();
  const OrderState state{.phase = vac_phase_name(progress.phase),
                         .start_points = progress.num_start_points,
                         .swaps = progress.num_swaps,
                         .placed = progress.num_placed,
                         .finished = run.done() ? "order" : "",
                         .history = history};
  RunFileContent content =
      content_of(config, Method::void_and_cluster, state, visit_order_state, visit_order_row, provenance);
  content.datasets = order_run_datasets(config);
  const SampleSource source(config.problem.samples, content.extents.cells_per_slice(), content.extents.num_slices(),
                            config.problem.seed);
  const auto produce = [&](std::size_t dataset, SliceIndex slice, std::vector<std::byte>& block) {
    block = run.order(slice);
    if (dataset != 0) return;
    const std::int64_t num_pixels = content.extents.num_cells();
    const auto samples = config.problem.samples.curve == Curve::none
                             ? samples_of_order(block, run.codec(), num_pixels, config.order)
                             : samples_along_curve(block, run.codec(), num_pixels, source.list(slice));
    block.clear();
    append(block, samples);
  };
  const Distribution distribution(run.partition(), communicator.rank());
  return publish_run(ops, path, content, distribution, communicator, produce);
}

std::vector<OrderRow> restore_order_run(const RunFileReader* file, const RunConfig& config, VoidAndCluster& run,
                                        const Communicator& communicator) {
  const Extents& extents = config.problem.extents;
  OrderState state;
  communicator.on_root([&] {
    state = order_state(file->content(), file->path());
    if (state.finished.empty()) require_same_algorithm(file->content(), config.optimizer.method, file->path());
  });
  broadcast_state(state, visit_order_state, communicator);

  OrderCensus census(extents.num_cells());
  std::map<SliceIndex, std::vector<std::byte>> own;
  const auto produce = [&](SliceIndex slice, std::vector<std::byte>& block) {
    const int order = file->dataset(order_name);
    block.resize(bytes_per_slice(file->content().datasets[static_cast<std::size_t>(order)], extents));
    file->read_slice(order, slice, block);
    census.add(run.codec(), block);
  };
  const auto consume = [&](SliceIndex slice, std::span<const std::byte> block) {
    own[slice].assign(block.begin(), block.end());
  };
  const IndexRange<SliceIndex> slices = Distribution(run.partition(), communicator.rank()).own_slices();
  const std::vector<SliceIndex> wanted(slices.begin(), slices.end());
  communicator.stream_from_root(wanted, produce, consume);
  // The whole order is needed to judge it, and passes through rank 0.
  communicator.on_root([&] { check_census(census, state, file->path()); });
  run.restore({phase_of(state, ""), state.start_points, state.swaps, state.placed},
              [&](SliceIndex slice) { return std::move(own.at(slice)); });
  return state.history;
}

}  // namespace noiseloom
