// Settings of [object], which rests on the plane.
#include "render/scene/scene_settings.h"

namespace noiseloom::render {
namespace {

// In the order of ObjectShape.
constexpr Word shape_words[] = {
    {"sphere", "of radius 1: occlusion and shadow have closed forms", "ball"},
    {"mesh", "triangles of a file; only where noiseloom was built with Assimp and Embree", "triangles file"},
};

// In the order of UpAxis.
constexpr Word axis_words[] = {{"y", "as in glTF and most OBJ files"}, {"z", "as in Blender and most scans"}};

constexpr settings::Condition of_mesh = {"object.shape", "mesh"};

}  // namespace

std::vector<Setting> rows_of_object() {
  return {
      {.key = "object",
       .type = Type::table,
       .sentence = "What rests on the plane, for ambient-occlusion, soft-shadow and sky."},
      {.key = "object.shape",
       .type = Type::word,
       .sentence = "What it is.",
       .field = [](Scene& s) -> Field { return &s.object.shape; },
       .words = shape_words},
      {.key = "object.file",
       .type = Type::file,
       .sentence = "The mesh: a file that ends in .obj, .ply, .gltf, .glb or .stl. It is scaled, and set down on "
                   "the plane with its middle where that of the sphere was.",
       .field = [](Scene& s) -> Field { return &s.object.file; },
       .when = of_mesh,
       .required = true},
      {.key = "object.size",
       .type = Type::number,
       .sentence = "Its largest extent; the picture shows 6 from left to right.",
       .field = [](Scene& s) -> Field { return &s.object.size; },
       .range = at_least(0.01, 10),
       .when = of_mesh},
      {.key = "object.up",
       .type = Type::word,
       .sentence = "The axis of the file that points upward.",
       .field = [](Scene& s) -> Field { return &s.object.up; },
       .words = axis_words,
       .when = of_mesh},
      {.key = "object.turn",
       .type = Type::number,
       .sentence = "How far it is turned about the vertical.",
       .field = [](Scene& s) -> Field { return &s.object.turn; },
       .range = at_least(-360, 360),
       .unit = "degrees",
       .when = of_mesh},
      {.key = "object.truth",
       .type = Type::integer,
       .sentence =
           "Directions of each pixel of which its truth is the mean, as a mesh has no closed form. How far that "
           "is off is said with the results.",
       .field = [](Scene& s) -> Field { return &s.object.truth; },
       .range = at_least(16, 1 << 20),
       .when = of_mesh},
  };
}

}  // namespace noiseloom::render
