#include "samples/sample_maps.h"

#include <algorithm>
#include <cmath>

#include "noiseloom/core/error.h"
#include "noiseloom/core/math.h"

namespace noiseloom {
namespace {

struct DiskPoint {
  double x;
  double y;
  double radius;
};

DiskPoint disk_from_square(double u, double v) {
  const double a = 2 * u - 1;
  const double b = 2 * v - 1;
  if (std::fabs(a) >= std::fabs(b)) {
    const double turns = a == 0 ? 0 : b / a / 8;
    return {a * math::cos_2pi(turns), a * math::sin_2pi(turns), std::fabs(a)};
  }
  const double turns = a / b / 8;
  return {b * math::sin_2pi(turns), b * math::cos_2pi(turns), std::fabs(b)};
}

void square_from_disk(double x, double y, double* u) {
  const double radius = std::sqrt(x * x + y * y);
  // Angle from the nearer axis, as a part of an eighth of a turn.
  const auto part = [radius](double side) {
    return radius == 0 ? 0 : (0.5 * math::pi - math::acos(std::fabs(side) / radius)) * (4 / math::pi);
  };
  const bool along_x = std::fabs(x) >= std::fabs(y);
  const double a = std::copysign(along_x ? radius : radius * part(x), x);
  const double b = std::copysign(along_x ? radius * part(y) : radius, y);
  u[0] = 0.5 * (a + 1);
  u[1] = 0.5 * (b + 1);
}

// (1 - r)(1 + r) keeps its relative accuracy at the rim.
double one_minus_square(double r) { return (1 - r) * (1 + r); }

void hemisphere_from_square(double u, double v, double* sample) {
  const DiskPoint p = disk_from_square(u, v);
  const double z = one_minus_square(p.radius);
  const double scale = std::sqrt(1 + z);
  sample[0] = p.x * scale;
  sample[1] = p.y * scale;
  sample[2] = z;
}

void square_from_hemisphere(const float* sample, double* u) {
  const double scale = std::sqrt(1 + std::fabs(static_cast<double>(sample[2])));
  square_from_disk(sample[0] / scale, sample[1] / scale, u);
}

}  // namespace

Box domain(SampleKind kind, int channels) {
  Box box;
  box.dimensions = kind == SampleKind::vector ? static_cast<std::size_t>(channels) : 2;
  NOISELOOM_CHECK_LE(box.dimensions, max_dimensions);
  box.high.fill(1);
  if (kind == SampleKind::sphere) box.high[0] = 2;
  return box;
}

void to_sample(SampleKind kind, int channels, const double* u, double* sample) {
  if (kind == SampleKind::vector) {
    std::copy(u, u + channels, sample);
  } else if (kind == SampleKind::hemisphere) {
    hemisphere_from_square(u[0], u[1], sample);
  } else if (kind == SampleKind::sphere) {
    const bool down = u[0] >= 1;
    hemisphere_from_square(down ? 2 - u[0] : u[0], u[1], sample);
    if (down) sample[2] = -sample[2];
  } else {
    const DiskPoint p = disk_from_square(u[0], u[1]);
    sample[0] = p.x;
    sample[1] = p.y;
    if (kind == SampleKind::hemisphere_cosine) sample[2] = std::sqrt(one_minus_square(p.radius));
  }
}

void to_domain(SampleKind kind, int channels, const float* sample, double* u) {
  if (kind == SampleKind::vector) {
    std::copy(sample, sample + channels, u);
  } else if (kind == SampleKind::hemisphere || kind == SampleKind::sphere) {
    square_from_hemisphere(sample, u);
    if (std::signbit(sample[2]) && kind == SampleKind::sphere) u[0] = 2 - u[0];
  } else {
    square_from_disk(sample[0], sample[1], u);
  }
}

bool lies_in_space(SampleKind kind, const float* sample) {
  if (kind == SampleKind::disk) {
    const double x = sample[0];
    const double y = sample[1];
    return x * x + y * y <= 1;
  }
  if (kind == SampleKind::sphere) return sample[2] != 0;
  return kind == SampleKind::vector || sample[2] > 0;
}

}  // namespace noiseloom
