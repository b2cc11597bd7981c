#include "samples/mapped_space.h"

#include <algorithm>
#include <array>

#include "noiseloom/core/error.h"
#include "noiseloom/core/random.h"

namespace noiseloom {

Box unit_box(int dimensions) {
  Box box;
  box.dimensions = static_cast<std::size_t>(dimensions);
  NOISELOOM_CHECK_LE(box.dimensions, max_dimensions);
  box.high.fill(1);
  return box;
}

// Rounding may carry a sample over the border of its stratum; then the jitter is drawn towards the middle, where there
// is room for it.
void MappedSpace::sample_in(const Box& box, const double* jitter, float* sample) const {
  const int channels = traits().channels;
  for (const double keep : {1.0, 0.984375, 0.875, 0.0}) {
    std::array<double, max_dimensions> u;
    std::array<double, max_dimensions> exact;
    for (std::size_t axis = 0; axis < box.dimensions; ++axis) {
      const double at = 0.5 + keep * (jitter[axis] - 0.5);
      u[axis] = box.low[axis] + (box.high[axis] - box.low[axis]) * at;
    }
    map_.to_sample(channels, u.data(), exact.data());
    std::transform(exact.data(), exact.data() + channels, sample, [](double x) { return static_cast<float>(x); });
    map_.to_domain(channels, sample, u.data());
    if (box.contains(u.data()) && map_.contains(sample)) return;
  }
}

void MappedSpace::sample(std::int64_t n, std::int64_t id, const double* jitter, float* sample) const {
  NOISELOOM_CHECK(id >= 0 && id < n);
  sample_in(Strata(map_.domain, n).box(id), jitter, sample);
}

void MappedSpace::list(std::int64_t n, const JitterOf& jitter, float* samples) const {
  std::array<double, max_dimensions> at{};
  Strata(map_.domain, n).for_each([&](std::int64_t id, const Box& box) {
    jitter(id, at.data());
    sample_in(box, at.data(), samples);
    samples += traits().channels;
  });
}

std::int64_t MappedSpace::invert(std::int64_t n, const float* sample) const {
  std::array<double, max_dimensions> u;
  map_.to_domain(traits().channels, sample, u.data());
  return Strata(map_.domain, n).find(u.data());
}

double MappedSpace::share_below(int channel, double value) const {
  if (map_.share_below) return map_.share_below(channel, value);
  std::call_once(counted_, [this] {
    constexpr std::int64_t n = 1 << 16;  // jittered strata: the share is off by some 1e-4
    const auto channels = static_cast<std::size_t>(traits().channels);
    std::vector<float> samples(static_cast<std::size_t>(n) * channels);
    const auto jitter = [this](std::int64_t id, double* at) {
      for (int k = 0; k < traits().dimensions; ++k) {
        const RandomBlock bits =
            random_block(0, Purpose::jitter, static_cast<std::uint32_t>(k), 1, static_cast<std::uint64_t>(id));
        at[k] = to_unit_double(bits[0], bits[1]);
      }
    };
    list(n, jitter, samples.data());
    coordinates_.resize(channels);
    for (std::size_t i = 0; i < samples.size(); ++i) coordinates_[i % channels].push_back(samples[i]);
    for (std::vector<float>& ascending : coordinates_) std::sort(ascending.begin(), ascending.end());
  });
  const std::vector<float>& ascending = coordinates_[static_cast<std::size_t>(channel)];
  const auto below = std::partition_point(ascending.begin(), ascending.end(),
                                          [value](float x) { return static_cast<double>(x) < value; });
  return static_cast<double>(below - ascending.begin()) / static_cast<double>(ascending.size());
}

}  // namespace noiseloom
