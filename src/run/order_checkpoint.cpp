#include "noiseloom/run/order_checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <numeric>

#include "noiseloom/construct/order_samples.h"
#include "run/checkpoint_parts.h"

namespace noiseloom {
namespace {

constexpr const char* phase_names[] = {"swap", "drain", "fill", "done"};
constexpr double phase_numbers[] = {0, 1, 2, 3};

constexpr auto visit_state = [](auto& state, const auto& visit) {
  visit("phase", state.phase);
  visit("start_points", state.start_points);
  visit("swaps", state.swaps);
  visit("ranked", state.ranked);
  visit("finished", state.finished);
};

constexpr auto visit_row = [](auto&& row, const auto& visit) {
  visit("phase", row.phase);
  visit("swaps", row.swaps);
  visit("ranked", row.ranked);
  visit("seconds", row.seconds);
};

// What the pixels of /order come to. Ranks are compared as sets by the sum of a mixture of each, so that billions need
// no memory.
struct Census {
  std::int64_t num_on = 0;
  std::int64_t num_ranked = 0;
  std::uint64_t rank_sum = 0;

  static std::uint64_t mixed(std::uint64_t rank) {  // the finalizer of SplitMix64
    std::uint64_t z = rank + 0x9E3779B97F4A7C15U;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31);
  }

  template <class Rank>
  void add(std::span<const std::byte> bytes) {
    constexpr Rank on = std::numeric_limits<Rank>::max() - 1;
    for (std::size_t at = 0; at < bytes.size(); at += sizeof(Rank)) {
      Rank rank = 0;
      std::memcpy(&rank, bytes.data() + at, sizeof(Rank));
      num_on += rank == on;
      if (rank >= on) continue;
      ++num_ranked;
      rank_sum += mixed(rank);
    }
  }

  static Census of_ranks(std::int64_t begin, std::int64_t end, std::int64_t num_on) {
    Census census{num_on, end - begin, 0};
    for (std::int64_t rank = begin; rank < end; ++rank) census.rank_sum += mixed(static_cast<std::uint64_t>(rank));
    return census;
  }

  friend bool operator==(const Census&, const Census&) = default;
};

Census expected_census(const OrderState& state) {
  if (state.phase == phase_names[0]) return Census::of_ranks(0, 0, state.start_points);
  if (state.phase != phase_names[1]) return Census::of_ranks(0, state.ranked, 0);
  return Census::of_ranks(state.start_points - state.ranked, state.start_points, state.start_points - state.ranked);
}

VacPhase phase_of(const OrderState& state) {
  const auto found = std::find(std::begin(phase_names), std::end(phase_names), state.phase);
  if (found == std::end(phase_names)) {
    throw UserError("", fmt::format("/state: phase \"{}\" is none of void and cluster", state.phase));
  }
  return static_cast<VacPhase>(found - std::begin(phase_names));
}

void check_counts(const OrderState& state, std::int64_t num_pixels) {
  const VacPhase phase = phase_of(state);
  const std::int64_t points = state.start_points;
  bool sound = points >= 0 && points <= num_pixels && state.swaps >= 0;
  switch (phase) {
    case VacPhase::swap:
      sound = sound && state.ranked == 0;
      break;
    case VacPhase::drain:
      sound = sound && state.ranked >= 0 && state.ranked <= points;
      break;
    case VacPhase::fill:
      sound = sound && state.ranked >= points && state.ranked <= num_pixels;
      break;
    case VacPhase::done:
      sound = sound && state.ranked == num_pixels;
      break;
  }
  if (!sound || state.finished.empty() != (phase != VacPhase::done)) {
    throw UserError("", fmt::format("/state: phase {}, {} start points, {} swaps, {} of {} pixels ranked{}: no run has "
                                    "this",
                                    state.phase, points, state.swaps, state.ranked, num_pixels,
                                    state.finished.empty() ? "" : ", finished"));
  }
}

}  // namespace

const char* vac_phase_name(VacPhase phase) { return phase_names[static_cast<std::size_t>(phase)]; }

void add_order_rows(const VacProgress& before, const VacProgress& after, std::int64_t num_pixels, double seconds,
                    std::vector<OrderRow>& history) {
  const auto add = [&](VacPhase phase, std::int64_t swaps, std::int64_t ranked) {
    history.push_back({static_cast<double>(phase), static_cast<double>(swaps), static_cast<double>(ranked), seconds});
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
    const auto ranked = static_cast<std::int64_t>(static_cast<__int128>(num_pixels) * part / 16);
    if (ranked > points && before.num_ranked < ranked && after.num_ranked >= ranked) {
      add(VacPhase::fill, after.num_swaps, ranked);
    }
  }
  if (ended(VacPhase::fill)) add(VacPhase::done, after.num_swaps, num_pixels);
}

OrderState order_state(const RunFileContent& content) {
  OrderState state = state_of<OrderState>(content, visit_state, visit_row);
  check_counts(state, content.extents.num_cells());
  for (const OrderRow& row : state.history) {
    const auto is_phase = [&](double phase) { return row.phase == phase; };
    if (std::none_of(std::begin(phase_numbers), std::end(phase_numbers), is_phase)) {
      throw UserError("", fmt::format("/history/phase: {} is no phase of void and cluster", row.phase));
    }
  }
  return state;
}

std::vector<SliceDataset> order_run_datasets(bool wide) {
  return {{samples_name, ElementType::float32, 1, true},
          {order_name, wide ? ElementType::uint64 : ElementType::uint32, 1, false}};
}

std::string save_order_run(FileOps& ops, const std::string& path, const RunConfig& config, const VoidAndCluster& run,
                           const std::vector<OrderRow>& history, const Communicator& communicator,
                           const std::string& inputs, const std::map<std::string, Attribute>& provenance) {
  const VacProgress& progress = run.progress();
  const OrderState state{.phase = vac_phase_name(progress.phase),
                         .start_points = progress.num_start_points,
                         .swaps = progress.num_swaps,
                         .ranked = progress.num_ranked,
                         .finished = run.done() ? "order" : "",
                         .history = history};
  RunFileContent content = content_of(config, state, visit_state, visit_row, inputs, provenance);
  content.datasets = order_run_datasets(run.wide());
  const auto produce = [&](std::size_t dataset, SliceIndex slice, std::vector<std::byte>& block) {
    block = run.order(slice);
    if (dataset != 0) return;
    const auto samples = samples_of_order(block, run.wide(), content.extents.num_cells(), config.order);
    block.clear();
    append(block, samples);
  };
  return publish_run(ops, path, content, run.partition(), communicator, produce);
}

std::vector<OrderRow> restore_order_run(const RunFileReader* file, const RunConfig& config, VoidAndCluster& run,
                                        const Communicator& communicator) {
  const Extents& extents = config.problem.extents;
  OrderState state;
  int order = -1;
  communicator.on_root([&] {
    state = order_state(file->content());
    order = file->dataset(order_name);
    const ElementType type = run.wide() ? ElementType::uint64 : ElementType::uint32;
    if (order < 0 || file->content().datasets[static_cast<std::size_t>(order)].type != type) {
      throw UserError("", "the run file has no /order, or one of another type than the texture asks for");
    }
    const std::int64_t points = vac_num_start_points(vac_spec(config));
    if (state.start_points != points) {
      throw UserError(
          "", fmt::format("/state has {} start points, but the config asks for {}", state.start_points, points));
    }
  });
  broadcast_state(state, visit_state, communicator);

  Census census;
  std::map<SliceIndex, std::vector<std::byte>> own;
  const auto produce = [&](SliceIndex slice, std::vector<std::byte>& block) {
    const SliceDataset& dataset = file->content().datasets[static_cast<std::size_t>(order)];
    block.resize(bytes_per_slice(dataset, extents));
    file->read_slice(order, slice, block);
    if (run.wide()) {
      census.add<std::uint64_t>(block);
    } else {
      census.add<std::uint32_t>(block);
    }
  };
  const auto consume = [&](SliceIndex slice, std::span<const std::byte> block) {
    own[slice].assign(block.begin(), block.end());
  };
  std::vector<SliceIndex> wanted(static_cast<std::size_t>(run.partition().count(communicator.rank())));
  std::iota(wanted.begin(), wanted.end(), run.partition().begin(communicator.rank()));
  communicator.stream_from_root(wanted, produce, consume);
  communicator.on_root([&] {
    const Census expected = expected_census(state);
    if (census == expected) return;
    throw UserError("", fmt::format("/order does not fit /state: it has {} pixels with a rank and {} that are on, "
                                    "expected {} and {}{}; the file was not written by generate",
                                    census.num_ranked, census.num_on, expected.num_ranked, expected.num_on,
                                    census.num_ranked == expected.num_ranked && census.num_on == expected.num_on
                                        ? ", and every rank once"
                                        : ""));
  });
  run.restore({phase_of(state), state.start_points, state.swaps, state.ranked},
              [&](SliceIndex slice) { return std::move(own.at(slice)); });
  return state.history;
}

}  // namespace noiseloom
