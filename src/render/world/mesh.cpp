#include "render/world/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "noiseloom/core/apart.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/math.h"
#include "noiseloom/core/quantity_text.h"

namespace noiseloom::render {
namespace {

constexpr std::uintmax_t most_bytes = std::uintmax_t{1} << 30;
constexpr std::size_t most_triangles = 20'000'000;

Vector cross(Vector a, Vector b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

std::array<float, 3> floats_of(Vector v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

std::string ending_of(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c + ('a' - 'A') : c); });
  return ending;
}

void check_file(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw UserError(path, "is not there: object.file names a mesh");
  if (!std::filesystem::is_regular_file(status)) throw UserError(path, "is no regular file: object.file names a mesh");
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (size == 0) throw UserError(path, "is empty: object.file names a mesh");
  if (size > most_bytes)
    throw UserError(path, fmt::format("has {} bytes: a mesh may have at most {}", size, most_bytes));
  const std::string ending = ending_of(path);
  constexpr std::array known = {".obj", ".ply", ".gltf", ".glb", ".stl"};
  if (std::find(known.begin(), known.end(), ending) == known.end())
    throw UserError(path, fmt::format("ends in \"{}\": accepted are meshes that end in {}", ending,
                                      ".obj, .ply, .gltf, .glb and .stl"));
}

template <class T>
void append(std::string& bytes, const std::vector<T>& values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}
template <class T>
void take(std::string_view& bytes, std::vector<T>& values) {
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  bytes.remove_prefix(values.size() * sizeof(T));
}

// Reads the file in a process of its own, which may not take much more memory than what a file of that size is worth:
// one that says that it holds billions of vertices would else take all that the machine has.
Triangles triangles_of(const std::string& path) {
  const MeshLibrary& library = mesh_library();
  constexpr std::uintmax_t least = 500'000'000;
  constexpr std::uintmax_t for_a_byte = 64;  // what a vertex of a few letters becomes while it is read
  const std::uintmax_t memory = least + for_a_byte * bytes_of_mesh_file(path);
  const ApartResult result = run_apart(
      [&] {
        Triangles triangles;
        const std::string error = library.read(path, triangles);
        if (!error.empty()) return 'e' + error;
        std::string bytes = "t";
        append(bytes, std::vector<std::uint64_t>{triangles.places.size(), triangles.corners.size()});
        append(bytes, triangles.places);
        append(bytes, triangles.corners);
        return bytes;
      },
      memory);
  if (!result.is_whole)
    throw UserError(path, result.signal != 0
                              ? fmt::format("is damaged, or no mesh: reading it ended with signal {}", result.signal)
                              : fmt::format("cannot be read within {}: it says that it holds more than its bytes "
                                            "can, or there is no more memory",
                                            bytes_text(static_cast<double>(memory))));
  std::string_view bytes(result.bytes);
  if (bytes.front() == 'e') throw UserError(path, std::string(bytes.substr(1)));
  bytes.remove_prefix(1);
  std::vector<std::uint64_t> counts(2);
  take(bytes, counts);
  Triangles triangles{std::vector<float>(counts[0]), std::vector<std::uint32_t>(counts[1])};
  take(bytes, triangles.places);
  take(bytes, triangles.corners);
  return triangles;
}

}  // namespace

std::uintmax_t bytes_of_mesh_file(const std::string& path) {
  std::error_code absent;
  const auto size_of = [&](const std::filesystem::path& file) {
    const std::uintmax_t size = std::filesystem::file_size(file, absent);
    return absent ? 0 : size;
  };
  std::uintmax_t bytes = size_of(path);
  if (bytes == 0 || ending_of(path) != ".gltf") return bytes;
  const std::filesystem::path folder = std::filesystem::absolute(path, absent).parent_path();
  for (const auto& entry : std::filesystem::directory_iterator(folder, absent)) {
    if (ending_of(entry.path()) == ".bin") bytes += size_of(entry.path());
  }
  return bytes;
}

std::int64_t bytes_of_triangles(std::int64_t vertices, std::int64_t triangles) {
  constexpr std::int64_t of_tracer = 115;  // a triangle, as measured
  return 12 * vertices + (12 + of_tracer) * triangles;
}

std::int64_t bytes_of_mesh_in(const ObjectSpec& spec) {
  const std::string& path = spec.file;
  const auto bytes_of = [](const Triangles& triangles) {
    return bytes_of_triangles(std::ssize(triangles.places) / 3, std::ssize(triangles.corners) / 3);
  };
  if (spec.read->file == path) return bytes_of(spec.read->triangles);
  constexpr std::uintmax_t most_to_read = 100'000'000;
  // The files of a triangle that take least have three places of two bytes, which three triangles may share.
  const std::uintmax_t size = bytes_of_mesh_file(path);
  const std::int64_t most = bytes_of_triangles(0, static_cast<std::int64_t>(size / 6));
  if (size > most_to_read) return most;
  try {
    check_file(path);
    *spec.read = {path, triangles_of(path)};
    return bytes_of(spec.read->triangles);
  } catch (const UserError&) {
    return 0;
  } catch (const EnvironmentError&) {  // no library that reads meshes on the machine that plans
    return most;
  }
}

Mesh::Mesh(const ObjectSpec& spec) {
  read(spec);
  set_down(spec);
  std::string error;
  tracer_ = mesh_library().trace(triangles_, error);
  if (tracer_ == nullptr) throw EnvironmentError(fmt::format("{}: {}", spec.file, error));
}

Vector Mesh::corner(std::uint32_t triangle, std::size_t k) const {
  const float* const place = triangles_.places.data() + 3 * std::size_t{triangles_.corners[3 * triangle + k]};
  return {static_cast<double>(place[0]), static_cast<double>(place[1]), static_cast<double>(place[2])};
}

void Mesh::read(const ObjectSpec& spec) {
  const std::string& path = spec.file;
  if (spec.read->file == path) {
    triangles_ = std::exchange(*spec.read, {}).triangles;
  } else {
    check_file(path);
    triangles_ = triangles_of(path);
  }
  if (triangles_.size() == 0) throw UserError(path, "has no triangles");
  if (triangles_.size() > most_triangles)
    throw UserError(path, fmt::format("has {} triangles: accepted are at most {}", triangles_.size(), most_triangles));
  for (std::size_t i = 0; i < triangles_.places.size(); ++i)
    if (!std::isfinite(triangles_.places[i]))
      throw UserError(path, fmt::format("has {} as the {} of a vertex (number {}, counted from 0): places are finite",
                                        triangles_.places[i], "xyz"[i % 3], i / 3));
  // Without an area they have no normal, and no ray meets them.
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
    const Vector normal = cross(corner(i, 1) - corner(i, 0), corner(i, 2) - corner(i, 0));
    if (dot(normal, normal) > 0)
      kept.insert(kept.end(), triangles_.corners.begin() + 3 * std::ptrdiff_t{i},
                  triangles_.corners.begin() + 3 * std::ptrdiff_t{i} + 3);
  }
  left_out_ = triangles_.size() - kept.size() / 3;
  if (kept.empty()) throw UserError(path, fmt::format("none of its triangles ({}) has an area", triangles_.size()));
  triangles_.corners = std::move(kept);
}

// Turned, scaled and moved in double; vertices that no triangle has are of no account.
void Mesh::set_down(const ObjectSpec& spec) {
  const double cosine = math::cos_2pi(spec.turn / 360 - std::floor(spec.turn / 360));
  const double sine = math::sin_2pi(spec.turn / 360 - std::floor(spec.turn / 360));
  const auto turned = [&](const float* place) {
    const Vector p = {static_cast<double>(place[0]), static_cast<double>(place[1]), static_cast<double>(place[2])};
    const Vector up = spec.up == UpAxis::y ? p : Vector{p.x, p.z, -p.y};
    return Vector{cosine * up.x + sine * up.z, up.y, cosine * up.z - sine * up.x};
  };
  constexpr double infinite = std::numeric_limits<double>::infinity();
  Vector least = {infinite, infinite, infinite};
  Vector most = {-infinite, -infinite, -infinite};
  for (const std::uint32_t vertex : triangles_.corners) {
    const Vector p = turned(triangles_.places.data() + 3 * std::size_t{vertex});
    least = {std::min(least.x, p.x), std::min(least.y, p.y), std::min(least.z, p.z)};
    most = {std::max(most.x, p.x), std::max(most.y, p.y), std::max(most.z, p.z)};
  }
  const Vector extent = most - least;
  const double scale = spec.size / std::max({extent.x, extent.y, extent.z});
  const Vector below = {0.5 * (least.x + most.x), least.y, 0.5 * (least.z + most.z)};
  for (std::size_t i = 0; i < triangles_.places.size(); i += 3) {
    const std::array<float, 3> place = floats_of(scale * (turned(triangles_.places.data() + i) - below));
    std::copy(place.begin(), place.end(), triangles_.places.begin() + static_cast<std::ptrdiff_t>(i));
  }
  middle_ = {0, 0.5 * scale * extent.y, 0};
  radius_ = 0.5 * scale * std::sqrt(dot(extent, extent)) * (1 + 1e-6);  // and what rounding to float adds
}

// Rays are begun where they enter the ball about the mesh: from afar a float would lose the place.
std::optional<Hit> Mesh::find(Vector from, Vector direction) const {
  const Vector to = middle_ - from;
  const double along = dot(to, direction);
  if (dot(to, to) - along * along > radius_ * radius_) return std::nullopt;
  const std::array<float, 3> begin = floats_of(from + (along - 1.01 * radius_) * direction);
  const std::array<float, 3> way = floats_of(direction);
  TriangleHit found;
  if (!tracer_->find(begin.data(), way.data(), found)) return std::nullopt;
  const Vector first = corner(found.triangle, 0);
  const Vector across = corner(found.triangle, 1) - first;
  const Vector down = corner(found.triangle, 2) - first;
  const Vector normal = cross(across, down);
  const double length = std::sqrt(dot(normal, normal)) * (dot(normal, direction) > 0 ? -1 : 1);
  return Hit{first + static_cast<double>(found.u) * across + static_cast<double>(found.v) * down,
             length == 0 ? -1 * direction : (1 / length) * normal, Shape::mesh};
}

bool Mesh::hides(const Hit& hit, Vector direction) const {
  Vector from = hit.place;
  if (hit.shape == Shape::mesh) {
    if (direction.y < 0) return true;
    // A triangle must not hide itself, and it is as exact as floats are.
    constexpr double beyond_rounding = 0x1p-16;
    const double largest = std::max({std::fabs(from.x), std::fabs(from.y), std::fabs(from.z), radius_});
    from = from + beyond_rounding * largest * hit.normal;
  } else {
    const Vector to = middle_ - from;
    const double along = dot(to, direction);
    const double distance2 = dot(to, to);
    if (distance2 - along * along > radius_ * radius_) return false;
    if (along < 0 && distance2 > radius_ * radius_) return false;
    if (distance2 > 4 * radius_ * radius_) from = from + (along - 1.01 * radius_) * direction;
  }
  const std::array<float, 3> begin = floats_of(from);
  const std::array<float, 3> way = floats_of(direction);
  return tracer_->meets(begin.data(), way.data());
}

}  // namespace noiseloom::render
