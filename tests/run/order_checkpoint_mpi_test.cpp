// A run of void and cluster and its run file: on any number of ranks, at any moment, to the same bytes.
#include "noiseloom/run/order_checkpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "noiseloom/construct/order_samples.h"
#include "support/shared_folder.h"

namespace noiseloom {
namespace {

using testing::HasSubstr;

constexpr const char* config_text = R"([texture]
size = { x = 13, y = 11, t = 7 }
[filter]
combine = "sum"
groups = [ { axes = "xy", kernel = "gauss-energy", sigma = 1.2 }, { axes = "t", kernel = "gauss-energy", sigma = 1.0 } ]
[optimizer]
method = "void-and-cluster"
density = 0.2
)";

RunConfig config_of(const std::vector<std::string>& overrides = {}) {
  return parse_config(config_text, "run.toml", "", overrides);
}

// A run that notes its history as generate does.
struct MaskRun {
  explicit MaskRun(const RunConfig& config_in, const Communicator& communicator_in)
      : config(config_in), communicator(communicator_in), pool(1), vac(vac_spec(config), communicator, pool) {}

  void start() {
    vac.start();
    history = {{}};
  }
  void advance(std::int64_t picks) {
    const VacProgress before = vac.progress();
    vac.advance(picks);
    add_order_rows(before, vac.progress(), config.problem.extents.num_cells(), 0, history);
  }
  std::string save(const std::string& path) {
    return save_order_run(posix_file_ops(), path, config, vac, history, communicator, {});
  }
  void restore(const std::string& path) {
    std::unique_ptr<RunFileReader> reader;
    communicator.on_root([&] { reader = std::make_unique<RunFileReader>(path); });
    history = restore_order_run(reader.get(), config, vac, communicator);
  }

  RunConfig config;
  const Communicator& communicator;
  ThreadPool pool;
  VoidAndCluster vac;
  std::vector<OrderRow> history;
};

template <class T>
std::vector<T> values_of(const RunFileReader& reader, const std::string& name) {
  const int dataset = reader.dataset(name);
  const RunFileContent& content = reader.content();
  const std::size_t size = bytes_per_slice(content.datasets.at(static_cast<std::size_t>(dataset)), content.extents);
  std::vector<T> values;
  for (const SliceIndex slice : content.extents.slices()) {
    std::vector<T> part(size / sizeof(T));
    reader.read_slice(dataset, slice, std::as_writable_bytes(std::span(part)));
    values.insert(values.end(), part.begin(), part.end());
  }
  return values;
}

// Moments inside every phase: 200 points; 1001 pixels.
constexpr std::int64_t moments[] = {0, 1, 15, 150, 250, 400, 900};

TEST(OrderCheckpoint, GoesOnFromEveryPhaseOnOtherRankCounts) {
  const Communicator world = Communicator::world();
  const SharedFolder folder(world);
  const RunConfig config = config_of();
  std::string expected;
  std::vector<OrderRow> expected_history;
  if (world.is_root()) {
    const Communicator alone = Communicator::self();
    MaskRun straight(config, alone);
    straight.start();
    straight.advance(1'000'000);
    expected = straight.save(folder / "straight.h5");
    expected_history = straight.history;
  }
  std::set<std::string> phases;
  for (const std::int64_t moment : moments) {
    {
      MaskRun first(config, world);
      first.start();
      if (moment > 0) first.advance(moment);
      phases.insert(vac_phase_name(first.vac.progress().phase));
      first.save(folder / "run.h5");
    }
    // On all ranks, then the rest on rank 0 alone.
    MaskRun second(config, world);
    second.restore(folder / "run.h5");
    second.advance(37);
    second.save(folder / "run.h5");
    if (!world.is_root()) continue;
    const Communicator alone = Communicator::self();
    MaskRun third(config, alone);
    third.restore(folder / "run.h5");
    third.advance(1'000'000);
    EXPECT_EQ(third.save(folder / "run.h5"), expected) << moment;
    ASSERT_EQ(third.history.size(), expected_history.size()) << moment;
    for (std::size_t row = 0; row < expected_history.size(); ++row) {
      EXPECT_EQ(third.history[row].phase, expected_history[row].phase);
      EXPECT_EQ(third.history[row].swaps, expected_history[row].swaps);
      EXPECT_EQ(third.history[row].placed, expected_history[row].placed);
    }
  }
  EXPECT_EQ(phases, (std::set<std::string>{"swap", "drain", "fill"}));
}

TEST(OrderCheckpoint, FileHoldsOrderMarksAndSamples) {
  const Communicator world = Communicator::world();
  const SharedFolder folder(world);
  for (const char* bits : {"0", "4"}) {
    for (const std::int64_t moment : moments) {
      const RunConfig config = config_of({std::string("optimizer.bits=") + bits});
      MaskRun run(config, world);
      run.start();
      if (moment > 0) run.advance(moment);
      const std::string checksum = run.save(folder / "run.h5");
      if (!world.is_root()) continue;
      const RunFileReader reader(folder / "run.h5");
      EXPECT_TRUE(is_order_run(reader.content()));
      EXPECT_EQ(reader.content().checksums.at("/samples"), checksum);
      const OrderState state = order_state(reader.content(), reader.path());
      EXPECT_EQ(state.start_points, 200);
      EXPECT_EQ(state.placed, run.vac.progress().num_placed);
      EXPECT_EQ(state.finished, "");
      const auto order = values_of<std::uint32_t>(reader, "/order");
      const auto samples = values_of<float>(reader, "/samples");
      std::int64_t num_on = 0;
      std::set<std::uint32_t> places;
      for (std::size_t i = 0; i < order.size(); ++i) {
        num_on += order[i] == 0xFFFFFFFEU;
        EXPECT_EQ(std::isnan(samples[i]), order[i] >= 0xFFFFFFFEU);
        if (order[i] >= 0xFFFFFFFEU) continue;
        places.insert(order[i]);
        EXPECT_EQ(samples[i], sample_of_place(order[i], order.size(), config.order.bits));
      }
      EXPECT_EQ(static_cast<std::int64_t>(places.size()), state.placed);
      EXPECT_EQ(num_on, state.phase == "fill" ? 0 : 200 - state.placed);
    }
  }
}

// A finished file that is written again with a change: what a broken tool could leave.
struct Change {
  const char* what;
  std::function<void(RunFileContent&, std::vector<std::uint32_t>& order)> apply;
  const char* words;
};

TEST(OrderCheckpoint, RefusesAnOrderThatContradictsItsCounts) {
  const Communicator world = Communicator::world();
  const SharedFolder folder(world);
  const RunConfig config = config_of();
  const std::vector<Change> changes = {
      {"twice the same place", [](auto&, auto& order) { order[5] = order[6]; }, "every place once"},
      {"a place past the end", [](auto&, auto& order) { order[5] = 1001; }, "every place once"},
      {"a pixel without place", [](auto&, auto& order) { order[5] = ~0U; }, "1000 pixels with a place"},
      {"a pixel that is on", [](auto&, auto& order) { order[5] = ~0U - 1; }, "1 that are on"},
      {"a phase of its own", [](auto& content, auto&) { content.state["phase"] = std::string("melt"); }, "\"melt\""},
      {"too few places", [](auto& content, auto&) { content.state["ranked"] = std::int64_t{7}; }, "no run has this"},
      {"counts of another phase", [](auto& content, auto&) { content.state["phase"] = std::string("drain"); },
       "no run has this"},
      {"points of another density", [](auto& content, auto&) { content.state["start_points"] = std::int64_t{100}; },
       "the config asks for 200"},
      {"no count", [](auto& content, auto&) { content.state.erase("swaps"); }, "\"swaps\""},
      {"history of no phase", [](auto& content, auto&) { content.history[0].second[0] = 7; }, "/history/phase"},
  };
  for (const Change& change : changes) {
    SCOPED_TRACE(change.what);
    if (world.is_root()) {
      const Communicator alone = Communicator::self();
      MaskRun run(config, alone);
      run.start();
      run.advance(1'000'000);
      run.save(folder / "good.h5");
      const RunFileReader good(folder / "good.h5");
      RunFileContent content = good.content();
      auto order = values_of<std::uint32_t>(good, "/order");
      const auto samples = values_of<float>(good, "/samples");
      change.apply(content, order);
      RunFileWriter writer(posix_file_ops(), folder / "bad.h5", content);
      for (const SliceIndex slice : first_indices<SliceIndex>(7)) {
        const auto cells = static_cast<std::size_t>(13 * 11);
        const std::size_t first = static_cast<std::size_t>(slice) * cells;
        writer.write_slice(0, slice, std::as_bytes(std::span(samples).subspan(first, cells)));
        writer.write_slice(1, slice, std::as_bytes(std::span(order).subspan(first, cells)));
      }
      writer.publish();
    }
    world.barrier();
    MaskRun run(config, world);
    try {
      run.restore(folder / "bad.h5");
      ADD_FAILURE() << "was accepted";
    } catch (const SharedUserError& error) {
      EXPECT_THAT(error.what(), HasSubstr(change.words));
    }
  }
}

TEST(OrderRows, DoNotDependOnTheSteps) {
  const auto row = [](const OrderRow& r) { return std::array{r.phase, r.swaps, r.placed}; };
  const Communicator alone = Communicator::self();
  std::vector<std::array<double, 3>> expected;
  for (const std::int64_t step : {1'000'000, 1, 7, 200}) {
    MaskRun run(config_of(), alone);
    run.start();
    while (!run.vac.done()) run.advance(step);
    std::vector<std::array<double, 3>> rows;
    for (const OrderRow& r : run.history) rows.push_back(row(r));
    if (expected.empty()) expected = rows;
    EXPECT_EQ(rows, expected) << step;
    EXPECT_EQ(rows.front(), (std::array{0.0, 0.0, 0.0}));
    const auto swaps = static_cast<double>(run.vac.progress().num_swaps);
    EXPECT_EQ(rows.back(), (std::array{3.0, swaps, 1001.0}));
    EXPECT_THAT(rows, testing::Contains(std::array{1.0, swaps, 0.0}));
    EXPECT_THAT(rows, testing::Contains(std::array{2.0, swaps, 200.0}));
    EXPECT_THAT(rows, testing::Contains(std::array{2.0, swaps, std::floor(1001.0 * 8 / 16)}));
  }
}

}  // namespace
}  // namespace noiseloom
