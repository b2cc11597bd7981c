#include "anneal/texture_score.h"

#include <map>
#include <vector>

#include "noiseloom/problem/score.h"

namespace noiseloom {

double mean_distance(const SampleSource& source, const Communicator& communicator, ThreadPool& pool) {
  const MeanDistance mean(source.distance(), source.channels(), source.cells_per_slice(), source.num_slices());
  const Partition tasks(narrow<std::int32_t>(mean.num_tasks()), communicator.size());
  const std::int32_t begin = tasks.begin(communicator.rank());
  std::vector<double> own(static_cast<std::size_t>(tasks.count(communicator.rank())));
  pool.for_each(std::ssize(own), [&](std::int64_t index, int) {
    own[static_cast<std::size_t>(index)] =
        mean.run_task(begin + index, [&source](SliceIndex slice) { return source.list(slice); });
  });
  return mean.combine(communicator.gather_all(tasks, own));
}

namespace {

// What the terms of the first `num_own` slices add up to, in double.
std::vector<double> own_sums(const Footprint& footprint, const SampleSource& source,
                             const std::vector<SliceIndex>& held, std::int32_t num_own,
                             const std::function<std::vector<float>(SliceIndex)>& planar_of, ThreadPool& pool) {
  std::map<SliceIndex, std::vector<float>> planar;
  for (const SliceIndex slice : held) planar[slice];
  pool.for_each(std::ssize(held), [&](std::int64_t index, int) {
    const SliceIndex slice = held[static_cast<std::size_t>(index)];
    planar.at(slice) = planar_of(slice);
  });
  const auto values = [&planar](SliceIndex slice) { return planar.at(slice).data(); };
  std::vector<double> sums(static_cast<std::size_t>(num_own));
  pool.for_each(std::ssize(sums), [&](std::int64_t index, int) {
    const auto k = static_cast<std::size_t>(index);
    sums[k] = weighted_distance_sum(footprint, source.distance(), source.channels(), held[k], values, PairEnds::one);
  });
  return sums;
}

std::vector<double> own_sums(const FloatScore& in_float, const HeldSlices& slices, ThreadPool& pool) {
  const std::vector<SliceIndex> held = slices.indices();
  std::vector<double> sums(static_cast<std::size_t>(slices.num_own()));
  pool.for_each(std::ssize(sums), [&](std::int64_t index, int) {
    const auto k = static_cast<std::size_t>(index);
    sums[k] = in_float.slice_sum(held[k], slices.fields());
  });
  return sums;
}

}  // namespace

double texture_error(const Footprint& footprint, const SampleSource& source, double mean_distance,
                     const Distribution& distribution, const std::vector<SliceIndex>& held,
                     const std::function<std::vector<float>(SliceIndex)>& planar, const Communicator& communicator,
                     ThreadPool& pool) {
  const std::vector<double> own = own_sums(footprint, source, held, distribution.num_own(), planar, pool);
  return relative_error(footprint, mean_distance, communicator.gather_all(distribution.partition(), own));
}

double texture_error(const Footprint& footprint, const SampleSource& source, double mean_distance,
                     const HeldSlices& slices, const FloatScore* in_float, const Communicator& communicator,
                     ThreadPool& pool) {
  if (in_float != nullptr) {
    return relative_error(
        footprint, mean_distance,
        communicator.gather_all(slices.distribution().partition(), own_sums(*in_float, slices, pool)));
  }
  const auto planar = [&slices](SliceIndex slice) { return slices.field(slice).planar(); };
  return texture_error(footprint, source, mean_distance, slices.distribution(), slices.indices(), planar, communicator,
                       pool);  // own slices come first
}

}  // namespace noiseloom
