// Times construction, start-up included, and scores what it made: R of the places as 8 bits, (floor(256 (r + 0.5) / n)
// + 0.5) / 256.
//   [mpirun -n RANKS] construct_bench SIZES PRODUCT|SUM GROUP... [--circle] [--sharpness P (else found)]
//   [--density D] [--threads N] [--seed S]
// e.g. 128x128x64 product xy:gauss:1.3435 t:ema:0.1:0.1; the slice axes are t z w v u s. The fingerprint tells whether
// two runs gave the same places.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "noiseloom/construct/sharpness.h"
#include "noiseloom/construct/slice_construction.h"
#include "noiseloom/construct/time_strata.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/problem/score.h"

using namespace noiseloom;

namespace {

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::stringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

GroupSpec group_of(const std::string& text, const Extents& extents) {
  const std::vector<std::string> parts = split(text, ':');
  GroupSpec group;
  for (const char axis : parts.at(0)) group.axes.push_back(extents.axis(std::string(1, axis)));
  const std::string& kernel = parts.at(1);
  const double first = std::stod(parts.at(2));
  KernelSpec& spec = group.kernel;
  if (kernel == "box") spec.kind = KernelKind::box, spec.size = static_cast<int>(first);
  if (kernel == "gauss") spec.kind = KernelKind::gauss, spec.sigma = first;
  if (kernel == "binomial") spec.kind = KernelKind::binomial, spec.n = static_cast<int>(first);
  if (kernel == "gauss-energy") spec.kind = KernelKind::gauss_energy, spec.sigma = first;
  if (kernel == "ema") spec.kind = KernelKind::ema, spec.alpha = first, spec.rejection = std::stod(parts.at(3));
  return group;
}

template <class Run>
double score(const Run& run, const Extents& extents, const FilterSpec& filter, DistanceKind distance,
             ThreadPool& pool) {
  const auto n = static_cast<double>(extents.cells_per_slice());
  const auto value = [n](std::uint32_t place) {
    return static_cast<float>((std::floor(256 * (place + 0.5) / n) + 0.5) / 256);
  };
  std::vector<std::vector<float>> slices;
  for (const SliceIndex slice : extents.slices()) {
    std::vector<float>& samples = slices.emplace_back();
    for (const std::uint32_t place : run.places(slice)) samples.push_back(value(place));
  }
  const Footprint footprint(extents, filter);
  const auto values = [&](SliceIndex slice) { return slices[static_cast<std::size_t>(slice)].data(); };
  std::vector<double> sums(slices.size());
  pool.for_each(std::ssize(sums), [&](std::int64_t slice, int) {
    sums[static_cast<std::size_t>(slice)] =
        weighted_distance_sum(footprint, distance, 1, SliceIndex(slice), values, PairEnds::one);
  });
  const MeanDistance mean(distance, 1, extents.cells_per_slice(), extents.num_slices());
  const auto list = [&](SliceIndex slice) { return slices[static_cast<std::size_t>(slice)]; };
  return relative_error(footprint, mean.compute(list, pool), sums);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) return 2;
  const auto begin = std::chrono::steady_clock::now();
  const MpiSession session(argc, argv);
  const auto cpu_s = [] { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  std::vector<std::int64_t> sizes;
  for (const std::string& size : split(argv[1], 'x')) sizes.push_back(std::stoll(size));
  const Extents extents(sizes);
  FilterSpec filter{std::string(argv[2]) == "sum" ? Combine::sum : Combine::product, {}};
  ConstructSpec spec;
  std::uint64_t seed = 1;
  int threads = 1;
  int strata_axis = 0;
  SampleScale scale = SampleScale::line;
  for (int i = 3; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--circle") {
      scale = SampleScale::circle;
    } else if (word == "--sharpness") {
      spec.sharpness = std::stod(argv[++i]);
    } else if (word == "--density") {
      spec.density = std::stod(argv[++i]);
    } else if (word == "--threads") {
      threads = std::stoi(argv[++i]);
    } else if (word == "--time-strata") {
      strata_axis = extents.axis(argv[++i]);
    } else if (word == "--seed") {
      seed = std::stoull(argv[++i]);
    } else {
      filter.groups.push_back(group_of(word, extents));
    }
  }
  const Communicator world = Communicator::world();
  if (spec.sharpness == 0) {
    const double before_s = cpu_s();
    const std::vector<SharpnessTrial> trials = try_sharpness(extents, filter, scale);
    spec.sharpness = best_sharpness(trials);
    if (world.is_root()) {
      std::printf("sharpness %.1f in %.3f s:", spec.sharpness, cpu_s() - before_s);
      for (const SharpnessTrial& trial : trials) std::printf(" %.1f R %.5f", trial.sharpness, trial.relative_error);
      std::printf("\n");
    }
  }
  ThreadPool pool(threads);
  if (strata_axis != 0) {
    struct Made {
      std::vector<std::vector<std::uint32_t>> all;
      const std::vector<std::uint32_t>& places(SliceIndex slice) const { return all[static_cast<std::size_t>(slice)]; }
    };
    const double before_s = cpu_s();
    const Made made{time_strata(extents, filter, strata_axis, spec.sharpness, seed)};
    std::printf("%s: %.3f s; R %.5f\n", argv[1], cpu_s() - before_s,
                score(made, extents, filter, DistanceKind::absolute, pool));
    return 0;
  }
  SliceConstruction run(Footprint(extents, filter), filter, scale, spec, seed, world, pool);
  run.start();
  const double started_s = cpu_s();
  while (run.progress().phase < ConstructPhase::fill) run.advance();
  const double filling_s = cpu_s();
  while (!run.done()) run.advance();
  const double end_s = cpu_s();
  const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::int64_t fingerprint = 0;
  for (const SliceIndex s : run.distribution().own_slices()) {
    std::uint64_t hash = static_cast<std::uint64_t>(s) + 0xCBF29CE484222325U;
    for (const std::uint32_t place : run.places(s)) hash = (hash ^ place) * 0x100000001B3U;
    fingerprint += static_cast<std::int64_t>(hash >> 32);
  }
  world.sum(std::span(&fingerprint, 1));
  if (!world.is_root()) return 0;
  const auto pixels = static_cast<double>(extents.num_cells());
  std::printf(
      "%s: start %.3f s, relax and drain %.3f s, fill %.3f s; processor of rank 0 %.3f s, elapsed %.3f s, %.3f us a "
      "pixel",
      argv[1], started_s, filling_s - started_s, end_s - filling_s, end_s, elapsed_s, 1e6 * end_s / pixels);
  std::printf("; %lld swaps, %lld classes, fingerprint %08x", static_cast<long long>(run.progress().num_swaps),
              static_cast<long long>(run.num_classes()), static_cast<unsigned>(fingerprint));
  if (world.size() == 1)
    std::printf("; R %.5f", score(run, extents, filter,
                                  scale == SampleScale::line ? DistanceKind::absolute : DistanceKind::circle, pool));
  std::printf("\n");
  return 0;
}
