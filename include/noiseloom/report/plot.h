// Line plots as SVG text that stands alone or inside a page.
#pragma once

#include <string>
#include <vector>

namespace noiseloom {

struct PlotLine {
  std::string label;
  std::vector<double> x;
  std::vector<double> y;
  // third, fourth, sixth and further: broken, so that what lies below them is seen
  // front: broad and pale, to lie under other lines; points: markers alone
  enum class Style {
    main,
    second,
    third,
    fourth,
    fifth,
    sixth,
    seventh,
    eighth,
    dashed,
    front,
    points
  } style = Style::main;
  std::vector<std::string> names = {};  // of the points: each then has a marker that shows its name under the mouse
  std::vector<std::string> notes = {};  // short ones that stand at the points, where there is room
  std::vector<double> low = {};         // of the points: where an upright line through each begins, along y,
  std::vector<double> high = {};        // and ends
  bool has_band = false;                // low to high are one area along the line instead
};
// Of the lines of a plot, counted from 0: those of main to eighth, and from the first again.
PlotLine::Style style_of_line(std::size_t number);

// A point that is singled out by a ring and words beside it.
struct PlotMark {
  std::string label;
  double x = 0;
  double y = 0;
};

struct Plot {
  std::string title;  // read aloud by screen readers and shown as a tooltip
  std::string x_label;
  std::string y_label;
  bool log_y = false;  // points with y <= 0 are left out
  std::vector<PlotLine> lines;
  bool log_x = false;  // points with x <= 0 are left out
  std::vector<PlotMark> marks = {};
  double width = 620;  // of the view, in units of which the text is 12 high
  double height = 300;
};

// Ticks at 1, 2 or 5 times a power of ten, about `wanted` of them, inside lo..hi.
std::vector<double> linear_ticks(double lo, double hi, int wanted);

std::string plot_svg(const Plot& plot);

// The axes of a picture of a spectrum: both run from -1/2 to 1/2, zero in the middle.
struct PictureAxes {
  std::string title;
  std::string x_label;
  std::string y_label;
};
// The picture, one unit a pixel, with its axes. `image_source`: a URL, such as data:image/png;base64,...
std::string picture_with_axes(const std::string& image_source, int width, int height, const PictureAxes& axes);
// How wide that is for a picture of so many pixels.
int picture_width_with_axes(int width);

// The text with &, <, > and quotes escaped for XML and HTML.
std::string xml_escaped(const std::string& text);

}  // namespace noiseloom
