#include "render/world/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "noiseloom/core/math.h"
#include "render/world/mesh.h"

namespace noiseloom::render {
namespace {

constexpr Vector centre = {0, 1, 0};  // of the sphere
constexpr Vector right = {1, 0, 0};
constexpr Vector up = {0, 0.8, 0.6};
constexpr Vector forward = {0, -0.6, 0.8};
constexpr Vector looked_at = {0, 0.7, 0};
constexpr double view_width = 6;
constexpr double distance_of_camera = 20;

// The distance along the ray to the sphere, or below zero.
double distance_to_sphere(Vector from, Vector direction) {
  const Vector to = centre - from;
  const double along = dot(to, direction);
  const double beside = dot(to, to) - along * along;
  if (beside >= 1) return -1;
  return along - std::sqrt(1 - beside);
}

void trace_row(Hits& hits, int y, double view_right, double view_down, const Mesh* mesh) {
  const double pixel = side_of_pixel(hits.width);
  for (int x = 0; x < hits.width; ++x)
    hits.hits[static_cast<std::size_t>(y) * static_cast<std::size_t>(hits.width) + static_cast<std::size_t>(x)] =
        hit_of(pixel, x + view_right + 0.5 - 0.5 * hits.width, 0.5 * hits.height - y - view_down - 0.5, mesh);
}

Hits no_hits(int width, int height) {
  Hits hits{width, height, {}};
  hits.hits.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  return hits;
}

}  // namespace

double side_of_pixel(int width) { return view_width / width; }

Hit hit_of(double pixel, double right_of_middle, double above_middle, const Mesh* mesh) {
  const Vector from =
      looked_at + pixel * right_of_middle * right + pixel * above_middle * up + -distance_of_camera * forward;
  if (mesh != nullptr) {
    if (const std::optional<Hit> hit = mesh->find(from, forward)) return *hit;
  } else if (const double to_sphere = distance_to_sphere(from, forward); to_sphere > 0) {
    const Vector place = from + to_sphere * forward;
    return {place, place - centre, Shape::sphere};
  }
  Vector place = from + (from.y / -forward.y) * forward;
  place.y = 0;
  return {place, {0, 1, 0}, Shape::plane};
}

Hits make_hits(int width, int height, ThreadPool& pool, const Mesh* mesh) {
  Hits hits = no_hits(width, height);
  pool.for_each(height, [&](std::int64_t y, int) { trace_row(hits, static_cast<int>(y), 0, 0, mesh); });
  return hits;
}

Hits make_hits(int width, int height, double view_right, double view_down, Rows rows, const Mesh* mesh) {
  Hits hits = no_hits(width, height);
  rows(height, [&](int first, int last) {
    for (int y = first; y < last; ++y) trace_row(hits, y, view_right, view_down, mesh);
  });
  return hits;
}

Step step_of(const MotionSpec& motion, Shape shape) {
  const Step camera{motion.camera[0], motion.camera[1]};
  if (shape == Shape::plane) return {-camera.right, -camera.down};
  return {motion.sphere[0] - camera.right, motion.sphere[1] - camera.down};
}

bool is_hidden(const Hit& hit, Vector direction) {
  if (hit.shape == Shape::sphere) return direction.y < 0;
  const Vector to = centre - hit.place;
  const double along = dot(to, direction);
  return along > 0 && dot(to, to) - along * along < 1;
}

bool is_hidden(const Hit& hit, Vector direction, const Mesh* mesh) {
  return mesh == nullptr ? is_hidden(hit, direction) : mesh->hides(hit, direction);
}

bool is_in_shadow(const Hit& hit, Vector direction, const Mesh* mesh) {
  if (hit.shape == Shape::sphere) return dot(hit.normal, direction) <= 0;
  return (hit.shape == Shape::mesh && dot(hit.normal, direction) <= 0) || is_hidden(hit, direction, mesh);
}

double open_share(const Hit& hit) {
  // The plane hides all below its horizon; the sphere touches the horizon and is a cap of cosine-weighted share
  // (1 / d)^2 cos, d being the distance of its centre and 1 / d the cosine of its direction.
  if (hit.shape == Shape::sphere) return 0.5 + 0.5 * hit.normal.y;
  const Vector to = centre - hit.place;
  const double d2 = dot(to, to);
  return 1 - 1 / (d2 * std::sqrt(d2));
}

double shared_solid_angle(double cos_a, double cos_b, double cos_between) {
  const auto sine = [](double cosine) { return std::sqrt(std::max(0.0, 1 - cosine * cosine)); };
  const double a = math::acos(cos_a);
  const double b = math::acos(cos_b);
  const double between = math::acos(cos_between);
  if (between >= a + b) return 0;
  if (between <= std::fabs(a - b)) return math::two_pi * (1 - std::max(cos_a, cos_b));
  if (between + a + b >= math::two_pi) return math::two_pi * (1 - cos_a) + math::two_pi * (1 - cos_b) - 4 * math::pi;
  const double corner = math::acos((cos_between - cos_a * cos_b) / (sine(cos_a) * sine(cos_b)));
  const double at_a = math::acos((cos_b - cos_between * cos_a) / (sine(cos_between) * sine(cos_a)));
  const double at_b = math::acos((cos_a - cos_between * cos_b) / (sine(cos_between) * sine(cos_b)));
  return 2 * (math::pi - corner - at_a * cos_a - at_b * cos_b);
}

double sun_share(const Hit& hit, double cos_radius) {
  const double whole = math::two_pi * (1 - cos_radius);
  if (hit.shape == Shape::sphere) return shared_solid_angle(cos_radius, 0, dot(hit.normal, sun_direction)) / whole;
  const Vector to = centre - hit.place;
  const double d = std::sqrt(dot(to, to));
  const double cos_sphere = std::sqrt(std::max(0.0, 1 - 1 / (d * d)));
  return 1 - shared_solid_angle(cos_radius, cos_sphere, dot(to, sun_direction) / d) / whole;
}

Vector cosine_direction(double u, double v) {
  const double radius = std::sqrt(u);
  return {radius * math::cos_2pi(v), radius * math::sin_2pi(v), std::sqrt(std::max(0.0, 1 - u))};
}

Vector direction_at(double cosine, double v) {
  const double radius = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  return {radius * math::cos_2pi(v), radius * math::sin_2pi(v), cosine};
}

Vector turned(Vector about_z, Vector normal) {
  const Frame frame = frame_of(normal);
  return about_z.x * frame.first + about_z.y * frame.second + about_z.z * normal;
}

// [Duff17], with the sign of z kept for -0.
Frame frame_of(Vector n) {
  const double sign = std::copysign(1.0, n.z);
  const double a = -1 / (sign + n.z);
  const double b = n.x * n.y * a;
  return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
}

// Of a place from the tangent plane of another. Two places without end at one place are no distance apart, though the
// difference of their numbers is none; where only one has no end, all is between them.
static double distance_in_depth(const Hit& at, const Hit& tap) {
  const double distance = std::fabs(dot(at.normal, tap.place - at.place));
  if (!std::isnan(distance)) return distance;
  const bool is_same = at.place.x == tap.place.x && at.place.y == tap.place.y && at.place.z == tap.place.z;
  return is_same ? 0 : std::numeric_limits<double>::infinity();
}

double edge_weight(const Hit& at, const Hit& tap, const SpaceFilterSpec& filter, bool by_depth, bool by_normal) {
  if (at.shape == Shape::plane && tap.shape == Shape::plane) return 1;
  double weight = 1;
  if (by_depth) weight *= math::exp(-distance_in_depth(at, tap) / filter.depth);
  if (by_normal) weight *= math::pow(std::max(0.0, dot(at.normal, tap.normal)), filter.power);
  return weight;
}

EdgeWeights make_edge_weights(const Hits& hits, const SpaceFilterSpec& filter, Border border) {
  const std::vector<float> taps = taps_of(filter);
  const auto has = [&](const char* edge) {
    return std::find(filter.edges.begin(), filter.edges.end(), edge) != filter.edges.end();
  };
  const bool by_depth = has("depth");
  const bool by_normal = has("normal");
  EdgeWeights weights{.reach = static_cast<int>(taps.size() / 2), .taps = {}};
  std::vector<double> sums(hits.hits.size());
  for (int dy = -weights.reach; dy <= weights.reach; ++dy)
    for (int dx = -weights.reach; dx <= weights.reach; ++dx) {
      const double tap = static_cast<double>(taps[static_cast<std::size_t>(dx + weights.reach)]) *
                         static_cast<double>(taps[static_cast<std::size_t>(dy + weights.reach)]);
      std::vector<float>& plane = weights.taps.emplace_back(hits.hits.size());
      std::size_t i = 0;
      for (int y = 0; y < hits.height; ++y)
        for (int x = 0; x < hits.width; ++x, ++i) {
          const Hit& other = hits.at(inside(x + dx, hits.width, border), inside(y + dy, hits.height, border));
          const double weight = tap * edge_weight(hits.hits[i], other, filter, by_depth, by_normal);
          plane[i] = static_cast<float>(weight);
          sums[i] += weight;
        }
    }
  for (std::vector<float>& plane : weights.taps)
    for (std::size_t i = 0; i < plane.size(); ++i)
      plane[i] = static_cast<float>(static_cast<double>(plane[i]) / sums[i]);
  return weights;
}

Image filtered(const Image& image, const EdgeWeights& weights, Border border, Rows rows) {
  Image result = make_image(image.width, image.height, image.channels);
  const auto width = static_cast<std::size_t>(image.width);
  const int reach = weights.reach;
  rows(image.height, [&](int first, int last) {
    std::vector<float> wide(width + 2 * static_cast<std::size_t>(reach));
    for (int c = 0; c < image.channels; ++c)
      for (int y = first; y < last; ++y)
        for (int dy = -reach; dy <= reach; ++dy) {
          const float* const from = image.row(c, inside(y + dy, image.height, border));
          for (int x = -reach; x < image.width + reach; ++x)
            wide[static_cast<std::size_t>(x + reach)] = from[inside(x, image.width, border)];
          float* const to = result.row(c, y);
          for (int dx = 0; dx <= 2 * reach; ++dx) {
            const auto tap = static_cast<std::size_t>((dy + reach) * (2 * reach + 1) + dx);
            const float* const weight = weights.taps[tap].data() + static_cast<std::size_t>(y) * width;
            for (std::size_t x = 0; x < width; ++x) to[x] += weight[x] * wide[x + static_cast<std::size_t>(dx)];
          }
        }
  });
  return result;
}

}  // namespace noiseloom::render
