// The module that reads meshes and traces rays through them (mesh_library.h): Assimp and Embree 3 or 4.
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <cmath>
#include <exception>
#include <limits>
#include <new>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "render/world/mesh_library.h"

namespace noiseloom::render {
namespace {

std::string add_part(const aiMesh& part, Triangles& triangles) {
  const std::size_t first = triangles.places.size() / 3;
  if (first + part.mNumVertices > std::numeric_limits<std::uint32_t>::max()) return "has more than 2^32 vertices";
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    const aiVector3D& place = part.mVertices[i];
    triangles.places.insert(triangles.places.end(), {place.x, place.y, place.z});
  }
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    if (face.mNumIndices != 3) continue;
    for (unsigned k = 0; k < 3; ++k) {
      if (face.mIndices[k] >= part.mNumVertices)
        return "has a triangle with the vertex " + std::to_string(face.mIndices[k]) + " of " +
               std::to_string(part.mNumVertices) + " (counted from 0)";
      triangles.corners.push_back(static_cast<std::uint32_t>(first + face.mIndices[k]));
    }
  }
  return {};
}

// One instruction set, so that rays meet the same triangles on every processor; threads are those of who asks.
#if defined(__x86_64__)
constexpr const char* device_words = "isa=sse2,threads=1,set_affinity=0,ignore_config_files=1";
#else
constexpr const char* device_words = "threads=1,set_affinity=0,ignore_config_files=1";
#endif

class Tracer final : public TriangleTracer {
 public:
  ~Tracer() override {
    if (scene_ != nullptr) rtcReleaseScene(scene_);
    if (device_ != nullptr) rtcReleaseDevice(device_);
  }

  // RTC_ERROR_NONE where rays can be traced.
  int make(const Triangles& triangles) {
    device_ = rtcNewDevice(device_words);
    if (device_ == nullptr) return rtcGetDeviceError(nullptr);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);  // no ray passes between two triangles that share an edge
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    // Copied, as what is shared must end with bytes that no vertex needs.
    auto* const places = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), triangles.places.size() / 3));
    auto* const corners = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles.size()));
    if (places != nullptr && corners != nullptr) {
      std::copy(triangles.places.begin(), triangles.places.end(), places);
      std::copy(triangles.corners.begin(), triangles.corners.end(), corners);
      rtcCommitGeometry(geometry);
      rtcAttachGeometry(scene_, geometry);
      rtcCommitScene(scene_);
    }
    rtcReleaseGeometry(geometry);
    return rtcGetDeviceError(device_);
  }

  bool find(const float* from, const float* direction, TriangleHit& hit) const override {
    RTCRayHit ray{};
    ray.ray = ray_of(from, direction);
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(scene_, &ray);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_, &context, &ray);
#endif
    hit = {ray.hit.primID, ray.hit.u, ray.hit.v};
    return ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  }

  bool meets(const float* from, const float* direction) const override {
    RTCRay ray = ray_of(from, direction);
#if RTC_VERSION_MAJOR >= 4
    rtcOccluded1(scene_, &ray);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene_, &context, &ray);
#endif
    return ray.tfar < 0;
  }

 private:
  static RTCRay ray_of(const float* from, const float* direction) {
    RTCRay ray{};
    ray.org_x = from[0];
    ray.org_y = from[1];
    ray.org_z = from[2];
    ray.dir_x = direction[0];
    ray.dir_y = direction[1];
    ray.dir_z = direction[2];
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.mask = ~0U;
    return ray;
  }

  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

class Library final : public MeshLibrary {
 public:
  std::string read(const std::string& path, Triangles& triangles) const override {
    try {
      Assimp::Importer importer;
      importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
      const aiScene* const scene =
          importer.ReadFile(path, aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices);
      if (scene == nullptr && std::string(importer.GetErrorString()).find("bad_alloc") != std::string::npos)
        throw std::bad_alloc();
      if (scene == nullptr) return std::string("cannot be read as a mesh: ") + importer.GetErrorString();
      for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
        const std::string error = add_part(*scene->mMeshes[i], triangles);
        if (!error.empty()) return error;
      }
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      return std::string("cannot be read as a mesh: ") + error.what();
    }
    return {};
  }

  std::unique_ptr<TriangleTracer> trace(const Triangles& triangles, std::string& error) const override {
    auto tracer = std::make_unique<Tracer>();
    const int refused = tracer->make(triangles);
    if (refused == RTC_ERROR_NONE) return tracer;
    error = refused == RTC_ERROR_OUT_OF_MEMORY
                ? "Embree has no memory for " + std::to_string(triangles.size()) + " triangles"
                : "Embree cannot be used: its error " + std::to_string(refused) + " (RTCError)";
    return nullptr;
  }
};

}  // namespace
}  // namespace noiseloom::render

extern "C" [[gnu::visibility("default")]] const noiseloom::render::MeshLibrary* noiseloom_mesh_library_1();
extern "C" const noiseloom::render::MeshLibrary* noiseloom_mesh_library_1() {
  static const noiseloom::render::Library library;
  return &library;
}
