#include "config/toy_scene.h"

#include "noiseloom/config/settings_reader.h"

namespace noiseloom::toy {
namespace {

using settings::above;
using settings::at_least;
using settings::Condition;
using settings::Field;
using settings::Found;
using settings::Owners;
using settings::Reader;
using settings::Setting;
using settings::Type;
using settings::Value;
using settings::Word;

constexpr Word shapes[] = {{"sphere", "all points at one distance", "ball"}, {"plane", "flat"}, {"mesh", "triangles"}};
constexpr Word edges[] = {{"depth", "distance from the camera"}, {"normal", "direction of the surface"}};
constexpr Word skies[] = {{"clear", "nothing"}, {"cloudy", "noise", "overcast"}};

constexpr Condition with_shape(std::string_view word) { return {"object[].shape", word}; }

void radius_of_shape(const Owners& owners) {
  Object& object = owners.get<Object>();
  object.radius = object.shape == Shape::mesh ? 0 : 1;
}

void check_objects(Reader& reader, const Found& found) {
  if (found.owners.get<Scene>().objects.size() > 3) reader.fault(found.value.place, found.shown + ": more than three");
}

void check_scene(Reader& reader, const Value& root, const Owners& owners) {
  const Value* pan = settings::find_at(root, "camera.pan");
  if (pan != nullptr && owners.get<Scene>().pan.size() != 2) reader.fault(*pan, "camera.pan", "must have two numbers");
}

std::span<const Setting> table() {
  static const Setting rows[] = {
      {.key = "title",
       .type = Type::text,
       .sentence = "What it shows.",
       .field = [](Scene& s) -> Field { return &s.title; }},
      {.key = "image", .type = Type::table, .sentence = "What is rendered.", .required = true},
      {.key = "image.width",
       .type = Type::integer,
       .sentence = "Width.",
       .field = [](Scene& s) -> Field { return &s.width; },
       .range = at_least(1, 4096),
       .unit = "pixels",
       .required = true},
      {.key = "image.frames",
       .type = Type::integer,
       .sentence = "Images in a row.",
       .field = [](Scene& s) -> Field { return &s.frames; }},
      {.key = "image.exposure",
       .type = Type::duration,
       .sentence = "Time of one frame.",
       .field = [](Scene& s) -> Field { return &s.exposure_s; },
       .range = above(0),
       .zero_is_unset = true},
      {.key = "camera", .type = Type::table, .sentence = "Where it is seen from."},
      {.key = "camera.pan",
       .type = Type::number,
       .sentence = "Movement in a frame.",
       .field = [](Scene& s) -> Field { return &s.pan; },
       .list = true,
       .range = at_least(-9, 9)},
      {.key = "camera.lenses",
       .type = Type::integer,
       .sentence = "Focal lengths.",
       .field = [](Scene& s) -> Field { return &s.lenses; },
       .list = true,
       .range = at_least(1),
       .required = true},
      {.key = "object",
       .type = Type::tables,
       .sentence = "What is seen.",
       .field = [](Scene& s) -> Field { return &s.objects; },
       .example = "{ shape = \"plane\" }",
       .check = check_objects},
      {.key = "object[].shape",
       .type = Type::word,
       .sentence = "What it is.",
       .field = [](Object& o) -> Field { return &o.shape; },
       .words = shapes,
       .required = true,
       .chosen = radius_of_shape},
      {.key = "object[].radius",
       .type = Type::number,
       .sentence = "Size.",
       .field = [](Object& o) -> Field { return &o.radius; },
       .range = above(0),
       .when = with_shape("sphere")},
      {.key = "object[].file",
       .type = Type::file,
       .sentence = "Triangles.",
       .field = [](Object& o) -> Field { return &o.file; },
       .when = with_shape("mesh"),
       .required = true},
      {.key = "object[].double_sided",
       .type = Type::boolean,
       .sentence = "Seen from both sides.",
       .field = [](Object& o) -> Field { return &o.double_sided; },
       .when = {"object[].shape", "mesh plane"}},
      {.key = "object[].hole",
       .type = Type::tables,
       .sentence = "What is cut out.",
       .field = [](Object& o) -> Field { return &o.holes; },
       .when = with_shape("plane")},
      {.key = "object[].hole[].x",
       .type = Type::number,
       .sentence = "Where.",
       .field = [](Hole& h) -> Field { return &h.x; },
       .required = true},
      {.key = "object[].hole[].radius",
       .type = Type::number,
       .sentence = "How large.",
       .field = [](Hole& h) -> Field { return &h.radius; },
       .range = above(0, 1)},
      {.key = "effects", .type = Type::table, .sentence = "What is simulated."},
      {.key = "effects.ambient-occlusion",
       .type = Type::table,
       .sentence = "Off unless it is written.",
       .field = [](Scene& s) -> Field { return &s.has_occlusion; },
       .when = {"sky", "cloudy"}},
      {.key = "effects.ambient-occlusion.samples",
       .type = Type::integer,
       .sentence = "Rays.",
       .field = [](Scene& s) -> Field { return &s.occlusion_samples; },
       .range = at_least(1)},
      {.key = "filter", .type = Type::table, .sentence = "What is done to the image."},
      {.key = "filter.edges",
       .type = Type::word,
       .sentence = "What stops it.",
       .field = [](Scene& s) -> Field { return &s.edges; },
       .list = true,
       .words = edges},
      {.key = "filter.clamp", .type = Type::table, .sentence = "One of two ways.", .one_of = true},
      {.key = "filter.clamp.width",
       .sentence = "Deviations.",
       .field = [](Scene& s) -> Field { return &s.clamp_width; },
       .range = above(0),
       .zero_is_unset = true},
      {.key = "filter.clamp.level",
       .sentence = "Level.",
       .field = [](Scene& s) -> Field { return &s.clamp_level; },
       .range = above(0),
       .zero_is_unset = true},
      {.key = "expect", .type = Type::table, .sentence = "What must come out."},
      {.key = "expect.order",
       .type = Type::text,
       .sentence = "Which is better.",
       .field = [](Scene& s) -> Field { return &s.order; },
       .list = true},
      {.key = "sky",
       .type = Type::word,
       .sentence = "Weather.",
       .field = [](Scene& s) -> Field { return &s.sky; },
       .words = skies},
  };
  return rows;
}

}  // namespace

const settings::FileKind& scene_kind() {
  static const settings::FileKind kind =
      settings::file_kind<Scene>({.noun = "scene", .settings = table(), .check = check_scene});
  return kind;
}

}  // namespace noiseloom::toy
