// The vector loops of PlaneField, compiled for every instruction set and chosen at run time. Integers only, so the
// width of the vectors cannot change a result.
#pragma once

#include <cstdint>
#include <span>

#include "construct/fields/vac_field.h"
#include "construct/stamp_kernel.h"

namespace noiseloom::plane_simd {

constexpr std::size_t leaf_words = 64;

struct Shape {
  std::int64_t width;
  std::int64_t height;
};

// Adds (on) or subtracts (off) the stamp around every cell. `words`: the plane, with a vector behind it.
void add_stamps(Shape shape, const SliceStamp& stamp, const std::uint32_t* weights, std::uint32_t* words, bool on,
                std::span<const std::uint32_t> cells);

// The smallest value of each leaf. `words` holds whole leaves.
void leaf_minima(const std::uint32_t* words, std::size_t num_leaves, VacView view, std::uint32_t* minima);

// The smallest of 64 values.
std::uint32_t least_of_leaf(const std::uint32_t* words, VacView view);
// The smallest of `count` words; `count` is a multiple of 16.
std::uint32_t least_of(const std::uint32_t* words, std::size_t count);

}  // namespace noiseloom::plane_simd
