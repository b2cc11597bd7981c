// A run by swaps and its run file: every rank refuses what no run can have left behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "noiseloom/config/inputs.h"
#include "noiseloom/files/npy.h"
#include "noiseloom/run/checkpoint.h"
#include "noiseloom/run/shared_inputs.h"
#include "support/shared_folder.h"

namespace noiseloom {
namespace {

using testing::HasSubstr;

constexpr const char* swap_config_text = R"([texture]
size = { x = 7, y = 5, t = 9 }
[filter]
groups = [ { axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "ema", alpha = 0.1 } ]
[optimizer]
method = "anneal"
stop = { iterations = 30 }
)";

struct SwapRun {
  SwapRun(const RunConfig& config_in, const Communicator& communicator_in)
      : config(config_in),
        communicator(communicator_in),
        pool(1),
        source(config.problem.samples, config.problem.extents.cells_per_slice(), config.problem.extents.num_slices(),
               config.problem.seed),
        engine(config.problem, config.optimizer, source, communicator, pool) {}

  void steps(int count) {
    for (int i = 0; i < count && !engine.finished(); ++i) engine.step(0);
  }
  std::string save(const std::string& path) {
    return save_run(posix_file_ops(), path, config, source, engine, communicator, {{"version", std::string("9.9")}});
  }
  void restore(const std::string& path) {
    std::unique_ptr<RunFileReader> reader;
    communicator.on_root([&] { reader = std::make_unique<RunFileReader>(path); });
    restore_run(reader.get(), config, engine, communicator);
  }

  RunConfig config;
  const Communicator& communicator;
  ThreadPool pool;
  SampleSource source;
  SwapOptimizer engine;
};

RunConfig swap_config_of(const std::vector<std::string>& overrides = {}) {
  return parse_config(swap_config_text, "run.toml", "", overrides);
}

// A run file with other /state and other ids of one slice, written by rank 0 alone.
void write_changed(const Communicator& world, const std::string& path, SliceIndex slice,
                   const std::function<void(RunFileContent&, std::vector<std::uint32_t>&)>& change) {
  if (world.is_root()) {
    const Communicator alone = Communicator::self();
    SwapRun run(swap_config_of(), alone);
    run.engine.start();
    run.steps(3);
    run.save(path + ".good");
    const RunFileReader good(path + ".good");
    RunFileContent content = good.content();
    const Extents& extents = content.extents;
    std::vector<std::uint32_t> ids(static_cast<std::size_t>(extents.cells_per_slice()));
    good.read_slice(1, slice, std::as_writable_bytes(std::span(ids)));
    change(content, ids);
    RunFileWriter writer(posix_file_ops(), path, content);
    for (int dataset = 0; dataset < 2; ++dataset) {
      for (const SliceIndex s : extents.slices()) {
        std::vector<std::byte> bytes(ids.size() * sizeof(std::uint32_t));
        good.read_slice(dataset, s, bytes);
        if (dataset == 1 && s == slice) std::memcpy(bytes.data(), ids.data(), bytes.size());
        writer.write_slice(dataset, s, bytes);
      }
    }
    writer.publish();
  }
  world.barrier();
}

// What restoring says on this rank; "good" where it says nothing.
std::string restoring(const std::string& path, const RunConfig& config, const Communicator& world) {
  SwapRun run(config, world);
  try {
    run.restore(path);
    return "good";
  } catch (const SharedUserError& error) {
    return error.what();
  }
}

TEST(SwapCheckpoint, GoesOnFromEveryStepOfASweep) {
  const Communicator world = Communicator::world();
  const SharedFolder folder(world);
  SwapRun straight(swap_config_of(), world);
  straight.engine.start();
  straight.steps(1'000'000);
  const std::string expected = straight.save(folder / "straight.h5");
  for (const int steps : {0, 1, 3, 4, 17}) {
    SwapRun begun(swap_config_of(), world);
    begun.engine.start();
    begun.steps(steps);
    begun.save(folder / "run.h5");
    SwapRun run(swap_config_of(), world);
    run.restore(folder / "run.h5");
    run.steps(1'000'000);
    EXPECT_EQ(run.save(folder / "run.h5"), expected) << steps;
  }
}

TEST(SwapCheckpoint, RefusesContentsThatNoRunHasOnEveryRank) {
  const Communicator world = Communicator::world();
  const SharedFolder folder(world);
  struct Change {
    std::int32_t slice;
    std::function<void(RunFileContent&, std::vector<std::uint32_t>&)> apply;
    const char* words;
  };
  const Change changes[] = {
      {0, [](auto&, auto&) {}, "good"},
      {0, [](auto&, auto& ids) { ids[3] = 35; }, "slice 0: cell 3 holds id 35, must be below 35"},
      {8, [](auto&, auto& ids) { ids[34] = 0x7fffffff; }, "slice 8: cell 34 holds id 2147483647"},
      {4, [](auto&, auto& ids) { ids[2] = ids[1]; }, "slice 4: cell 2 holds id "},
      {8, [](auto&, auto& ids) { std::swap(ids[2], ids[1]); }, "slice 8: the stored samples are not those"},
      {0, [](auto& content, auto&) { content.state["step"] = std::int64_t{8}; }, "a sweep has "},
      {0, [](auto& content, auto&) { content.state["step"] = std::int64_t{1000}; }, "/state/@step = 1000"},
      {0, [](auto& content, auto&) { content.state["sweep"] = std::int64_t{30}; }, "/state/@sweep = 30"},
      {0, [](auto& content, auto&) { content.state["finished"] = std::string("iterations"); }, "/state/@step"},
      {0, [](auto& content, auto&) { content.history[1].second[0] = 4; }, "/history/iterations, row 0 = 4"},
      {0, [](auto& content, auto&) { content.history[1].first = "others"; }, "/history/iterations: missing"},
  };
  for (const Change& change : changes) {
    SCOPED_TRACE(change.words);
    write_changed(world, folder / "run.h5", SliceIndex(change.slice), change.apply);
    const std::string said = restoring(folder / "run.h5", swap_config_of(), world);
    EXPECT_THAT(said, HasSubstr(change.words));
    if (said != "good") {
      EXPECT_THAT(said, HasSubstr(folder / "run.h5"));
    }
    world.barrier();
  }
}

TEST(SwapCheckpoint, RefusesTheRunOfAnotherAlgorithm) {
  const Communicator world = Communicator::world();
  const SharedFolder folder(world);
  write_changed(world, folder / "run.h5", SliceIndex(0),
                [](auto& content, auto&) { content.state["algorithm"] = anneal_algorithm + 1; });
  const std::string said = restoring(folder / "run.h5", swap_config_of(), world);
  const std::string later = std::to_string(anneal_algorithm + 1);
  EXPECT_THAT(said, HasSubstr("run.h5: begun with algorithm " + later +
                              " of anneal (noiseloom 9.9), but this program has algorithm " +
                              std::to_string(anneal_algorithm)));
  EXPECT_THAT(said, HasSubstr("finish it with a program of algorithm " + later + ", or start afresh"));
  world.barrier();
  // From before there were numbers.
  write_changed(world, folder / "run.h5", SliceIndex(0), [](auto& content, auto&) {
    for (const char* name : {"algorithm", "relative_error", "iterations", "scored_iterations", "scored_step"})
      content.state.erase(name);
  });
  EXPECT_THAT(restoring(folder / "run.h5", swap_config_of(), world), HasSubstr("begun with algorithm 1 of anneal"));
}

TEST(SwapCheckpoint, RanksThatHaveNoFilesWorkFromThoseOfRank0) {
  const Communicator world = Communicator::world();
  const SharedFolder folder(world);
  const std::vector<std::string> overrides = {"texture.samples={ file = \"mine.npy\" }"};
  if (world.is_root()) {
    std::vector<float> list(35);
    for (std::size_t i = 0; i < list.size(); ++i) list[i] = static_cast<float>(i * i % 37);
    write_npy(folder / "mine.npy", std::vector<std::int64_t>{35}, list);
  }
  const std::string where = world.is_root() ? (folder / "") : "/no such folder/";
  RunConfig config = parse_config(swap_config_text, "run.toml", where, overrides, MissingFiles::accepted);
  share_inputs(config, nullptr, world);
  ASSERT_TRUE(config.problem.samples.array);
  SwapRun run(config, world);
  run.engine.start();
  run.steps(1'000'000);
  run.save(folder / "run.h5");

  // And from the run file, once it is gone.
  if (world.is_root()) std::filesystem::remove(folder / "mine.npy");
  std::unique_ptr<RunFileReader> reader;
  world.on_root([&] { reader = std::make_unique<RunFileReader>(folder / "run.h5"); });
  RunConfig again = parse_config(swap_config_text, "run.toml", where, overrides, MissingFiles::accepted);
  share_inputs(again, reader.get(), world);
  EXPECT_EQ(*again.problem.samples.array, *config.problem.samples.array);
  RunConfig afresh = parse_config(swap_config_text, "run.toml", where, overrides, MissingFiles::accepted);
  EXPECT_THROW(share_inputs(afresh, nullptr, world), SharedUserError);
}

}  // namespace
}  // namespace noiseloom
