// What several tests of ladders work with.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/accuracy/accuracy_ladder.h"
#include "noiseloom/accuracy/accuracy_table.h"

namespace noiseloom {

inline std::vector<std::string> names_of(const std::vector<AccuracyPoint>& points) {
  std::vector<std::string> names;
  for (const AccuracyPoint& point : points) names.push_back(point_name(point));
  return names;
}

inline RunConfig config_with(const std::string& optimizer) {
  return parse_config(
      "[texture]\nsize = { x = 11, y = 7, t = 3 }\nsamples = \"uniform\"\n[filter]\ncombine = \"product\"\n"
      "groups = [ { axes = \"xy\", kernel = \"box\", size = 3 }, { axes = \"t\", kernel = \"box\", size = 3 } ]\n"
      "[optimizer]\n" +
          optimizer,
      "test.toml", "", {});
}

inline AccuracyRow row(Method method, std::int64_t n, double seconds, double r) {
  AccuracyRow result;
  result.point = {method, "iterations", std::to_string(n), n, false};
  result.iterations = n;
  result.seed = 7;
  result.threads = 2;
  result.add({seconds, r, r * 1.01, r * 1.0001});
  result.command = "noiseloom generate \"my, config\".toml --set 'optimizer.stop.iterations=" + std::to_string(n) + "'";
  return result;
}

inline std::vector<AccuracyRow> some_rows() {
  std::vector<AccuracyRow> rows = {row(Method::anneal, 25, 1, 0.4), row(Method::anneal, 50, 2, 0.21),
                                   row(Method::anneal, 100, 10, 0.2), row(Method::fast, 10, 3, 0.5)};
  rows[1].point = {Method::anneal, "", "", 50, true};
  rows.push_back(row(Method::anneal, 50, 4, 0.22));
  rows.back().point = {Method::anneal, "cutoff", "0.05", 50, false};
  rows.back().r_8bit.reset();
  rows.back().r_16bit.reset();
  return rows;
}

inline const std::string order_config =
    "[texture]\nsize = { x = 8, y = 8, t = 4 }\n[filter]\ncombine = \"sum\"\n"
    "groups = [ { axes = \"xy\", kernel = \"gauss-energy\" }, { axes = \"t\", kernel = \"gauss-energy\" } ]\n"
    "[optimizer]\nmethod = \"void-and-cluster\"\n";

}  // namespace noiseloom
