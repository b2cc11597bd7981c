// A mesh in the place of the sphere: what a user's file holds, scaled and set down on the plane.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "noiseloom/render/scene.h"
#include "render/world/mesh_library.h"
#include "render/world/surface.h"

namespace noiseloom::render {

// Of a mesh's file and, for a .gltf, of all files that end in .bin beside it: they hold its numbers. 0 where there is
// no such file.
std::uintmax_t bytes_of_mesh_file(const std::string& path);

// Bytes that a mesh of so many vertices and triangles takes with what finds the triangles that a ray meets.
std::int64_t bytes_of_triangles(std::int64_t vertices, std::int64_t triangles);
// The same of what the file holds, which is read for it and kept for the mesh; of files past 100 MB, from the size of
// the file, no less than it takes. 0 where the file cannot be read: who loads it says why.
std::int64_t bytes_of_mesh_in(const ObjectSpec& spec);

class Mesh {
 public:
  // Takes what was read for the plan. Throws UserError where the file cannot be read, or is no mesh of triangles that
  // have places and areas.
  explicit Mesh(const ObjectSpec& spec);

  // What a ray from afar meets first.
  std::optional<Hit> find(Vector from, Vector direction) const;
  // Whether the mesh, or for a place on the mesh the plane, keeps light of that direction from the place.
  bool hides(const Hit& hit, Vector direction) const;

  std::size_t num_triangles() const { return triangles_.size(); }
  std::size_t num_left_out() const { return left_out_; }  // without an area

 private:
  void read(const ObjectSpec& spec);
  void set_down(const ObjectSpec& spec);
  Vector corner(std::uint32_t triangle, std::size_t k) const;

  Triangles triangles_;
  std::size_t left_out_ = 0;
  Vector middle_;  // of a ball that holds the mesh
  double radius_ = 0;
  std::unique_ptr<TriangleTracer> tracer_;
};

}  // namespace noiseloom::render
