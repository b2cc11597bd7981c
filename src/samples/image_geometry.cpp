#include "samples/image_geometry.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "noiseloom/core/math.h"
#include "samples/disk_map.h"

namespace noiseloom {
namespace {

double square_of(double x) { return x * x; }

// arcsin, as the mathematics of this project has it.
double arc_sine(double x) { return 0.5 * math::pi - math::acos(x); }

// A position within [0, size], with its texel.
void place(double at, int size, std::size_t axis, TexelPoint& point) {
  point.texel[axis] =
      std::clamp(static_cast<int>(std::floor(std::clamp(at, 0.0, static_cast<double>(size)))), 0, size - 1);
  point.at[axis] = std::clamp(at, static_cast<double>(point.texel[axis]), std::nextafter(point.texel[axis] + 1.0, 0.0));
}

// Half the height of the unit disk at x.
double half_chord(double x) { return std::sqrt(std::max(0.0, (1 - x) * (1 + x))); }

// The integral of half_chord from 0 to x.
double chord_area(double x) { return 0.5 * (x * half_chord(x) + arc_sine(std::clamp(x, -1.0, 1.0))); }

// The integral over s from 0 to x of y clamped to the disk's extent at s, -half_chord(s) to half_chord(s).
double clamped_area(double x, double y) {
  const double height = std::fabs(y);
  const double at = std::clamp(x, -1.0, 1.0);
  const double reach = height < 1 ? half_chord(height) : 0;  // up to where the disk is as high as y
  const double inner = std::clamp(at, -reach, reach);
  const double area = height * inner + chord_area(at) - chord_area(inner);
  return y < 0 ? -area : area;
}

}  // namespace

class ImageGeometry::ClippedTexel {
 public:
  ClippedTexel(int x, int y, int width, int height)
      : left_(edge(x, width)), right_(edge(x + 1, width)), top_(edge(y, height)), bottom_(edge(y + 1, height)) {
    const double far_x = std::max(std::fabs(left_), std::fabs(right_));
    const double far_y = std::max(std::fabs(top_), std::fabs(bottom_));
    is_whole_ = far_x * far_x + far_y * far_y <= 1;
    const double near_x = std::max({0.0, left_, -right_});
    const double near_y = std::max({0.0, top_, -bottom_});
    const bool is_outside = near_x * near_x + near_y * near_y >= 1;  // rounding must not leave a trace of it
    area_ = is_whole_ ? (right_ - left_) * (bottom_ - top_) : is_outside ? 0 : std::max(0.0, area_until(right_));
  }

  bool is_whole() const { return is_whole_; }
  double area() const { return area_; }

  // Fractions of the texel, uniform in [0, 1)^2 -> a point of the clipped texel, uniform in that.
  void to_disk(double u, double v, double* sample) const {
    double low = left_;
    double high = right_;
    for (int step = 0; step < 60; ++step) {
      const double middle = 0.5 * (low + high);
      (area_until(middle) <= u * area_ ? low : high) = middle;
    }
    sample[0] = low;
    const double from = bounded(top_, low);
    sample[1] = from + v * (bounded(bottom_, low) - from);
  }
  void from_disk(double x, double y, double& u, double& v) const {
    u = area_ > 0 ? area_until(x) / area_ : 0;
    const double from = bounded(top_, x);
    const double length = bounded(bottom_, x) - from;
    v = length > 0 ? (y - from) / length : 0;
  }

 private:
  static double edge(int at, int size) { return 2.0 * at / size - 1; }
  static double bounded(double y, double x) { return std::clamp(y, -half_chord(x), half_chord(x)); }
  double area_until(double x) const {
    return (clamped_area(x, bottom_) - clamped_area(left_, bottom_)) -
           (clamped_area(x, top_) - clamped_area(left_, top_));
  }

  double left_;
  double right_;
  double top_;
  double bottom_;
  bool is_whole_;
  double area_;
};

ImageGeometry::ImageGeometry(ImageDomain domain, int width, int height)
    : domain_(domain), width_(width), height_(height) {
  if (!is_direction()) return;
  depth_.reserve(static_cast<std::size_t>(height) + 1);
  for (int y = 0; y <= height; ++y) {
    const bool is_below = domain == ImageDomain::hemisphere && 2 * std::int64_t{y} >= height;
    depth_.push_back(is_below ? 0.5 : square_of(math::sin_2pi(static_cast<double>(y) / height / 4)));
  }
}

double ImageGeometry::measure(int x, int y) const {
  if (domain_ == ImageDomain::square) return 1.0 / width_ / height_;
  if (domain_ == ImageDomain::disk) return ClippedTexel(x, y, width_, height_).area();
  const auto row = static_cast<std::size_t>(y);
  return 4 * math::pi * (depth_[row + 1] - depth_[row]) / width_;
}

double ImageGeometry::depth_at(double y) const {
  const auto row = std::min(static_cast<std::size_t>(y), depth_.size() - 2);
  return depth_[row] + (y - static_cast<double>(row)) * (depth_[row + 1] - depth_[row]);
}

void ImageGeometry::to_sample(const TexelPoint& point, double* sample) const {
  if (domain_ == ImageDomain::square) {
    sample[0] = point.at[0] / width_;
    sample[1] = point.at[1] / height_;
    return;
  }
  if (domain_ == ImageDomain::disk) {
    const ClippedTexel texel(point.texel[0], point.texel[1], width_, height_);
    if (!texel.is_whole()) {
      return texel.to_disk(point.at[0] - point.texel[0], point.at[1] - point.texel[1], sample);
    }
    sample[0] = 2 * point.at[0] / width_ - 1;
    sample[1] = 2 * point.at[1] / height_ - 1;
    return;
  }
  const double depth = depth_at(point.at[1]);
  const double radius = 2 * std::sqrt(depth * (1 - depth));
  const double turns = point.at[0] / width_;
  sample[0] = radius * math::cos_2pi(turns);
  sample[1] = 1 - 2 * depth;
  sample[2] = radius * math::sin_2pi(turns);
}

TexelPoint ImageGeometry::to_texels(const float* sample) const {
  TexelPoint point{};
  const double a = sample[0];
  const double b = sample[1];
  if (domain_ == ImageDomain::square) {
    place(a * width_, width_, 0, point);
    place(b * height_, height_, 1, point);
    return point;
  }
  if (domain_ == ImageDomain::disk) {
    place(0.5 * (a + 1) * width_, width_, 0, point);
    place(0.5 * (b + 1) * height_, height_, 1, point);
    const ClippedTexel texel(point.texel[0], point.texel[1], width_, height_);
    if (texel.is_whole()) return point;
    double u = 0;
    double v = 0;
    texel.from_disk(a, b, u, v);
    for (const auto& [axis, part] : {std::pair(0, u), std::pair(1, v)}) {
      const auto at = static_cast<std::size_t>(axis);
      point.at[at] = std::clamp(point.texel[at] + part, static_cast<double>(point.texel[at]),
                                std::nextafter(point.texel[at] + 1.0, 0.0));
    }
    return point;
  }
  const double c = sample[2];
  place(turns_of(a, c) * width_, width_, 0, point);
  // 1 -+ cos a = sin^2 a / (1 +- cos a): no digits are lost near the poles.
  const double side = a * a + c * c;
  const double length = std::sqrt(side + b * b);
  const double near_pole = length > 0 ? side / (length * (length + std::fabs(b))) : 0;
  const double depth = 0.5 * (b >= 0 ? near_pole : 2 - near_pole);
  const auto next = std::upper_bound(depth_.begin(), depth_.end(), depth);
  const std::ptrdiff_t row = std::clamp<std::ptrdiff_t>(next - depth_.begin() - 1, 0, height_ - 1);
  const double low = depth_[static_cast<std::size_t>(row)];
  const double high = depth_[static_cast<std::size_t>(row) + 1];
  place(static_cast<double>(row) + (high > low ? std::clamp((depth - low) / (high - low), 0.0, 1.0) : 0), height_, 1,
        point);
  return point;
}

GridAxis ImageGeometry::longer_axis(const TexelBox& box) const {
  double width = (box.high[0] - box.low[0]) / width_;
  double height = (box.high[1] - box.low[1]) / height_;
  if (is_direction()) {
    const double top = depth_at(box.low[1]);
    const double bottom = depth_at(box.high[1]);
    const double middle = 0.5 * (top + bottom);
    width *= math::two_pi * 2 * std::sqrt(middle * (1 - middle));
    height = math::acos(1 - 2 * bottom) - math::acos(1 - 2 * top);
  }
  return width >= height ? GridAxis::x : GridAxis::y;
}

}  // namespace noiseloom
