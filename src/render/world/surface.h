// A sphere of radius 1 that rests on an endless plane, seen along parallel rays from above: shapes whose occlusion and
// shadow have closed forms, and whose picture moves by whole pixels where they do. A mesh (render/world/mesh.h) may
// stand in the place of the sphere.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "noiseloom/core/parallel.h"
#include "noiseloom/render/scene.h"
#include "render/world/image.h"

namespace noiseloom::render {

struct Vector {
  double x = 0;
  double y = 0;
  double z = 0;
};
inline Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector operator*(double s, Vector a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

enum class Shape : std::uint8_t { plane, sphere, mesh };

class Mesh;

struct Hit {
  Vector place;
  Vector normal;
  Shape shape = Shape::plane;
};

// What the ray of each pixel meets first; there always is the plane.
struct Hits {
  int width = 0;
  int height = 0;
  std::vector<Hit> hits;
  const Hit& at(int x, int y) const {
    return hits[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};
// `mesh`: null for the sphere.
Hits make_hits(int width, int height, ThreadPool& pool, const Mesh* mesh = nullptr);
// The same with the view moved by so many pixels, to the right and downward, from the sphere's point of view.
Hits make_hits(int width, int height, double right, double down, Rows rows, const Mesh* mesh = nullptr);
// What is seen so many pixels to the right of the middle of the picture, and above it, where `pixel` is the side of
// one.
Hit hit_of(double pixel, double right_of_middle, double above_middle, const Mesh* mesh);
// The side of a pixel where so many are across the picture.
double side_of_pixel(int width);

// How a shape moves on the screen from one frame to the next, in pixels.
struct Step {
  double right = 0;
  double down = 0;
};
Step step_of(const MotionSpec& motion, Shape shape);

// Whether light that comes from `direction` is kept from the place. A shape does not hide itself by mistake: a place on
// the sphere asks for the plane alone, and the other way round.
bool is_hidden(const Hit& hit, Vector direction);
// The same where a mesh may stand in the place of the sphere.
bool is_hidden(const Hit& hit, Vector direction, const Mesh* mesh);
// The same of light from a direction of the sun: a place sees what is above its own surface.
bool is_in_shadow(const Hit& hit, Vector direction, const Mesh* mesh);

// The share of cosine-weighted directions above the surface that are open.
double open_share(const Hit& hit);
// The share of a sun that is seen: a cap of directions of that radius (given by its cosine) around sun_direction.
double sun_share(const Hit& hit, double cos_radius);
inline constexpr Vector sun_direction = {-0.48, 0.6, -0.64};

// The solid angle that two caps of the unit sphere share, their radii and distance given by cosines.
double shared_solid_angle(double cos_a, double cos_b, double cos_between);

// A direction about the axis z, drawn with a density that grows with its cosine, from two numbers of 0 to 1.
Vector cosine_direction(double u, double v);
// That of a given cosine to the axis z.
Vector direction_at(double cosine, double v);
// From about the axis z to about `normal`.
Vector turned(Vector about_z, Vector normal);

// Two axes across `normal`, which has length 1, its mirror cases included.
struct Frame {
  Vector first;
  Vector second;
};
Frame frame_of(Vector normal);

// What `tap` weighs in a filter at `at`: less the further it is from the plane that touches the surface there, and the
// more its normal differs. 1 where both lie on the plane.
double edge_weight(const Hit& at, const Hit& tap, const SpaceFilterSpec& filter, bool by_depth, bool by_normal);

// Weights of the taps of a filter in every pixel, those of a pixel adding up to 1: what lies on another surface weighs
// nothing or little. They depend on shapes alone, so that the filter stays linear.
struct EdgeWeights {
  int reach = 0;
  std::vector<std::vector<float>> taps;  // [dy][dx], each of all pixels
};
EdgeWeights make_edge_weights(const Hits& hits, const SpaceFilterSpec& filter, Border border);
Image filtered(const Image& image, const EdgeWeights& weights, Border border, Rows rows = {});

}  // namespace noiseloom::render
