// A second kind of file, small and with every type that a table of settings can describe: what the tests of the generic
// reader, writer and help are made with.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/config/settings.h"

namespace noiseloom::toy {

enum class Shape { sphere, plane, mesh };

struct Hole {
  double x = 0;
  double radius = 0.5;
};

struct Object {
  Shape shape = Shape::sphere;
  double radius = 1;
  std::string file;
  bool double_sided = false;
  std::vector<Hole> holes;
};

struct Scene {
  std::string title = "untitled";
  int width = 64;
  std::int64_t frames = 1;
  double exposure_s = 0;  // 0: not said
  std::vector<double> pan;
  std::vector<std::string> edges;
  std::vector<std::string> order;
  std::vector<int> lenses = {35};
  std::vector<Object> objects;
  bool has_occlusion = false;
  int occlusion_samples = 4;
  std::string sky = "clear";
  double clamp_width = 0;
  double clamp_level = 0;
};

const settings::FileKind& scene_kind();

}  // namespace noiseloom::toy
