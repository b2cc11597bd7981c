#include "construct/plane_simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "construct/plane_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "construct/fields/rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::plane_simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using rows::HWY_NAMESPACE::add_row;
using rows::HWY_NAMESPACE::Adder;
using rows::HWY_NAMESPACE::Lanes;

template <bool On>
HWY_INLINE void add_narrow(std::int64_t width, const SliceStamp& stamp, const std::uint32_t* weights,
                           std::uint32_t* words) {
  const Lanes d;
  const Adder<On> add;
  for (const StampRow& row : stamp.rows) {
    std::uint32_t* const begin = words + row.dy * width - stamp.left;
    for (std::size_t i = 0; i < StampKernel::vector_words; i += hn::Lanes(d)) {
      add(d, begin + i, hn::LoadU(d, weights + row.first + i));
    }
  }
}

template <bool On>
HWY_INLINE void add_all(Shape shape, const SliceStamp& stamp, const std::uint32_t* weights, std::uint32_t* words,
                        std::span<const std::uint32_t> cells) {
  const std::int64_t width = shape.width;
  for (const std::uint32_t cell : cells) {
    const std::int64_t x = cell % static_cast<std::uint32_t>(width);
    const std::int64_t y = cell / static_cast<std::uint32_t>(width);
    const bool inside = x >= stamp.left && x + stamp.right < width && y >= stamp.up && y + stamp.down < shape.height;
    if (inside && stamp.is_narrow) {
      add_narrow<On>(width, stamp, weights, words + cell);
      continue;
    }
    for (const StampRow& row : stamp.rows) {
      std::int64_t line = y + row.dy;
      line += line < 0 ? shape.height : line >= shape.height ? -shape.height : 0;
      add_row(width, true, row.lo, row.hi, weights + row.first, Adder<On>{}, x, words + line * width);
    }
  }
}

void AddStamps(Shape shape, const SliceStamp& stamp, const std::uint32_t* weights, std::uint32_t* words, bool on,
               std::span<const std::uint32_t> cells) {
  if (on) {
    add_all<true>(shape, stamp, weights, words, cells);
  } else {
    add_all<false>(shape, stamp, weights, words, cells);
  }
}

HWY_INLINE std::uint32_t least(const std::uint32_t* words, std::size_t count, std::uint32_t view) {
  const Lanes d;
  const auto flip = hn::Set(d, view);
  auto result = hn::Set(d, ~std::uint32_t{0});
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    result = hn::Min(result, hn::Xor(hn::LoadU(d, words + i), flip));
  }
  return hn::GetLane(hn::MinOfLanes(d, result));
}

void LeafMinima(const std::uint32_t* words, std::size_t num_leaves, VacView view, std::uint32_t* minima) {
  for (std::size_t leaf = 0; leaf < num_leaves; ++leaf) {
    minima[leaf] = least(words + leaf * leaf_words, leaf_words, static_cast<std::uint32_t>(view));
  }
}

std::uint32_t LeastOfLeaf(const std::uint32_t* words, VacView view) {
  return least(words, leaf_words, static_cast<std::uint32_t>(view));
}

std::uint32_t LeastOf(const std::uint32_t* words, std::size_t count) { return least(words, count, 0); }

}  // namespace noiseloom::plane_simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace noiseloom::plane_simd {

HWY_EXPORT(AddStamps);
HWY_EXPORT(LeafMinima);
HWY_EXPORT(LeastOfLeaf);
HWY_EXPORT(LeastOf);

void add_stamps(Shape shape, const SliceStamp& stamp, const std::uint32_t* weights, std::uint32_t* words, bool on,
                std::span<const std::uint32_t> cells) {
  HWY_DYNAMIC_DISPATCH(AddStamps)(shape, stamp, weights, words, on, cells);
}

void leaf_minima(const std::uint32_t* words, std::size_t num_leaves, VacView view, std::uint32_t* minima) {
  HWY_DYNAMIC_DISPATCH(LeafMinima)(words, num_leaves, view, minima);
}

std::uint32_t least_of_leaf(const std::uint32_t* words, VacView view) {
  return HWY_DYNAMIC_DISPATCH(LeastOfLeaf)(words, view);
}

std::uint32_t least_of(const std::uint32_t* words, std::size_t count) {
  return HWY_DYNAMIC_DISPATCH(LeastOf)(words, count);
}

}  // namespace noiseloom::plane_simd
#endif
