// Whether points are a net: whether every elementary interval holds its share.
//
// An elementary interval in base 2 is a box of [0, 1)^s with the sides 2^-d1, ..., 2^-ds, at a multiple of each. n =
// 2^m points are a (t, m, s)-net if every one of volume 2^(t - m) holds exactly 2^t of them [Niederreiter92]. The least
// t is the quality: 0 is best, m says nothing.
#pragma once

#include <optional>
#include <span>
#include <string>

namespace noiseloom {

// The least t of points of `channels` numbers each, interleaved; nothing where their number is no power of two. Numbers
// outside of [0, 1) are counted at its ends. Time: n times the number of shapes of intervals, (m - t + s - 1 over s -
// 1).
std::optional<int> net_quality(std::span<const float> points, int channels);

}  // namespace noiseloom
