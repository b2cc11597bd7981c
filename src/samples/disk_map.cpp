#include "samples/disk_map.h"

#include <algorithm>
#include <cmath>

#include "noiseloom/core/math.h"

namespace noiseloom {

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

double turns_of(double x, double y) {
  const auto arc_sine = [](double sine) { return 0.5 * math::pi - math::acos(sine); };
  const double radius = std::sqrt(x * x + y * y);
  if (radius == 0) return 0;
  double angle;
  if (std::fabs(y) <= std::fabs(x)) {
    const double slope = arc_sine(y / radius);
    angle = x >= 0 ? slope : math::pi - slope;
  } else {
    const double slope = arc_sine(x / radius);
    angle = y >= 0 ? 0.5 * math::pi - slope : 1.5 * math::pi + slope;
  }
  const double turns = angle / math::two_pi;
  const double positive = turns < 0 ? turns + 1 : turns;
  return positive < 1 ? positive : 0;
}

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

double disk_share_below(double value) {
  return 0.5 + (value * std::sqrt(std::max(0.0, one_minus_square(value))) + std::asin(std::clamp(value, -1.0, 1.0))) /
                   math::pi;
}

}  // namespace noiseloom
