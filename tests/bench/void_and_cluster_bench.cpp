// Times void and cluster on one thread (processor time), start-up included.
//   void_and_cluster_bench SIZES GROUPS [SEED]     e.g. 64x64x16x16 xy+zw       axes: x y z w v u s t in that order
// With a fourth argument, writes the ranks there as raw little-endian uint32.
#include <cstdio>
#include <ctime>
#include <fstream>
#include <sstream>
#include <string>

#include "noiseloom/optimize/void_and_cluster.h"

using namespace noiseloom;

namespace {

VacSpec parse(const std::string& sizes, const std::string& groups) {
  std::vector<std::int64_t> extents;
  std::stringstream size_list(sizes);
  for (std::string size; std::getline(size_list, size, 'x');) extents.push_back(std::stoll(size));
  VacSpec spec{Extents(extents), {}, {}};
  std::stringstream group_list(groups);
  for (std::string axes; std::getline(group_list, axes, '+');) {
    VacGroup group;
    for (const char axis : axes) group.axes.push_back(static_cast<int>(std::string("xyzwvust").find(axis)));
    spec.groups.push_back(group);
  }
  return spec;
}

}  // namespace

int main(int argc, char** argv) {
  const MpiSession session(argc, argv);
  if (argc < 3) return 2;
  const auto seconds = [] { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  VacSpec spec = parse(argv[1], argv[2]);
  if (argc > 3) spec.seed = std::stoull(argv[3]);
  const Communicator alone = Communicator::self();
  ThreadPool pool(1);
  VoidAndCluster run(spec, alone, pool);
  run.start();
  double last = 0;
  const char* names[] = {"swap", "drain", "fill"};
  std::printf("%s %s: start %.3f s", argv[1], argv[2], last = seconds());
  while (!run.done()) {
    const VacPhase phase = run.progress().phase;
    while (run.progress().phase == phase) run.advance(1024 + spec.extents.num_cells() / 64);
    std::printf(", %s %.3f s", names[static_cast<int>(phase)], seconds() - last);
    last = seconds();
  }
  const auto pixels = static_cast<double>(spec.extents.num_cells());
  std::printf(", %.2f swaps a point, all %.3f s, %.3f us a pixel\n",
              static_cast<double>(run.progress().num_swaps) / static_cast<double>(run.progress().num_start_points),
              last, 1e6 * last / pixels);
  if (argc > 4) {
    std::ofstream out(argv[4], std::ios::binary);
    for (SliceIndex slice = 0; slice < spec.extents.num_slices(); ++slice) {
      const auto ranks = run.order(slice);
      out.write(reinterpret_cast<const char*>(ranks.data()), static_cast<std::streamsize>(ranks.size()));
    }
  }
}
