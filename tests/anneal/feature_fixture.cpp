#include "anneal/feature_fixture.h"

#include <array>
#include <map>
#include <memory>
#include <numeric>
#include <utility>

namespace noiseloom::test {

std::vector<float> samples_of(const Texture& texture, int slices) {
  std::vector<float> list;
  for (const SliceIndex slice : first_indices<SliceIndex>(slices)) {
    const SliceField& field = texture.field(slice);
    std::vector<float> values(field.planar().size());
    field.interleaved(values);
    list.insert(list.end(), values.begin(), values.end());
  }
  return list;
}

PairKernel full_kernel(const ValueKernel& kernel) {
  return [kernel](const float* a, const float* b) { return oracle_kernel(kernel, a, b); };
}

PairKernel kernel_by_features(const FeatureMap& map, int channels) {
  struct Known {
    std::vector<double> features;
    std::vector<double> mixed;
  };
  // Every sample is asked for again and again.
  const auto all = std::make_shared<std::map<std::vector<float>, Known>>();
  const auto known = [&map, channels, all](const float* sample) -> const Known& {
    const auto [place, is_new] = all->try_emplace(std::vector<float>(sample, sample + channels));
    if (is_new) {
      const std::vector<double> f = map.features(sample);
      std::vector<double> mixed(f.size());
      for (std::size_t i = 0; i < f.size(); ++i) {
        for (std::size_t j = 0; j < f.size(); ++j) mixed[i] += map.mixing()[i * f.size() + j] * f[j];
      }
      place->second = {f, mixed};
    }
    return place->second;
  };
  return [known](const float* a, const float* b) {
    const std::vector<double>& of_a = known(a).features;
    const std::vector<double>& of_b = known(b).mixed;
    return std::inner_product(of_a.begin(), of_a.end(), of_b.begin(), 0.0);
  };
}

double change_by(std::span<const SliceTaps> slices, const Extents& extents, const Texture& texture, SliceIndex slice,
                 CellPair pair, const PairKernel& kernel, const Texture* around) {
  const auto value = [](const Texture& of, SliceIndex s, Cell cell) {
    std::array<float, 8> sample{};
    of.field(s).get(cell, sample.data());
    return sample;
  };
  const auto a = value(texture, slice, pair.i);
  const auto b = value(texture, slice, pair.j);
  double sum = 0;
  for (const SliceTaps& taps : slices) {
    for (const PlaneTap& tap : taps.taps) {
      for (const auto& [centre, sign] : {std::pair{Cell{pair.i}, 1.0}, {Cell{pair.j}, -1.0}}) {
        const std::int64_t x = (centre % extents.width() + tap.dx + extents.width()) % extents.width();
        const std::int64_t y = (centre / extents.width() + tap.dy + extents.height()) % extents.height();
        const Texture& others = around != nullptr ? *around : texture;
        const auto s = value(others, extents.slice_at(slice, taps.offset), x + extents.width() * y);
        sum += sign * tap.weight * (kernel(b.data(), s.data()) - kernel(a.data(), s.data()));
      }
    }
  }
  return 2 * sum;
}

double share_wrong(const ValueKernel& kernel, const FeatureMap& map, const std::vector<float>& list) {
  const auto channels = static_cast<std::size_t>(kernel.channels);
  const std::size_t n = list.size() / channels;
  const auto count = static_cast<std::size_t>(map.num_features());
  std::vector<std::vector<double>> features;
  std::vector<double> mean(count);
  for (std::size_t k = 0; k < n; ++k) {
    features.push_back(map.features(&list[k * channels]));
    for (std::size_t i = 0; i < count; ++i) mean[i] += features.back()[i] / static_cast<double>(n);
  }
  for (auto& row : features) {
    for (std::size_t i = 0; i < count; ++i) row[i] -= mean[i];
  }
  std::vector<double> values(n * n);
  std::vector<double> rows(n);
  double all = 0;
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = 0; b < n; ++b) {
      values[a * n + b] = kernel(&list[a * channels], &list[b * channels]);
      rows[a] += values[a * n + b] / static_cast<double>(n);
    }
    all += rows[a] / static_cast<double>(n);
  }
  double wrong = 0;
  double total = 0;
  for (std::size_t a = 0; a < n; ++a) {
    std::vector<double> mixed(count);
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < count; ++j) mixed[j] += features[a][i] * map.mixing()[i * count + j];
    }
    for (std::size_t b = 0; b < n; ++b) {
      const double centred = values[a * n + b] - rows[a] - rows[b] + all;
      double modelled = 0;
      for (std::size_t j = 0; j < count; ++j) modelled += mixed[j] * features[b][j];
      wrong += (modelled - centred) * (modelled - centred);
      total += centred * centred;
    }
  }
  return wrong / total;
}

}  // namespace noiseloom::test
