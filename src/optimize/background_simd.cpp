#include "optimize/background_simd.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "optimize/background_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "optimize/simd_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::HWY_NAMESPACE {

// The table entries of a feature, degree 0 left out; table t, degree k is entry t * (max_degree + 1) + k.
struct Factors {
  int count = 0;
  int entry[FeatureMap::max_factors] = {};
};

std::vector<Factors> factors_of(const FeatureMap& map) {
  std::vector<Factors> all(static_cast<std::size_t>(map.num_features()));
  for (int n = 0; n < map.num_features(); ++n) {
    Factors& factors = all[static_cast<std::size_t>(n)];
    for (int t = 0; t < map.num_tables(); ++t) {
      if (map.degree(n, t) > 0) factors.entry[factors.count++] = t * (map.max_degree() + 1) + map.degree(n, t);
    }
  }
  return all;
}

// -cos(pi x) for x in [0, 1]: the sine of pi (x - 1/2) by its Taylor series of degree 11, absolute error below 3e-7.
HWY_INLINE V minus_cosine(V x) {
  constexpr float coefficients[] = {-0.0073704309F, 0.0821458866F,  -0.5992645293F,
                                    2.5501640399F,  -5.1677127800F, 3.1415926536F};
  const V y = hn::Sub(x, set(0.5F));
  return hn::Mul(y, polynomial(hn::Mul(y, y), coefficients));
}

// Degrees 2.. of cos(k t) or sin(k t) from degrees 0 and 1: e_k = 2 cos(t) e_(k-1) - e_(k-2).
HWY_INLINE void recur(float* table, int max_degree, V twice_cosine, V zeroth, V first) {
  hn::StoreU(first, Floats(), table + block_lanes);
  for (int k = 2; k <= max_degree; ++k) {
    const V next = hn::Sub(hn::Mul(twice_cosine, first), zeroth);
    hn::StoreU(next, Floats(), table + static_cast<std::size_t>(k) * block_lanes);
    zeroth = first;
    first = next;
  }
}

// Tables of the samples at `cell` on: entry e at tables + e * block_lanes.
HWY_INLINE void fill_tables(const FeatureMap& map, const float* samples, std::int64_t plane_size, float* tables) {
  const std::size_t table_size = static_cast<std::size_t>(map.max_degree() + 1) * block_lanes;
  if (map.basis() == FeatureMap::Basis::circle) {
    const V c = minus_cosine(hn::LoadU(Floats(), samples));  // of half the angle; its sine is positive
    const V s = hn::Sqrt(hn::Max(hn::Sub(set(1), hn::Mul(c, c)), set(0)));
    const V cosine = hn::Sub(hn::Mul(hn::Add(c, c), c), set(1));
    const V sine = hn::Neg(hn::Mul(hn::Add(s, s), c));
    const V twice = hn::Add(cosine, cosine);
    recur(tables, map.max_degree(), twice, set(1), cosine);
    recur(tables + table_size, map.max_degree(), twice, set(0), sine);
    return;
  }
  for (int t = 0; t < map.num_tables(); ++t, tables += table_size) {
    const V x = hn::LoadU(Floats(), samples + t * plane_size);
    if (map.basis() == FeatureMap::Basis::cosines) {
      const V inside = hn::Mul(hn::Sub(x, set(map.low(t))), set(map.inverse_width(t)));
      const V cosine = hn::Neg(minus_cosine(hn::Min(hn::Max(inside, set(0)), set(1))));
      recur(tables, map.max_degree(), hn::Add(cosine, cosine), set(1), cosine);
    } else {
      V power = x;
      for (int k = 1; k <= map.max_degree(); ++k) {
        hn::StoreU(power, Floats(), tables + static_cast<std::size_t>(k) * block_lanes);
        power = hn::Mul(power, x);
      }
    }
  }
}

// One block of cells at a time, so that its sums stay in the first cache.
void sum_features(const FeatureMap& map, const FieldLayout& layout, std::span<const WeightedField> fields,
                  float* sums) {
  const std::vector<Factors> factors = factors_of(map);
  std::vector<float> tables(static_cast<std::size_t>(map.num_tables() * (map.max_degree() + 1)) * block_lanes);
  std::vector<float> block(factors.size() * block_lanes);
  for (std::int64_t y = 0; y < layout.height; ++y) {
    for (std::int64_t x = 0; x < layout.width; x += static_cast<std::int64_t>(block_lanes)) {
      const std::int64_t at = layout.at(y * layout.width) + x;
      std::fill(block.begin(), block.end(), 0.0F);
      for (std::size_t p = 0; p < num_parts; ++p) {
        const std::size_t lane = p * vector_lanes;
        for (const WeightedField& weighted : fields) {
          fill_tables(map, weighted.field->plane(0) + at + lane, layout.plane_size, tables.data());
          const V weight = set(weighted.weight);
          for (std::size_t n = 0; n < factors.size(); ++n) {
            V value = hn::Mul(
                weight, hn::LoadU(Floats(), &tables[static_cast<std::size_t>(factors[n].entry[0]) * block_lanes]));
            for (int k = 1; k < factors[n].count; ++k) {
              value = hn::Mul(
                  value, hn::LoadU(Floats(), &tables[static_cast<std::size_t>(factors[n].entry[k]) * block_lanes]));
            }
            float* sum = &block[n * block_lanes + lane];
            hn::StoreU(hn::Add(hn::LoadU(Floats(), sum), value), Floats(), sum);
          }
        }
      }
      for (std::size_t n = 0; n < factors.size(); ++n) {
        std::copy_n(&block[n * block_lanes], block_lanes, sums + static_cast<std::int64_t>(n) * layout.plane_size + at);
      }
    }
  }
}

// out = sum_k weights[k] in[offsets[k]] over a run of cells.
HWY_INLINE void filter_run(std::span<const float> weights, const std::int64_t* offsets, const float* in, float* out,
                           std::int64_t length) {
  for (std::int64_t x = 0; x < length; x += static_cast<std::int64_t>(vector_lanes)) {
    V sum = hn::Zero(Floats());
    for (std::size_t k = 0; k < weights.size(); ++k) {
      sum = hn::Add(sum, hn::Mul(set(weights[k]), hn::LoadU(Floats(), in + x + offsets[k])));
    }
    hn::StoreU(sum, Floats(), out + x);
  }
}

const float* filter_planes(const Background::Filter& filter, const FieldLayout& layout, int count, float* in,
                           float* out) {
  const auto filter_rows = [&](std::span<const float> weights, const std::vector<std::int64_t>& offsets,
                               const float* from, float* to, std::int64_t first_row, std::int64_t last_row) {
    for (int n = 0; n < count; ++n) {
      for (std::int64_t row = first_row; row < last_row; ++row) {
        const std::int64_t at = n * layout.plane_size + layout.at(0) + row * layout.stride;
        filter_run(weights, offsets.data(), from + at, to + at, layout.width);
      }
    }
  };
  std::vector<std::int64_t> offsets;
  if (filter.along_x.empty()) {
    std::vector<float> weights;
    for (const PlaneTap& tap : filter.taps) {
      weights.push_back(static_cast<float>(tap.weight));
      offsets.push_back(tap.dy * layout.stride + tap.dx);
    }
    filter_rows(weights, offsets, in, out, 0, layout.height);
    return out;
  }
  for (std::int64_t d = -layout.reach_x; d <= layout.reach_x; ++d) offsets.push_back(d);
  filter_rows(filter.along_x, offsets, in, out, -layout.reach_y, layout.height + layout.reach_y);
  offsets.clear();
  for (std::int64_t d = -layout.reach_y; d <= layout.reach_y; ++d) offsets.push_back(d * layout.stride);
  filter_rows(filter.along_y, offsets, out, in, 0, layout.height);
  return in;
}

void gather_cells(const FieldLayout& layout, const float* matrix, int num_lanes, int count, const float* planes,
                  std::int64_t cell_stride, float* cells) {
  float block[block_lanes];
  for (std::int64_t y = 0; y < layout.height; ++y) {
    for (std::int64_t x = 0; x < layout.width; x += static_cast<std::int64_t>(block_lanes)) {
      const float* from = planes + layout.at(y * layout.width) + x;
      const std::int64_t length = std::min<std::int64_t>(block_lanes, layout.width - x);
      float* to = cells + (y * layout.width + x) * cell_stride;
      for (int m = 0; m < count; ++m) {
        const float* read = from + m * layout.plane_size;
        if (matrix != nullptr) {
          for (std::size_t lane = 0; lane < block_lanes; lane += vector_lanes) {
            V sum = hn::Zero(Floats());
            for (int n = 0; n < count; ++n) {
              const V value = hn::LoadU(Floats(), from + n * layout.plane_size + lane);
              sum = hn::Add(sum, hn::Mul(set(matrix[m * num_lanes + n]), value));
            }
            hn::StoreU(sum, Floats(), block + lane);
          }
          read = block;
        }
        for (std::int64_t k = 0; k < length; ++k) to[k * cell_stride + m] = read[k];
      }
    }
  }
}

}  // namespace noiseloom::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace noiseloom {

HWY_EXPORT(sum_features);
HWY_EXPORT(filter_planes);
HWY_EXPORT(gather_cells);

void sum_features(const FeatureMap& map, const FieldLayout& layout, std::span<const WeightedField> fields,
                  float* sums) {
  HWY_DYNAMIC_DISPATCH(sum_features)(map, layout, fields, sums);
}

const float* filter_planes(const Background::Filter& filter, const FieldLayout& layout, int count, float* in,
                           float* out) {
  return HWY_DYNAMIC_DISPATCH(filter_planes)(filter, layout, count, in, out);
}

void gather_cells(const FieldLayout& layout, const float* matrix, int num_lanes, int count, const float* planes,
                  std::int64_t cell_stride, float* cells) {
  HWY_DYNAMIC_DISPATCH(gather_cells)(layout, matrix, num_lanes, count, planes, cell_stride, cells);
}

void fill_borders(const FieldLayout& layout, int count, float* planes) {
  for (int n = 0; n < count; ++n) {
    float* plane = planes + n * layout.plane_size;
    for (std::int64_t y = 0; y < layout.height; ++y) {
      float* row = plane + layout.at(y * layout.width);
      std::copy_n(row + layout.width - layout.reach_x, layout.reach_x, row - layout.reach_x);
      std::copy_n(row, layout.reach_x, row + layout.width);
    }
    const auto row = [&](std::int64_t y) { return plane + (y + layout.reach_y) * layout.stride; };
    for (std::int64_t y = 0; y < layout.reach_y; ++y) {
      std::copy_n(row(layout.height - layout.reach_y + y), layout.stride, row(y - layout.reach_y));
      std::copy_n(row(y), layout.stride, row(layout.height + y));
    }
  }
}

}  // namespace noiseloom
#endif
