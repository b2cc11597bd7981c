// Construction gives the places of one process on any number of ranks and threads, and after any interruption.
#include "noiseloom/construct/slice_construction.h"

#include <gtest/gtest.h>

#include <cstring>

#include "support/construct_problems.h"
#include "support/slice_construction_oracle.h"

namespace noiseloom {
namespace {

using namespace testing_support;
using Places = oracle::SliceConstructionOracle::Places;

class SharedConstruction {
 public:
  explicit SharedConstruction(const ConstructProblem& problem, int num_threads = 1)
      : world_(Communicator::world()),
        pool_(num_threads),
        run_(Footprint(problem.extents, problem.filter), problem.filter, problem.scale, problem.spec, problem.seed,
             world_, pool_) {}
  SliceConstruction& operator*() { return run_; }
  SliceConstruction* operator->() { return &run_; }
  void finish() {
    while (!run_.done()) run_.advance();
  }
  // Of all slices, on every rank. *Collective*
  Places places() const {
    std::vector<std::byte> own;
    std::size_t cells = 0;
    for (const SliceIndex slice : own_slices()) {
      const auto bytes = std::as_bytes(std::span(run_.places(slice)));
      own.insert(own.end(), bytes.begin(), bytes.end());
    }
    const std::vector<std::byte> all = world_.gather_all(std::span<const std::byte>(own));
    Places places(static_cast<std::size_t>(run_.distribution().num_slices()));
    cells = all.size() / sizeof(std::uint32_t) / places.size();
    for (std::size_t slice = 0; slice < places.size(); ++slice) {
      places[slice].resize(cells);
      const std::size_t bytes = cells * sizeof(std::uint32_t);
      std::memcpy(places[slice].data(), all.data() + slice * bytes, bytes);
    }
    return places;
  }
  // What this rank has of slices of others is what those have.
  void expect_held_slices_equal(const Places& all) const {
    for (const SliceIndex slice : run_.slices_held()) {
      ASSERT_EQ(run_.places(slice), all[static_cast<std::size_t>(slice)]) << slice;
    }
  }
  IndexRange<SliceIndex> own_slices() const { return run_.distribution().own_slices(); }
  int num_ranks() const { return world_.size(); }

 private:
  Communicator world_;
  ThreadPool pool_;
  SliceConstruction run_;
};

std::vector<ConstructProblem> shared_problems() {
  std::vector<ConstructProblem> problems = construct_problems();
  for (const ConstructProblem& problem : construct_problems()) {
    const bool is_taken = problem.name == "gauss and ema" || problem.name == "negative taps and ema" ||
                          problem.name == "two slice axes" || problem.name == "gauss plus ema";
    if (is_taken) problems.push_back(problem.on_circle());
  }
  const FilterSpec blurred = product({group({0, 1}, gauss(1)), group({2}, ema(0.1, 0.1))});
  problems.push_back(construct_problem("fewer slices than ranks", {9, 8, 2}, blurred));
  problems.push_back(construct_problem("several picks a visit", {47, 49, 4}, blurred).with_density(0.03));
  problems.push_back(construct_problem("no start points", {7, 6, 5}, blurred).with_density(0));
  problems.push_back(construct_problem("half of the points", {7, 6, 5}, blurred).with_density(0.5));
  problems.push_back(construct_problem("one pixel", {1, 1, 7}, blurred));
  problems.push_back(construct_problem("several exchanges a visit", {47, 49, 4}, blurred).on_circle());
  problems.push_back(construct_problem("one pixel", {1, 1, 7}, blurred).on_circle());
  problems.push_back(construct_problem("time alone", {5, 4, 11}, product({group({2}, ema(0.1, 0.1))})));
  return problems;
}

TEST(SliceConstructionRanks, GiveThePlacesOfOneProcess) {
  for (const ConstructProblem& problem : shared_problems()) {
    const Places alone = places_of(problem);
    for (const int threads : {1, 3}) {
      SharedConstruction run(problem, threads);
      run->start();
      run.finish();
      EXPECT_EQ(run.places(), alone) << problem.name << ", " << threads << " threads";
    }
  }
}

TEST(SliceConstructionRanks, EqualSlowTwinInEveryRound) {
  for (const ConstructProblem& problem : shared_problems()) {
    if (problem.extents.num_cells() > 700) continue;
    SCOPED_TRACE(problem.name);
    SharedConstruction run(problem);
    run->start();
    oracle::SliceConstructionOracle slow(problem.extents, problem.filter, problem.scale, problem.spec, problem.seed,
                                         run->points_per_visit());
    for (; !slow.done(); slow.advance(), run->advance()) {
      ASSERT_EQ(run->progress(), slow.progress());
      ASSERT_EQ(run.places(), slow.places());
      run.expect_held_slices_equal(slow.places());
    }
    EXPECT_EQ(run->progress(), slow.progress());
  }
}

// What one process had after any round goes on on all ranks and threads, and the other way round.
TEST(SliceConstructionRanks, GoOnFromTheStateOfAnotherNumberOfRanks) {
  for (const ConstructProblem& problem : shared_problems()) {
    if (problem.extents.cells_per_slice() > 42) continue;
    SCOPED_TRACE(problem.name);
    const Places whole = places_of(problem);
    AloneConstruction alone(problem);
    SharedConstruction together(problem);
    together->start();
    for (std::int64_t round = 0;; ++round) {
      ASSERT_EQ(together->progress(), alone->progress());
      SharedConstruction resumed(problem, round % 2 == 0 ? 1 : 3);
      resumed->restore(alone->progress(), [&](SliceIndex slice) { return alone->places(slice); });
      resumed.finish();
      ASSERT_EQ(resumed.places(), whole) << "from round " << round << " of one process";

      const Places now = together.places();
      AloneConstruction back(problem, round % 2 == 0 ? 3 : 1);
      back->restore(together->progress(), [&](SliceIndex slice) { return now[static_cast<std::size_t>(slice)]; });
      back.finish();
      ASSERT_EQ(back.places(), whole) << "from round " << round << " of all ranks";
      if (alone->done()) break;
      alone->advance();
      together->advance();
    }
  }
}

// Restoring asks for the slices that are held, and for no other.
TEST(SliceConstructionRanks, AskForTheSlicesThatTheyHold) {
  for (const ConstructProblem& problem : shared_problems()) {
    AloneConstruction alone(problem);
    alone->advance();
    SharedConstruction run(problem);
    std::vector<SliceIndex> asked;
    run->restore(alone->progress(), [&](SliceIndex slice) {
      asked.push_back(slice);
      return alone->places(slice);
    });
    EXPECT_EQ(asked, run->slices_held());
    for (const SliceIndex slice : run.own_slices()) {
      EXPECT_EQ(asked.at(static_cast<std::size_t>(slice - run.own_slices().first())), slice);
    }
  }
}

// A slice that one rank cannot read: all ranks are told, none is left behind.
TEST(SliceConstructionRanks, AllThrowWhereOneCannotGoOn) {
  const ConstructProblem problem =
      construct_problem("lost", {7, 5, 11}, product({group({0, 1}, gauss(1)), group({2}, box(2))}));
  AloneConstruction alone(problem);
  alone->advance();
  SharedConstruction run(problem);
  const auto read = [&](SliceIndex slice) { return alone->places(slice); };
  const auto read_all_but_last = [&](SliceIndex slice) {
    if (slice == SliceIndex(10)) throw EnvironmentError("cannot read");
    return read(slice);
  };
  EXPECT_THROW(run->restore(alone->progress(), read_all_but_last), SharedEnvironmentError);
  run->restore(alone->progress(), read);
  run.finish();
  EXPECT_EQ(run.places(), places_of(problem));
}

TEST(SliceConstructionRanks, SendNothingWhereSlicesAreNotCoupled) {
  const FilterSpec plane = product({group({0, 1}, gauss(1))});
  const FilterSpec weak = product({group({0, 1}, gauss(1)), group({2}, taps({2}, {1, 1e-5}))});  // cut
  for (const FilterSpec& filter : {plane, weak}) {
    SharedConstruction run(construct_problem("uncoupled", {7, 6, 7}, filter));
    EXPECT_FALSE(run->couples_slices());
    EXPECT_EQ(std::ssize(run->slices_held()), run.own_slices().size());
    run->start();
    run.finish();
    EXPECT_EQ(run->bytes_sent(), 0);
    EXPECT_EQ(run->messages_sent(), 0);
  }
}

TEST(SliceConstructionRanks, SendWhatActsOnSlicesOfOthers) {
  SharedConstruction run(
      construct_problem("coupled", {7, 6, 7}, product({group({0, 1}, gauss(1)), group({2}, box(2))})));
  EXPECT_TRUE(run->couples_slices());
  run->start();
  run.finish();
  const bool has_others = run.num_ranks() > 1 && run.own_slices().size() > 0;
  EXPECT_EQ(run->bytes_sent() > 0, has_others);
  EXPECT_EQ(run->messages_sent() > 0, has_others);
  // A pick is two cells; a slice is told to at most two other ranks.
  const std::int64_t picks = run->picks_done();
  EXPECT_GE(picks, run.own_slices().size() * 42);
  EXPECT_LE(run->bytes_sent(), 16 * picks + 64 * run->messages_sent());
}

}  // namespace
}  // namespace noiseloom
