// hexagon: points of the regular hexagon with its corners on the unit circle, one of them on the x axis; star: of a
// star of n points on the unit circle, with its inner corners on a smaller one. Apertures of a lens, uniform.
//
// Seen from the middle both are sectors of equal area: triangles of the middle, an outer and an inner corner, of a star
// half a spike each. The box is the sectors side by side: along its first side where on the triangle's base a point
// lies, seen from its apex, along its second one the square of how far it is from the apex. Which corner is the apex
// decides how well neighbours keep together in long triangles.
#include <algorithm>
#include <cmath>

#include "noiseloom/core/math.h"
#include "samples/disk_map.h"
#include "samples/mapped_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

struct Corner {
  double x;
  double y;
};

// Half a spike: a triangle.
struct Sector {
  Corner apex;
  Corner from;  // the base
  Corner to;
};

enum class Apex { middle, tip, inner_corner };

class Aperture {
 public:
  // Corners are at equal angles, the first on the x axis: tips, of radius 1, and inner corners by turns. `length`: of
  // the first side of the box, for a second one of 1.
  Aperture(int num_corners, double inner, Apex apex, double length) : length_(length) {
    constexpr Corner middle = {0, 0};
    const auto corner = [&](int k) -> Corner {
      const double radius = k % 2 == 0 ? 1 : inner;
      const double turns = static_cast<double>(k) / num_corners;
      return {radius * math::cos_2pi(turns), radius * math::sin_2pi(turns)};
    };
    for (int k = -1; k + 1 < num_corners; ++k) {  // a spike is the sectors before and behind its tip
      const Corner first = corner(k);
      const Corner second = corner(k + 1);
      const bool behind = k % 2 == 0;
      const Corner tip = behind ? first : second;
      const Corner inner_corner = behind ? second : first;
      if (apex == Apex::middle) sectors_.push_back({middle, first, second});
      if (apex == Apex::tip) sectors_.push_back({tip, behind ? middle : inner_corner, behind ? inner_corner : middle});
      if (apex == Apex::inner_corner) sectors_.push_back({inner_corner, behind ? tip : middle, behind ? middle : tip});
    }
  }

  Box domain() const {
    Box box = unit_box(2);
    box.high[0] = length_;
    return box;
  }
  double area() const {
    const Sector& s = sectors_.front();
    return 0.5 * std::fabs(doubled_area(s.apex, s.from, s.to)) * static_cast<double>(sectors_.size());
  }

  void to_sample(const double* u, double* sample) const {
    const double at = u[0] / length_ * static_cast<double>(sectors_.size());
    const std::size_t index = std::min(static_cast<std::size_t>(at), sectors_.size() - 1);
    const Sector& s = sectors_[index];
    const double part = at - static_cast<double>(index);
    const double out = std::sqrt(u[1]);
    const auto point = [&](double apex, double from, double to) {
      return apex + out * (from + part * (to - from) - apex);
    };
    sample[0] = point(s.apex.x, s.from.x, s.to.x);
    sample[1] = point(s.apex.y, s.from.y, s.to.y);
  }

  void to_domain(const float* sample, double* u) const {
    const Weights w = weights({sample[0], sample[1]});
    const double out = w.from + w.to;
    const double part = out > 0 ? std::clamp(w.to / out, 0.0, 1.0) : 0;
    u[0] = length_ * (static_cast<double>(w.sector) + part) / static_cast<double>(sectors_.size());
    u[1] = out * out;
  }

  bool contains(const float* sample) const {
    const Weights w = weights({sample[0], sample[1]});
    return w.from >= 0 && w.to >= 0 && w.from + w.to <= 1;
  }

 private:
  static double doubled_area(const Corner& a, const Corner& b, const Corner& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  }

  // The sector of the point's angle; the first begins an angle of one sector before the x axis.
  std::size_t sector_of(const Corner& point) const {
    const double turns = turns_of(point.x, point.y);
    return static_cast<std::size_t>(turns * static_cast<double>(sectors_.size()) + 1) % sectors_.size();
  }

  // A point is apex + from (s.from - apex) + to (s.to - apex).
  struct Weights {
    std::size_t sector;
    double from;
    double to;
  };
  Weights weights(const Corner& point) const {
    const std::size_t index = sector_of(point);
    const Sector& s = sectors_[index];
    const double whole = doubled_area(s.apex, s.from, s.to);
    return {index, doubled_area(s.apex, point, s.to) / whole, doubled_area(s.apex, s.from, point) / whole};
  }

  std::vector<Sector> sectors_;
  double length_;
};

BoxMap map_of(const Aperture& aperture) {
  return {.domain = aperture.domain(),
          .to_sample = [aperture](int /*channels*/, const double* u, double* sample) { aperture.to_sample(u, sample); },
          .to_domain = [aperture](int /*channels*/, const float* sample, double* u) { aperture.to_domain(sample, u); },
          .contains = [aperture](const float* sample) { return aperture.contains(sample); },
          .density = [area = aperture.area()](const float*) { return 1 / area; }};
}

// Two corners of a sector that lie near each other are its base; where no two do, the inner corner lies nearest to the
// side that faces it.
SpacePtr make_star(const SpaceTraits& traits, const std::vector<double>& values) {
  const int num_corners = 2 * static_cast<int>(values[0]);
  const double inner = values[1];
  const double rise = inner * math::sin_2pi(1.0 / num_corners);  // of the inner corner over its spike's axis
  const double rest = 1 - inner * math::cos_2pi(1.0 / num_corners);
  constexpr double is_near = 0.35;
  const Apex apex = inner < is_near                                 ? Apex::tip
                    : rise * rise + rest * rest < is_near * is_near ? Apex::middle
                                                                    : Apex::inner_corner;
  const double length = apex == Apex::tip      ? 0.5 * num_corners * inner
                        : apex == Apex::middle ? 0.5 * math::pi * (1 + inner)
                                               : 0.5 * num_corners / rise;
  return std::make_unique<MappedSpace>(traits, map_of(Aperture(num_corners, inner, apex, length)));
}

}  // namespace

SpacePtr hexagon_space() {
  return std::make_unique<MappedSpace>(
      SpaceTraits{.name = "hexagon",
                  .meaning = "a point of the regular hexagon, corners on the unit circle",
                  .aliases = "hex six-blades",
                  .channels = 2,
                  .dimensions = 2,
                  .distance = DistanceKind::euclidean,
                  .range = ValueRange{-1, 1},
                  .support = Support::unit_disk,
                  .nvidia_name = "hexagon",
                  .ea_name = "hexagon_uniform"},
      map_of(Aperture(6, 1, Apex::middle, 3)));
}

SpaceFamily star_family() {
  return {.traits = {.name = "star",
                     .meaning = "a point of a star with its tips on the unit circle",
                     .aliases = "star-lens starlens",
                     .channels = 2,
                     .dimensions = 2,
                     .distance = DistanceKind::euclidean,
                     .range = ValueRange{-1, 1},
                     .support = Support::unit_disk,
                     .parameters = {{.name = "points",
                                     .meaning = "Tips of the star, one of them on the x axis.",
                                     .initial = 5,
                                     .least = 3,
                                     .most = 16,
                                     .whole = true},
                                    {.name = "inner",
                                     .meaning = "Radius of the circle of the corners between the tips.",
                                     .initial = 0.4,
                                     .least = 0.01,
                                     .most = 1}},
                     .nvidia_name = "star",
                     .ea_name = "star_uniform"},
          .make = make_star};
}

}  // namespace noiseloom
