// Times void and cluster, start-up included: processor seconds of rank 0 phase by phase, and elapsed seconds.
//   [mpirun -n RANKS] void_and_cluster_bench SIZES GROUPS [SEED [THREADS [DENSITY]]]
// e.g. 64x64x16x16 xy+zw, without an initial pattern unless DENSITY is given; axes: x y z w v u s t in that order. The
// fingerprint tells whether two runs gave the same order.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <limits>
#include <sstream>
#include <string>

#include "noiseloom/construct/void_and_cluster.h"
#include "noiseloom/core/error.h"

using namespace noiseloom;

namespace {

constexpr const char* axis_names = "xyzwvust";

template <class Number>
Number number_of(const std::string& what, const std::string& text, Number least, Number most) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value >= least && value <= most) return value;
  throw UserError("", fmt::format("{} is \"{}\": must be a number from {} to {}", what, text, least, most));
}

VacSpec parse(const std::string& sizes, const std::string& groups) {
  std::vector<std::int64_t> extents;
  std::stringstream size_list(sizes);
  for (std::string size; std::getline(size_list, size, 'x');) {
    extents.push_back(number_of<std::int64_t>("a size of " + sizes, size, 1, 1 << 20));
  }
  const std::string axes_present = std::string(axis_names).substr(0, extents.size());
  if (extents.size() < 2 || extents.size() > Extents::max_axes) {
    throw UserError("", fmt::format("SIZES is \"{}\": must be 2 to {} sizes, as in 64x64x16", sizes,
                                    static_cast<int>(Extents::max_axes)));
  }
  VacSpec spec{Extents(extents), {}, {}};
  std::stringstream group_list(groups);
  for (std::string axes; std::getline(group_list, axes, '+');) {
    VacGroup group;
    for (const char axis : axes) {
      const std::size_t index = axes_present.find(axis);
      if (index == std::string::npos) {
        throw UserError("", fmt::format("GROUPS is \"{}\": there is no axis {}; the axes of {} are {}", groups, axis,
                                        sizes, axes_present));
      }
      group.axes.push_back(static_cast<int>(index));
    }
    spec.groups.push_back(group);
  }
  return spec;
}

// The same for any number of ranks. *Collective*
std::uint32_t fingerprint(const VoidAndCluster& run, const Communicator& world) {
  std::int64_t sum = 0;
  const Partition& partition = run.partition();
  for (const SliceIndex slice : Distribution(partition, world.rank()).own_slices()) {
    std::uint64_t hash = static_cast<std::uint64_t>(slice) + 0xCBF29CE484222325U;
    for (const std::byte byte : run.order(slice)) hash = (hash ^ static_cast<std::uint64_t>(byte)) * 0x100000001B3U;
    sum += static_cast<std::int64_t>(hash >> 32);
  }
  world.sum(std::span(&sum, 1));
  return static_cast<std::uint32_t>(sum);
}

int run_bench(int argc, char** argv) {
  const auto begin = std::chrono::steady_clock::now();
  const MpiSession session(argc, argv);
  const auto seconds = [] { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  VacSpec spec = parse(argv[1], argv[2]);
  if (argc > 3) spec.seed = number_of<std::uint64_t>("SEED", argv[3], 0, std::numeric_limits<std::uint64_t>::max());
  spec.density = argc > 5 ? number_of("DENSITY", argv[5], 0.0, 0.5) : 0;
  const int threads = argc > 4 ? number_of("THREADS", argv[4], 1, 1024) : 1;
  check_vac_spec(spec);
  const Communicator world = Communicator::world();
  ThreadPool pool(threads);
  VoidAndCluster run(spec, world, pool);
  run.start();
  double last = seconds();
  const char* names[] = {"swap", "drain", "fill"};
  if (world.is_root()) std::printf("%s %s: start %.3f s", argv[1], argv[2], last);
  while (!run.done()) {
    const VacPhase phase = run.progress().phase;
    while (run.progress().phase == phase) run.advance(1024 + spec.extents.num_cells() / 64);
    if (world.is_root()) std::printf(", %s %.3f s", names[static_cast<int>(phase)], seconds() - last);
    last = seconds();
  }
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const std::uint32_t print = fingerprint(run, world);
  if (!world.is_root()) return 0;
  const auto pixels = static_cast<double>(spec.extents.num_cells());
  const auto picks = static_cast<double>(run.progress().num_swaps) + pixels;
  std::printf(", all %.3f s, %.3f us a pixel; elapsed %.3f s\n", last, 1e6 * last / pixels, elapsed);
  std::printf("%.2f swaps a point, %.5f collectives and %.2f bytes a pick and rank, fingerprint %08x\n",
              static_cast<double>(run.progress().num_swaps) /
                  static_cast<double>(std::max<std::int64_t>(1, run.progress().num_start_points)),
              static_cast<double>(run.collectives()) / picks, static_cast<double>(run.bytes_sent()) / picks, print);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3 || argc > 6) {
    std::fprintf(stderr, "usage: void_and_cluster_bench SIZES GROUPS [SEED [THREADS [DENSITY]]], e.g. 64x64x16 xy+z\n");
    return 2;
  }
  try {
    return run_bench(argc, argv);
  } catch (const UserError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
