// What several tests of ladders work with.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/accuracy/accuracy_ladder.h"

namespace noiseloom {

inline std::vector<std::string> names_of(const std::vector<AccuracyPoint>& points) {
  std::vector<std::string> names;
  for (const AccuracyPoint& point : points) names.push_back(point_name(point));
  return names;
}

inline const std::string order_config =
    "[texture]\nsize = { x = 8, y = 8, t = 4 }\n[filter]\ncombine = \"sum\"\n"
    "groups = [ { axes = \"xy\", kernel = \"gauss-energy\" }, { axes = \"t\", kernel = \"gauss-energy\" } ]\n"
    "[optimizer]\nmethod = \"void-and-cluster\"\n";

}  // namespace noiseloom
