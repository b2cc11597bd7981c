// Meshes in the place of the sphere. Without the libraries that read and trace them, there is nothing to test but that
// this is said.
#include "render/world/mesh.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "noiseloom/core/error.h"
#include "noiseloom/core/math.h"
#include "render/scene_support.h"
#include "support/sanitizers.h"

namespace noiseloom::render {
namespace {

namespace fs = std::filesystem;

class Meshes : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("noiseloom-mesh-" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    try {
      mesh_library();
    } catch (const EnvironmentError& error) {
      EXPECT_NE(std::string(error.what()).find("Assimp and Embree"), std::string::npos);
      GTEST_SKIP() << error.what();
    }
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string file(const std::string& name, const std::string& text) const {
    std::ofstream((folder_ / name).string(), std::ios::binary) << text;
    return (folder_ / name).string();
  }
  Mesh mesh(const std::string& name, const std::string& text, double size = 2) const {
    return Mesh({.shape = ObjectShape::mesh, .file = file(name, text), .size = size});
  }
  std::string fault_of(const std::string& name, const std::string& text) const {
    try {
      mesh(name, text);
    } catch (const UserError& error) {
      return error.what();
    }
    return "no fault";
  }

  fs::path folder_;
};

// A sphere of so many parts around and from pole to pole, of radius 10 about (70, 80, 90).
std::string ball_text(int around, int down) {
  std::string vertices;
  std::string faces;
  for (int j = 0; j <= down; ++j)
    for (int i = 0; i < around; ++i) {
      const double polar = math::pi * j / down;
      const double azimuth = math::two_pi * i / around;
      vertices += "v " + std::to_string(70 + 10 * std::sin(polar) * std::cos(azimuth)) + " " +
                  std::to_string(80 + 10 * std::cos(polar)) + " " +
                  std::to_string(90 + 10 * std::sin(polar) * std::sin(azimuth)) + "\n";
      if (j == down) continue;
      const int next = (i + 1) % around;
      faces += "f " + std::to_string(j * around + i + 1) + " " + std::to_string(j * around + next + 1) + " " +
               std::to_string((j + 1) * around + next + 1) + " " + std::to_string((j + 1) * around + i + 1) + "\n";
    }
  return vertices + faces;
}

const std::string box_text =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 4 3 7 8\nf 1 4 8 5\nf 2 3 7 6\n";

std::string ply_text(const std::string& vertices, const std::string& faces, int num_vertices = 3) {
  return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(num_vertices) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
         "property list uchar int vertex_indices\nend_header\n" +
         vertices + faces;
}

std::string scene_text(const std::string& path, const std::string& more = "") {
  return "[image]\nwidth = 24\nheight = 20\nframes = 40\nrepeats = 1\n[[noise]]\nkind = \"white\"\n"
         "[effects.ambient-occlusion]\n[effects.soft-shadow]\n[object]\nshape = \"mesh\"\ntruth = 1024\nfile = \"" +
         path + "\"\n[filter.time]\nkernels = [\"mc\"]\n" + more;
}

TEST_F(Meshes, ABallOfTrianglesIsTheSphere) {
  const Mesh ball = mesh("ball.obj", ball_text(48, 24));
  EXPECT_GT(ball.num_left_out(), 0U);  // at the poles the faces have sides without a length
  ThreadPool pool(1);
  const Hits hits = make_hits(60, 48, pool, &ball);
  const Hits spheres = make_hits(60, 48, pool);
  int others = 0;
  for (std::size_t i = 0; i < hits.hits.size(); ++i) {
    others += (hits.hits[i].shape == Shape::plane) != (spheres.hits[i].shape == Shape::plane) ? 1 : 0;
    if (hits.hits[i].shape != Shape::mesh || spheres.hits[i].shape != Shape::sphere) continue;
    EXPECT_NEAR(hits.hits[i].place.y, spheres.hits[i].place.y, 0.03);
    EXPECT_GT(dot(hits.hits[i].normal, spheres.hits[i].normal), 0.98);
  }
  EXPECT_LT(others, 15);
  // What is hidden from places beside it, and from places on it, is what the closed forms say.
  for (const double distance : {0.5, 1.0, 2.0}) {
    const Hit hit = {{0, 0, distance}, {0, 1, 0}, Shape::plane};
    int open = 0;
    for (int i = 0; i < 4096; ++i) {
      const double v = i * 0.6180339887498949;
      open += is_hidden(hit, turned(cosine_direction((i + 0.5) / 4096, v - std::floor(v)), hit.normal), &ball) ? 0 : 1;
    }
    EXPECT_NEAR(open / 4096.0, open_share(hit), 0.01);
  }
}

TEST_F(Meshes, WhatIsFlatHidesNothingFromItself) {
  // A plate that stands apart from the plane would do as well: its upper side sees the whole sky.
  const Mesh plate =
      mesh("plate.obj", "v 0 5 0\nv 1 5 0\nv 1 5 1\nv 0 5 1\nv 0 0 0\nv 0.01 0 0\nv 0 0 0.01\nf 1 2 3 4\nf 5 6 7\n", 6);
  int on_plate = 0;
  for (int i = 0; i < 400; ++i) {
    const std::optional<Hit> hit = plate.find({0.0021 * i - 0.4, 30, 0.0017 * i - 0.3}, {0, -1, 0});
    ASSERT_TRUE(hit.has_value());
    EXPECT_GT(hit->normal.y, 0.999999);
    ++on_plate;
    for (const double cosine : {1.0, 0.5, 1e-3, 1e-7, 0.0})
      EXPECT_FALSE(plate.hides(*hit, turned(direction_at(cosine, 0.37 * i - std::floor(0.37 * i)), hit->normal)));
    EXPECT_TRUE(plate.hides(*hit, {0, -1, 0}));  // by the plane
  }
  EXPECT_EQ(on_plate, 400);
  for (const double distance : {1e6, 1e9})
    EXPECT_FALSE(plate.hides({{distance, 0, 0}, {0, 1, 0}, Shape::plane}, {-0.6, 0.8, 0}));
}

TEST_F(Meshes, NoRayPassesBetweenTrianglesThatShareAnEdge) {
  const Mesh box = mesh("box.obj", box_text);
  for (int i = -100; i <= 100; ++i) {
    const double at = 0.00999 * i;
    EXPECT_TRUE(box.find({at, 30, at}, {0, -1, 0}).has_value()) << i;  // along the diagonal of the upper side
    EXPECT_TRUE(box.find({at, 30, -at}, {0, -1, 0}).has_value()) << i;
    EXPECT_TRUE(box.hides({{at, 0, at}, {0, 1, 0}, Shape::plane}, {0, 1, 0})) << i;
  }
}

TEST_F(Meshes, EstimatesAreUnbiasedAndDoWhatThePlanSays) {
  const Scene scene = scene_of(scene_text(file("box.obj", box_text), "[effects.sky]\n"));
  const Result result = rendered(scene);
  EXPECT_EQ(result.notes.size(), 2U);
  for (const PassResult& one : result.passes) {
    EXPECT_EQ(one.counted, one.planned.work) << one.planned.pass->name;
    if (one.planned.pass->name == "mesh shares") {
      EXPECT_EQ(count_of(one.counted, Work::mesh_rays), 2 * 24 * 20 * 1024);
    }
  }
  for (std::size_t effect = 0; effect < 3; ++effect)
    EXPECT_NEAR(result.rmse(effect, 0, 1, 39).mean / result.rmse(effect, 0, 0, 39).mean, 1 / std::sqrt(40), 0.025);
  EXPECT_EQ(rendered(scene, 5).squares, result.squares);
  ThreadPool pool(1);
  for (const Data data : {Data::mesh, Data::shares}) {
    std::vector<Pass> passes(all_passes().begin(), all_passes().end());
    for (Pass& pass : passes)
      if (pass.needs.has(data)) pass.needs.flip(data);
    EXPECT_THROW(render(scene, noises_of(scene), pool, passes), std::logic_error) << name_of(data);
  }
}

TEST_F(Meshes, WhatMovesHasTheTruthOfWhatStays) {
  const std::string path = file("box.obj", box_text);
  const auto truth = [&](const std::string& more) {
    Scene scene = scene_of(scene_text(path, more));
    scene.outputs = {"images"};
    scene.frames = 3;
    return rendered(scene).truths.front();
  };
  const ResultPicture stays = truth("");
  const ResultPicture moves = truth("[motion]\ncamera = [1, 1.5]\nsphere = [-1, 0.5]\n");
  int seen = 0;
  for (int y = 0; y + 2 < 20; ++y)
    for (int x = 0; x + 4 < 24; ++x, ++seen)
      EXPECT_EQ(moves.values[static_cast<std::size_t>(24 * y + x)],
                stays.values[static_cast<std::size_t>(24 * (y + 2) + x + 4)]);
  EXPECT_EQ(seen, 360);
  EXPECT_THROW(truth("[motion]\ncamera = [1.5, 0]\n"), UserError);
  EXPECT_THROW(truth("[motion]\ncamera = [1e8, 0]\n"), UserError);
}

// The plan reads the file to say what it takes, and what is rendered is that: the file itself is then of no account.
TEST_F(Meshes, WhatThePlanHasReadIsNotReadAgain) {
  const std::string path = file("box.obj", box_text);
  const Scene scene = scene_of(scene_text(path));
  const std::vector<Noise> noises = noises_of(scene);
  const std::vector<double> squares = rendered(scene).squares;
  const auto planned = plan_passes(all_passes(), scene, noises);
  const auto bytes_planned = [](const auto& passes) {
    return std::find_if(passes.begin(), passes.end(), [](const auto& one) { return one.pass->name == "mesh"; })->bytes;
  };
  // Corners of the sides are not shared.
  EXPECT_EQ(bytes_planned(planned), bytes_of_triangles(24, 12));
  fs::remove(path);
  EXPECT_EQ(bytes_planned(plan_passes(all_passes(), scene, noises)), bytes_of_triangles(24, 12));
  EXPECT_EQ(rendered(scene).squares, squares);
  EXPECT_THROW(rendered(scene), UserError);  // nothing is kept beside the mesh
}

TEST_F(Meshes, NumbersBesideAGltfAreOfItsSize) {
  const std::string text = file("scene.gltf", "{\"asset\":1}");
  file("scene.bin", std::string(1000, 'x'));
  file("other.txt", std::string(77, 'x'));
  EXPECT_EQ(bytes_of_mesh_file(text), 1011U);
  EXPECT_EQ(bytes_of_mesh_file(file("scene.bin", std::string(1000, 'x'))), 1000U);
  EXPECT_EQ(bytes_of_mesh_file((folder_ / "none.gltf").string()), 0U);
}

TEST_F(Meshes, WrongFilesAreRefusedWithWhatIsWrong) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const std::string lines = "0 0 0\n1 0 0\n0 1 0\n";
  const struct {
    const char* name;
    std::string text;
    const char* words;
  } cases[] = {
      {"empty.obj", "", "is empty"},
      {"words.obj", "no mesh", "cannot be read as a mesh"},
      {"points.obj", corners, "cannot be read as a mesh"},
      {"nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", "has nan as the y of a vertex"},
      {"far.obj", "v 0 0 0\nv 1e39 0 0\nv 0 1 0\nf 1 2 3\n", "has inf as the x of a vertex"},
      {"line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "none of its triangles (1) has an area"},
      {"outside.obj", corners + "f 1 2 9\n", "out of range"},
      {"outside.ply", ply_text(lines, "3 0 1 7\n"), "the vertex 7 of 3"},
      {"cut.glb", std::string("glTF\2\0\0\0\377\0\0\0", 12), "cannot be read as a mesh"},
      {"picture.png", "x", "ends in \".png\""},
      {"noending", "x", "ends in \"\""},
  };
  for (const auto& one : cases) {
    const std::string fault = fault_of(one.name, one.text);
    EXPECT_NE(fault.find(one.words), std::string::npos) << one.name << ": " << fault;
    EXPECT_NE(fault.find(one.name), std::string::npos) << fault;
  }
  EXPECT_EQ(fault_of("whole.ply", ply_text(lines, "3 0 1 2\n")), "no fault");
  if (!testing_support::under_sanitizers) {  // which ends the program where memory is refused
    EXPECT_NE(fault_of("claim.ply", ply_text(lines, "3 0 1 2\n", 2'000'000'000)).find("more than its bytes can"),
              std::string::npos);
  }
  fs::resize_file(file("large.obj", corners), (std::uintmax_t{1} << 30) + 1);
  EXPECT_THROW(Mesh({.shape = ObjectShape::mesh, .file = (folder_ / "large.obj").string()}), UserError);
}

}  // namespace
}  // namespace noiseloom::render
