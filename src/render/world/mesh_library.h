// What meshes ask of the libraries that read them (Assimp) and trace rays through them (Embree).
//
// Both are in a module that is loaded with the first mesh, as that of images is (image/pixels/image_library.h): it is
// built where both libraries are found, and no other scene needs it. Only library/meshes.cpp, which is the module,
// includes their headers. Nothing that is asked throws but std::bad_alloc.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "noiseloom/render/scene.h"

namespace noiseloom::render {

// Where a ray meets a triangle first: at (1 - u - v) of its first corner, u of its second and v of its third.
struct TriangleHit {
  std::uint32_t triangle = 0;
  float u = 0;
  float v = 0;
};

class TriangleTracer {
 public:
  virtual ~TriangleTracer() = default;
  // Of rays without an end; may be asked by any number of threads at a time.
  virtual bool find(const float* from, const float* direction, TriangleHit& hit) const = 0;
  virtual bool meets(const float* from, const float* direction) const = 0;
};

class MeshLibrary {
 public:
  virtual ~MeshLibrary() = default;
  // The triangles of all parts of a file, moved to where the file places them. Empty, or what is wrong.
  virtual std::string read(const std::string& path, Triangles& triangles) const = 0;
  // Null where rays cannot be traced, as there is no memory, say: `error` says why. The triangles must outlive it.
  virtual std::unique_ptr<TriangleTracer> trace(const Triangles& triangles, std::string& error) const = 0;
};

// Loads the library at the first call. Throws EnvironmentError where it cannot be loaded.
const MeshLibrary& mesh_library();

// The function of the module. Its name counts the changes of this header.
inline constexpr const char* mesh_library_function = "noiseloom_mesh_library_1";
using MeshLibraryFunction = const MeshLibrary* (*)();

}  // namespace noiseloom::render
