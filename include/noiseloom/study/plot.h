// Line plots as SVG text that stands alone or inside a page.
#pragma once

#include <string>
#include <vector>

namespace noiseloom {

struct PlotLine {
  std::string label;
  std::vector<double> x;
  std::vector<double> y;
  enum class Style { main, second, dashed } style = Style::main;
};

struct Plot {
  std::string title;  // read aloud by screen readers and shown as a tooltip
  std::string x_label;
  std::string y_label;
  bool log_y = false;  // points with y <= 0 are left out
  std::vector<PlotLine> lines;
};

// Ticks at 1, 2 or 5 times a power of ten, about `wanted` of them, inside lo..hi.
std::vector<double> linear_ticks(double lo, double hi, int wanted);

std::string plot_svg(const Plot& plot);

// The text with &, <, > and quotes escaped for XML and HTML.
std::string xml_escaped(const std::string& text);

}  // namespace noiseloom
