#include "anneal/deltas/background_simd.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "anneal/deltas/background_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "anneal/fields/simd_kernels-inl.h"

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

// use(k, e_k) for k = 1..max_degree, where e_k is cos(k t) or sin(k t): e_k = 2 cos(t) e_(k-1) - e_(k-2).
template <class Use>
HWY_INLINE void recur(int max_degree, V twice_cosine, V zeroth, V first, const Use& use) {
  for (int k = 1; k <= max_degree; ++k) {
    use(k, first);
    const V next = hn::Sub(hn::Mul(twice_cosine, first), zeroth);
    zeroth = first;
    first = next;
  }
}

// The cosine at degree 1 of a basis of cosines.
HWY_INLINE V first_cosine(const FeatureMap& map, int c, V x) {
  const V inside = hn::Mul(hn::Sub(x, set(map.low(c))), set(map.inverse_width(c)));
  return hn::Neg(minus_cosine(hn::Min(hn::Max(inside, set(0)), set(1))));
}

// Tables of the samples at `samples`: entry e at tables + e * block_lanes.
HWY_INLINE void fill_tables(const FeatureMap& map, const float* samples, std::int64_t plane_size, float* tables) {
  const std::size_t table_size = static_cast<std::size_t>(map.max_degree() + 1) * block_lanes;
  const auto store_in = [](float* table) {
    return [table](int k, V value) { hn::StoreU(value, Floats(), table + static_cast<std::size_t>(k) * block_lanes); };
  };
  if (map.basis() == FeatureMap::Basis::circle) {
    const V c = minus_cosine(hn::LoadU(Floats(), samples));  // of half the angle; its sine is positive
    const V s = hn::Sqrt(hn::Max(hn::Sub(set(1), hn::Mul(c, c)), set(0)));
    const V cosine = hn::Sub(hn::Mul(hn::Add(c, c), c), set(1));
    const V sine = hn::Neg(hn::Mul(hn::Add(s, s), c));
    const V twice = hn::Add(cosine, cosine);
    recur(map.max_degree(), twice, set(1), cosine, store_in(tables));
    recur(map.max_degree(), twice, set(0), sine, store_in(tables + table_size));
    return;
  }
  for (int t = 0; t < map.num_tables(); ++t, tables += table_size) {
    const V x = hn::LoadU(Floats(), samples + t * plane_size);
    if (map.basis() == FeatureMap::Basis::cosines) {
      const V cosine = first_cosine(map, t, x);
      recur(map.max_degree(), hn::Add(cosine, cosine), set(1), cosine, store_in(tables));
    } else {
      V power = x;
      for (int k = 1; k <= map.max_degree(); ++k) {
        store_in(tables)(k, power);
        power = hn::Mul(power, x);
      }
    }
  }
}

constexpr std::size_t run_cells = 8 * block_lanes;

// sums[n * run_cells] += weight f_n of the samples in one vector.
class FeatureAdder {
 public:
  FeatureAdder(const FeatureMap& map, std::int64_t plane_size)
      : map_(map),
        plane_size_(plane_size),
        factors_(factors_of(map)),
        tables_(static_cast<std::size_t>(map.num_tables() * (map.max_degree() + 1)) * block_lanes) {}

  HWY_INLINE void add(const float* samples, V weight, float* sums) {
    if (map_.basis() == FeatureMap::Basis::cosines && map_.num_tables() == 1) {
      // Feature n is degree n + 1 alone; the recurrence carries the weight.
      const V cosine = first_cosine(map_, 0, hn::LoadU(Floats(), samples));
      recur(map_.max_degree(), hn::Add(cosine, cosine), weight, hn::Mul(weight, cosine), [sums](int k, V value) {
        float* sum = sums + static_cast<std::size_t>(k - 1) * run_cells;
        hn::StoreU(hn::Add(hn::LoadU(Floats(), sum), value), Floats(), sum);
      });
      return;
    }
    fill_tables(map_, samples, plane_size_, tables_.data());
    for (const Factors& factors : factors_) {
      V value = weight;
      for (int k = 0; k < factors.count; ++k) value = hn::Mul(value, entry(factors.entry[k]));
      hn::StoreU(hn::Add(hn::LoadU(Floats(), sums), value), Floats(), sums);
      sums += run_cells;
    }
  }

 private:
  HWY_INLINE V entry(int e) const { return hn::LoadU(Floats(), &tables_[static_cast<std::size_t>(e) * block_lanes]); }

  const FeatureMap& map_;
  std::int64_t plane_size_;
  std::vector<Factors> factors_;
  std::vector<float> tables_;
};

// A run of cells at a time, so that its sums stay in the first cache and every field is read in long pieces.
void sum_features(const FeatureMap& map, const FieldLayout& layout, std::span<const WeightedField> fields,
                  float* sums) {
  const auto num_features = static_cast<std::size_t>(map.num_features());
  FeatureAdder adder(map, layout.plane_size);
  std::vector<float> run(num_features * run_cells);
  const std::int64_t border_x = layout.wraps_x ? 0 : layout.reach_x;
  const std::int64_t border_y = layout.wraps_y ? 0 : layout.reach_y;
  const std::int64_t end = layout.width + border_x;
  for (std::int64_t y = -border_y; y < layout.height + border_y; ++y) {
    for (std::int64_t x = -border_x; x < end; x += static_cast<std::int64_t>(run_cells)) {
      const std::int64_t at = layout.at(0) + y * layout.stride + x;
      const std::size_t blocks = (static_cast<std::size_t>(end - x) + block_lanes - 1) / block_lanes;
      const std::size_t cells = std::min(blocks * block_lanes, run_cells);
      std::fill(run.begin(), run.end(), 0.0F);
      for (const WeightedField& weighted : fields) {
        const float* samples = weighted.field->plane(0) + at;
        const V weight = set(weighted.weight);
        for (std::size_t lane = 0; lane < cells; lane += vector_lanes) adder.add(samples + lane, weight, &run[lane]);
      }
      for (std::size_t n = 0; n < num_features; ++n) {
        std::copy_n(&run[n * run_cells], cells, sums + static_cast<std::int64_t>(n) * layout.plane_size + at);
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
    const std::int64_t border_y = layout.wraps_y ? 0 : layout.reach_y;
    for (std::int64_t y = -border_y; y < layout.height + border_y && layout.wraps_x; ++y) {
      float* row = plane + layout.at(0) + y * layout.stride;
      std::copy_n(row + layout.width - layout.reach_x, layout.reach_x, row - layout.reach_x);
      std::copy_n(row, layout.reach_x, row + layout.width);
    }
    const auto row = [&](std::int64_t y) { return plane + (y + layout.reach_y) * layout.stride; };
    for (std::int64_t y = 0; y < layout.reach_y && layout.wraps_y; ++y) {
      std::copy_n(row(layout.height - layout.reach_y + y), layout.stride, row(y - layout.reach_y));
      std::copy_n(row(y), layout.stride, row(layout.height + y));
    }
  }
}

}  // namespace noiseloom
#endif
