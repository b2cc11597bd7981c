// The loops of Background over planes, vectorised; the same bits on every instruction set. A plane set holds one plane
// of FieldLayout for each feature, `layout.plane_size` apart; whole blocks of 16 cells may be written past a row's end.
#pragma once

#include <span>

#include "anneal/deltas/background.h"

namespace noiseloom {

// sums[n] = sum over fields of weight f_n(sample), for all cells, and for the border along axes that do not wrap.
void sum_features(const FeatureMap& map, const FieldLayout& layout, std::span<const WeightedField> fields, float* sums);

// Repeats the torus in the border of `count` planes, along axes that wrap.
void fill_borders(const FieldLayout& layout, int count, float* planes);

// plane * in, for `count` planes with filled borders; returned in either `in` or `out`.
const float* filter_planes(const Background::Filter& filter, const FieldLayout& layout, int count, float* in,
                           float* out);

// cells[cell * cell_stride + m] = sum_n matrix[m * num_lanes + n] planes[n], m < num_lanes, n < count. Without a
// matrix: plane m itself, zero from `count` on.
void gather_cells(const FieldLayout& layout, const float* matrix, int num_lanes, int count, const float* planes,
                  std::int64_t cell_stride, float* cells);

}  // namespace noiseloom
