// Candidates per second of the swap delta by sample space and footprint: the vectorised path, and the plain one in
// double that it is a ratio to (with an EMA the plain one takes all taps and the other features for other slices). One
// slice of 128x128, bound once; pairs drawn uniformly. For single slices also how near that comes to two limits of the
// machine, measured in the same run (machine_limits.h): the arithmetic alone, and all cache lines coming from the
// second cache.
//   anneal_bench [--benchmark_filter=...]     items_per_second is candidates/s; ends in a table of ratios
#include <benchmark/benchmark.h>

#include <map>
#include <numeric>
#include <string>

#include "anneal/fields/tap_plan.h"
#include "bench/machine_limits.h"
#include "bench/ratio_table.h"
#include "noiseloom/anneal/slice_mover.h"
#include "noiseloom/core/random.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

constexpr std::int64_t size = 128;

const std::map<std::string, std::string>& spaces() {
  static const std::map<std::string, std::string> table{{"scalar", "uniform"},
                                                        {"circle", "circle"},
                                                        {"vector2", "vector2"},
                                                        {"vector4", "vector4"},
                                                        {"sphere", "sphere"}};
  return table;
}

const std::map<std::string, KernelSpec>& kernels() {
  static const std::map<std::string, KernelSpec> table = [] {
    std::map<std::string, KernelSpec> kernels;
    kernels["box3"].size = 3;
    kernels["box5"].size = 5;
    kernels["gauss1.0"].kind = kernels["gauss1.34"].kind = KernelKind::gauss;
    kernels["gauss1.34"].sigma = 1.3435;
    return kernels;
  }();
  return table;
}

// Candidates a second if there were nothing but the arithmetic, or nothing but lines from the second cache. A block of
// 16 samples at any alignment touches 31/16 lines on average; each half of a split one 23/16.
void set_limits(benchmark::State& state, const Footprint& footprint, const FieldLayout& layout,
                const ValueKernel& kernel) {
  const PlanePlan plan = plan_plane(footprint.slices()[0].taps, layout.stride, layout.height + 2 * layout.reach_y);
  const auto full = static_cast<double>(plan.rows.full.size() + plan.columns.full.size());
  const auto split = static_cast<double>(plan.rows.split.size() + plan.columns.split.size());
  const double lines = 2 * kernel.channels * (full * 31 / 16 + split * 2 * 23 / 16);
  state.counters["arithmetic_limit"] = 1 / ((full + split) * seconds_per_block(kernel));
  state.counters["cache_limit"] = 1 / (lines * seconds_per_line());
}

// One slice, or 16 with an EMA over them.
void judge(benchmark::State& state, const std::string& space, const KernelSpec& kernel, Precision precision,
           std::int32_t num_slices) {
  ProblemSpec problem;
  problem.extents = num_slices == 1 ? Extents({size, size}) : Extents({size, size, num_slices});
  problem.samples.space = space;
  problem.filter.groups.push_back({{0, 1}, kernel, 0});
  if (num_slices > 1) {
    KernelSpec ema;
    ema.kind = KernelKind::ema;
    problem.filter.groups.push_back({{2}, ema, 0});
  }
  const SampleSource source(problem.samples, size * size, num_slices, problem.seed);
  const Footprint footprint(problem.extents, problem.filter);
  const ValueKernel value_kernel = make_value_kernel(problem, source.channels(), source.distance());
  std::vector<SliceField> fields;
  for (const SliceIndex slice : first_indices<SliceIndex>(num_slices)) {
    fields.emplace_back(FieldLayout(footprint, source.channels()));
    fields.back().fill(start_permutation(problem.seed, slice, size * size), source.list(slice));
  }
  const bool by_features = num_slices > 1 && precision == Precision::float32;
  const FeatureMap map(value_kernel, 16, source.list(SliceIndex(0)));
  const auto delta = make_swap_delta(footprint, value_kernel, precision, by_features ? &map : nullptr);
  delta->bind(SliceIndex(0), fields[0],
              [&](SliceIndex slice) -> const SliceField& { return fields[static_cast<std::size_t>(slice)]; });

  std::vector<CellPair> pairs;
  for (std::uint64_t k = 0; k < 4096; ++k) {
    const RandomBlock bits = random_block(1, Purpose::proposal, 0, 0, k);
    pairs.push_back({to_below(bits[0], size * size), to_below(bits[1], size * size)});
  }
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(delta->delta(pairs[next]));
    next = (next + 1) % pairs.size();
  }
  state.SetItemsProcessed(state.iterations());
  if (num_slices == 1 && precision == Precision::float32) {
    set_limits(state, footprint, fields[0].layout(), value_kernel);
  }
}

// What the swaps of others cost a rank or a thread: two samples change places somewhere in a slice of 1024x1024.
void carry_out(benchmark::State& state) {
  ProblemSpec problem;
  problem.extents = Extents({1024, 1024});
  problem.filter.groups.push_back({{0, 1}, kernels().at("gauss1.0"), 0});
  SliceField field(FieldLayout(Footprint(problem.extents, problem.filter), 2));
  std::uint64_t next = 0;
  std::vector<Swap> swaps;
  for (std::uint64_t k = 0; k < 1 << 16; ++k) {
    const RandomBlock bits = random_block(1, Purpose::proposal, 0, 0, k);
    swaps.push_back({to_below(bits[0], 1 << 20), to_below(bits[1], 1 << 20)});
  }
  for (auto _ : state) {
    const Swap swap = swaps[next++ % swaps.size()];
    field.swap(swap.a, swap.b);
  }
}

void register_all() {
  benchmark::RegisterBenchmark("carry_out/vector2", carry_out);
  for (const auto& [space_name, space] : spaces()) {
    for (const auto& [kernel_name, kernel] : kernels()) {
      for (const auto& [precision_name, precision] :
           {std::pair<std::string, Precision>{"float", Precision::float32}, {"double", Precision::float64}}) {
        for (const std::int32_t num_slices : {1, 16}) {
          const std::string coupling = num_slices > 1 ? "/ema16" : "";
          const std::string name = space_name + "/" + kernel_name + coupling + "/" + precision_name;
          benchmark::RegisterBenchmark(name.c_str(), judge, space, kernel, precision, num_slices);
        }
      }
    }
  }
}

}  // namespace
}  // namespace noiseloom

int main(int argc, char** argv) {
  noiseloom::register_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  noiseloom::RatioTable table;
  benchmark::RunSpecifiedBenchmarks(&table);
}
