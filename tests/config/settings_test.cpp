// Any kind of file that a table describes is read, overridden, explained and stored alike: tried with a small scene.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/toy_scene.h"
#include "noiseloom/config/settings_file.h"

namespace noiseloom::toy {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

constexpr const char* whole = R"(title = "two \"things\""
sky = "cloudy"

[image]
width = 128
frames = 64
exposure = "1m30s"

[camera]
pan = [3, -0.5]
lenses = [28, 50]

[[object]]
shape = "sphere"
radius = 2

[[object]]
shape = "mesh"
file = "a.ply"
double_sided = true

[[object]]
shape = "plane"
hole = [{ x = 1 }, { x = -2, radius = 0.25 }]

[effects]
ambient-occlusion = {}

[filter]
edges = ["normal", "depth"]
clamp = { level = 0.5 }

[expect]
order = ["fast < stbn"]
)";

settings::Parsed<Scene> parsed(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return settings::parse<Scene>(scene_kind(), {.text = text, .name = "s.toml", .folder = "models"}, overrides,
                                MissingFiles::accepted);
}

std::vector<std::string> faults_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  std::vector<std::string> lines;
  try {
    parsed(text, overrides);
  } catch (const UserError& error) {
    for (const Fault& fault : error.faults()) lines.push_back(fault.where + ": " + fault.text);
  }
  return lines;
}

// A sound scene; `lines` begin at line 5.
std::string with(const std::string& lines) { return "[image]\nwidth = 8\n[camera]\nlenses = [50]\n" + lines + "\n"; }

TEST(Settings, ReadEveryType) {
  const Scene scene = parsed(whole).value;
  EXPECT_EQ(scene.title, "two \"things\"");
  EXPECT_EQ(scene.width, 128);
  EXPECT_EQ(scene.frames, 64);
  EXPECT_EQ(scene.exposure_s, 90);
  EXPECT_THAT(scene.pan, ElementsAre(3, -0.5));
  EXPECT_THAT(scene.lenses, ElementsAre(28, 50));
  ASSERT_EQ(scene.objects.size(), 3U);
  EXPECT_EQ(scene.objects[0].shape, Shape::sphere);
  EXPECT_EQ(scene.objects[0].radius, 2);
  EXPECT_EQ(scene.objects[1].shape, Shape::mesh);
  EXPECT_EQ(scene.objects[1].file, "models/a.ply");
  EXPECT_EQ(scene.objects[1].radius, 0) << "a default that depends on the word";
  EXPECT_TRUE(scene.objects[1].double_sided);
  ASSERT_EQ(scene.objects[2].holes.size(), 2U);
  EXPECT_EQ(scene.objects[2].holes[0].radius, 0.5);
  EXPECT_EQ(scene.objects[2].holes[1].x, -2);
  EXPECT_EQ(scene.objects[2].holes[1].radius, 0.25);
  EXPECT_TRUE(scene.has_occlusion);
  EXPECT_THAT(scene.edges, ElementsAre("normal", "depth"));
  EXPECT_EQ(scene.clamp_level, 0.5);
  EXPECT_THAT(scene.order, ElementsAre("fast < stbn"));
  EXPECT_EQ(scene.sky, "cloudy");
}

TEST(Settings, LeaveDefaultsWhereNothingIsSaid) {
  const Scene scene = parsed(with("")).value;
  EXPECT_EQ(scene.title, "untitled");
  EXPECT_EQ(scene.frames, 1);
  EXPECT_THAT(scene.objects, IsEmpty());
  EXPECT_FALSE(scene.has_occlusion);
  EXPECT_EQ(scene.sky, "clear");
}

TEST(Settings, StoreTextThatReadsBackAsTheSame) {
  const settings::Parsed<Scene> scene = parsed(whole);
  const std::string text = settings::to_toml(scene_kind(), scene.value, scene.written_paths);
  EXPECT_EQ(text, R"(title = "two \"things\""
sky = "cloudy"

[image]
width = 128
frames = 64
exposure = "90s"

[camera]
pan = [3.0, -0.5]
lenses = [28, 50]

[[object]]
shape = "sphere"
radius = 2.0

[[object]]
shape = "mesh"
file = "a.ply"
double_sided = true

[[object]]
shape = "plane"
double_sided = false
hole = [
  { x = 1.0, radius = 0.5 },
  { x = -2.0, radius = 0.25 },
]

[effects]
ambient-occlusion = { samples = 4 }

[filter]
edges = ["normal", "depth"]
clamp = { level = 0.5 }

[expect]
order = ["fast < stbn"]
)");
  const settings::Parsed<Scene> again = parsed(text);
  EXPECT_EQ(settings::to_toml(scene_kind(), again.value, again.written_paths), text);
}

TEST(Settings, NameMissingKeysInTheWordsOfTheirKind) {
  EXPECT_THAT(faults_of(""), ElementsAre("s.toml: image: missing; a scene needs the table [image]"));
  EXPECT_THAT(faults_of("[image]\n[camera]"),
              ElementsAre("s.toml:1: image.width: missing; must be an integer, from 1 to 4096",
                          "s.toml:2: camera.lenses: missing; must be a list; each element an integer, at least 1"));
  EXPECT_THAT(faults_of(with("[[object]]\nshape = \"mesh\"\n[[object]]\n")),
              ElementsAre("s.toml:5: object[0].file: missing; must be the name of a file",
                          "s.toml:7: object[1].shape: missing; must be one of sphere, plane, mesh"));
}

TEST(Settings, NameEveryFaultWithItsLine) {
  EXPECT_THAT(
      faults_of("title = 3\n[image]\nwidth = 0\nframes = 1.5\nexposure = \"soon\"\n[camera]\npan = [1, \"b\", 10]\n"
                "lenses = [3000000000]\n[filter]\nedges = [\"depht\"]\n[expect]\norder = \"a < b\"\n"),
      ElementsAre(
          "s.toml:1: title = 3: must be text in quotes", "s.toml:3: image.width = 0: must be from 1 to 4096",
          "s.toml:4: image.frames = 1.5: must be an integer",
          StartsWith("s.toml:5: image.exposure = \"soon\": must be a duration"),
          "s.toml:7: camera.pan[1] = \"b\": must be a number, from -9 to 9",
          "s.toml:7: camera.pan[2] = 10: must be from -9 to 9",
          "s.toml:7: camera.pan = [1, \"b\", 10]: must have two numbers",
          "s.toml:8: camera.lenses[0] = 3000000000: must be from -2147483648 to 2147483647",
          "s.toml:10: filter.edges[0] = \"depht\": unknown edges; did you mean \"depth\"? accepted: depth, normal",
          "s.toml:12: expect.order = \"a < b\": must be a list; each element text in quotes"));
}

TEST(Settings, ReportInNestedLists) {
  EXPECT_THAT(faults_of(with("[[object]]\nshape = \"plane\"\nhole = [{ x = 1 }, { x = 2, radius = 2 }, { y = 1 }]")),
              ElementsAre("s.toml:7: object[0].hole[1].radius = 2: must be greater than 0 and at most 1",
                          "s.toml:7: object[0].hole[2].x: missing; must be a number",
                          "s.toml:7: object[0].hole[2].y: unknown key; did you mean \"x\"? accepted: x, radius"));
  EXPECT_THAT(faults_of(with("object = 3")), ElementsAre(HasSubstr("unknown key"))) << "it belongs to [camera] there";
  EXPECT_THAT(faults_of("object = 3\n" + with("")),
              ElementsAre("s.toml:1: object = 3: must be a list of tables such as { shape = \"plane\" }"));
  EXPECT_THAT(faults_of(with("[[object]]\nshape = \"plane\"\n[[object]]\nshape = \"plane\"\n[[object]]\nshape = "
                             "\"plane\"\n[[object]]\nshape = \"plane\"\n")),
              ElementsAre(HasSubstr("object: more than three")));
}

TEST(Settings, SuggestWordsAndKeysOfOtherTables) {
  EXPECT_THAT(faults_of(with("[[object]]\nshape = \"ball\"")),
              ElementsAre("s.toml:6: object[0].shape = \"ball\": unknown shape; did you mean \"sphere\"? accepted: "
                          "sphere, plane, mesh"));
  EXPECT_THAT(faults_of(with("[filter]\npan = [1, 2]")),
              ElementsAre("s.toml:6: filter.pan: unknown key; did you mean \"camera.pan\"? accepted: edges, clamp"));
  EXPECT_THAT(faults_of(with("[filter]\nradius = 1")),
              ElementsAre(HasSubstr("did you mean \"object[].radius\" or \"object[].hole[].radius\"?")));
  EXPECT_THAT(faults_of(with(""), {"widht=3"}),
              ElementsAre("--set widht=3: widht: unknown key; did you mean \"image.width\" or \"filter.clamp.width\"? "
                          "accepted: title, image, camera, object, effects, filter, expect, sky"));
  EXPECT_THAT(faults_of(with(""), {"hole[2].x=3"}), ElementsAre(HasSubstr("did you mean \"object[0].hole\"?")));
}

TEST(Settings, ApplyUnderTheirConditions) {
  EXPECT_THAT(
      faults_of(with("[[object]]\nshape = \"plane\"\nradius = 3")),
      ElementsAre("s.toml:7: object[0].radius = 3: applies only with shape = \"sphere\"; here it is \"plane\""));
  EXPECT_THAT(faults_of(with("[[object]]\nshape = \"sphere\"\ndouble_sided = true")),
              ElementsAre(HasSubstr("applies only with shape = \"mesh\" or \"plane\"; here it is \"sphere\"")));
  EXPECT_THAT(faults_of(with("[effects]\nambient-occlusion = {}")), ElementsAre(HasSubstr("with sky = \"cloudy\"")));
  EXPECT_THAT(faults_of("sky = \"foggy\"\n" + with("[effects]\nambient-occlusion = {}")),
              ElementsAre(StartsWith("s.toml:1: sky = \"foggy\": unknown sky")))
      << "nothing follows from a word that is in fault";
}

TEST(Settings, OverridesReachEveryDepth) {
  const std::string mesh = "[[object]]\nshape = \"plane\"\nhole = [{ x = 1 }]";
  const Scene scene = parsed(with(mesh), {"image.width=9", "object[0].hole[0].radius=0.125", "object[0].hole[1].x=7",
                                          "object[1].shape=sphere", "sky=cloudy", "effects.ambient-occlusion.samples=2",
                                          "camera.pan[0]=1", "camera.pan[1]=2"})
                          .value;
  EXPECT_EQ(scene.width, 9);
  ASSERT_EQ(scene.objects.size(), 2U);
  ASSERT_EQ(scene.objects[0].holes.size(), 2U);
  EXPECT_EQ(scene.objects[0].holes[0].radius, 0.125);
  EXPECT_EQ(scene.objects[0].holes[1].x, 7);
  EXPECT_EQ(scene.objects[1].shape, Shape::sphere);
  EXPECT_TRUE(scene.has_occlusion);
  EXPECT_EQ(scene.occlusion_samples, 2);
  EXPECT_THAT(scene.pan, ElementsAre(1, 2));
  EXPECT_THAT(faults_of(with(""), {"object[2].shape=plane"}),
              ElementsAre("--set object[2].shape=plane: the list has 0 elements, counted from 0"));
  EXPECT_THAT(faults_of(with(""), {"nonsense"}), ElementsAre("--set nonsense: must be KEY=VALUE with a dotted key"));
}

TEST(Settings, HoldOneOfSeveralRules) {
  const std::string clamp = "[filter]\nclamp = { level = 0.5 }";
  const Scene scene = parsed(with(clamp), {"filter.clamp.width=2"}).value;
  EXPECT_EQ(scene.clamp_width, 2);
  EXPECT_EQ(scene.clamp_level, 0);
  EXPECT_THAT(
      faults_of(with("[filter]\nclamp = { level = 0.5, width = 1 }")),
      ElementsAre("s.toml:6: filter.clamp = { level = 0.5, width = 1 }: must have exactly one of width, level"));
}

TEST(Settings, AreExplained) {
  const std::string help = settings::describe(scene_kind());
  EXPECT_THAT(help, AllOf(StartsWith("  title\n      text in quotes; default \"untitled\"\n      What it shows.\n"),
                          HasSubstr("\n[image]  What is rendered.\n"), HasSubstr("\n[[object]]  What is seen.\n"),
                          HasSubstr("  image.width\n      an integer, from 1 to 4096; pixels; required\n"),
                          HasSubstr("  object[].radius\n      a number, greater than 0; default 1.0; with shape = "
                                    "\"sphere\"\n"),
                          HasSubstr("  object[].hole[].radius\n      a number, greater than 0 and at most 1; default "
                                    "0.5\n"),
                          HasSubstr("        sphere             all points at one distance\n")));
  EXPECT_THAT(help, Not(HasSubstr("default \"\"")));
}

TEST(Settings, KeepTheLinesOfGarbageToAHundred) {
  std::string text = with("");
  for (int i = 0; i < 3000; ++i) text += "key" + std::to_string(i) + " = 1\n";
  const std::vector<std::string> faults = faults_of(text);
  ASSERT_EQ(faults.size(), 101U);
  EXPECT_THAT(faults.front(), StartsWith("s.toml:6: camera.key0: unknown key"));
  EXPECT_EQ(faults.back(), "s.toml: 2900 faults more");
}

}  // namespace
}  // namespace noiseloom::toy
