#include "noiseloom/report/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace noiseloom {
namespace {

constexpr double left = 58;
constexpr double right = 14;
constexpr double top = 34;
constexpr double bottom = 46;

// One axis: data to pixels.
struct Scale {
  double lo = std::numeric_limits<double>::infinity();
  double hi = -std::numeric_limits<double>::infinity();
  double from = 0;
  double to = 0;
  bool log = false;

  bool holds(double v) const { return std::isfinite(v) && (!log || v > 0); }
  void include(double v) {
    if (!holds(v)) return;
    lo = std::min(lo, v);
    hi = std::max(hi, v);
  }
  // Makes an interval of what was included, however little that was.
  void settle() {
    if (!(lo <= hi)) lo = hi = log ? 1 : 0;
    if (lo == hi) hi = log ? 2 * lo : lo + 1;
  }
  // Room for markers at both ends of a logarithmic axis.
  void widen(double share) {
    if (!log) return;
    const double factor = std::pow(hi / lo, share);
    lo /= factor;
    hi *= factor;
  }
  double operator()(double v) const {
    const double t = log ? (std::log10(v) - std::log10(lo)) / (std::log10(hi) - std::log10(lo)) : (v - lo) / (hi - lo);
    return from + (to - from) * t;
  }
};

// Powers of ten inside lo..hi and 2 and 5 times them; the powers alone where that would be many, even steps where they
// would be few.
std::vector<double> log_ticks(double lo, double hi) {
  if (hi / lo < 8) return linear_ticks(lo, hi, 5);
  const bool many = hi / lo > 5000;
  std::vector<double> ticks;
  for (int e = static_cast<int>(std::floor(std::log10(lo))); e <= static_cast<int>(std::ceil(std::log10(hi))); ++e)
    for (const double m : {1.0, 2.0, 5.0}) {
      const double tick = m * std::pow(10.0, e);
      if ((m == 1.0 || !many) && tick >= lo * 0.999 && tick <= hi * 1.001) ticks.push_back(tick);
    }
  return ticks;
}

std::string tick_text(double v) {
  if (std::abs(v) < 1e-12) return "0";
  return std::abs(v) >= 1e5 || std::abs(v) < 1e-3 ? fmt::format("{:.0e}", v) : fmt::format("{:.4g}", v);
}

const char* style_class(PlotLine::Style style) {
  switch (style) {
    case PlotLine::Style::main:
      return "nl-main";
    case PlotLine::Style::second:
      return "nl-second";
    case PlotLine::Style::third:
      return "nl-third";
    case PlotLine::Style::fourth:
      return "nl-fourth";
    case PlotLine::Style::fifth:
      return "nl-fifth";
    case PlotLine::Style::dashed:
      return "nl-dashed";
    case PlotLine::Style::front:
      return "nl-front";
    case PlotLine::Style::points:
      return "nl-points";
  }
  return "";
}

std::string axes_svg(const Plot& plot, const Scale& x, const Scale& y) {
  std::string svg;
  for (const double tick : y.log ? log_ticks(y.lo, y.hi) : linear_ticks(y.lo, y.hi, 5)) {
    svg += fmt::format("<line class='nl-grid' x1='{:.1f}' x2='{:.1f}' y1='{:.1f}' y2='{:.1f}'/>", x.from, x.to, y(tick),
                       y(tick));
    svg += fmt::format("<text class='nl-tick' text-anchor='end' x='{:.1f}' y='{:.1f}'>{}</text>\n", x.from - 7,
                       y(tick) + 4, tick_text(tick));
  }
  for (const double tick : x.log ? log_ticks(x.lo, x.hi) : linear_ticks(x.lo, x.hi, 7)) {
    svg += fmt::format("<line class='nl-axis' x1='{0:.1f}' x2='{0:.1f}' y1='{1:.1f}' y2='{2:.1f}'/>", x(tick), y.from,
                       y.from + 5);
    svg += fmt::format("<text class='nl-tick' text-anchor='middle' x='{:.1f}' y='{:.1f}'>{}</text>\n", x(tick),
                       y.from + 18, tick_text(tick));
  }
  svg += fmt::format("<line class='nl-axis' x1='{:.1f}' x2='{:.1f}' y1='{:.1f}' y2='{:.1f}'/>\n", x.from, x.to, y.from,
                     y.from);
  svg += fmt::format("<text class='nl-label' text-anchor='middle' x='{:.1f}' y='{:.1f}'>{}</text>\n",
                     (x.from + x.to) / 2, plot.height - 8, xml_escaped(plot.x_label));
  svg += fmt::format("<text class='nl-label' x='{:.1f}' y='16'>{}</text>\n", 4.0, xml_escaped(plot.y_label));
  return svg;
}

std::string legend_svg(const Plot& plot) {
  std::string svg;
  double end = plot.width - right;
  for (auto line = plot.lines.rbegin(); line != plot.lines.rend(); ++line) {
    if (line->label.empty()) continue;
    const double begin = end - 6.6 * static_cast<double>(line->label.size());
    svg += fmt::format("<text class='nl-label' x='{:.1f}' y='16'>{}</text>", begin, xml_escaped(line->label));
    if (line->style == PlotLine::Style::points)
      svg += fmt::format("<circle class='nl-points' cx='{:.1f}' cy='12' r='4'/>\n", begin - 13);
    else
      svg += fmt::format("<line class='{}' x1='{:.1f}' x2='{:.1f}' y1='12' y2='12'/>\n", style_class(line->style),
                         begin - 30, begin - 7);
    end = begin - 50;
  }
  return svg;
}

// The words of a mark stand above its ring, to the right of it where there is room for them.
double mark_width(const PlotMark& mark) { return 7.0 * static_cast<double>(mark.label.size()); }
bool mark_on_right(const PlotMark& mark, const Plot& plot, const Scale& x) {
  return x(mark.x) + mark_width(mark) < plot.width - right;
}

// Puts short texts at points so that none lies on another or on a marker.
class NotePlacer {
 public:
  void avoid_marker(double x, double y) { taken_.push_back({x - 4, x + 4, y - 4, y + 4}); }
  void avoid_text(double begin, double base, double width) {
    taken_.push_back({begin, begin + width, base - 9, base + 1});
  }

  // Below to the left of the point, where a falling curve leaves room, else above to the right, else nothing.
  std::string svg(const std::string& text, double x, double y) {
    const double width = 5.8 * static_cast<double>(text.size());
    for (const bool below : {true, false}) {
      const double begin = below ? x - 6 - width : x + 6;
      const double base = below ? y + 14 : y - 6;
      const Box box{begin, begin + width, base - 9, base + 1};
      if (begin < left || box.x1 > right_end_ || std::any_of(taken_.begin(), taken_.end(), [&](const Box& other) {
            return box.x0 < other.x1 && other.x0 < box.x1 && box.y0 < other.y1 && other.y0 < box.y1;
          }))
        continue;
      taken_.push_back(box);
      return fmt::format("<text class='nl-note' x='{:.1f}' y='{:.1f}'>{}</text>\n", begin, base, xml_escaped(text));
    }
    return "";
  }

  explicit NotePlacer(double right_end) : right_end_(right_end) {}

 private:
  struct Box {
    double x0, x1, y0, y1;
  };
  double right_end_;
  std::vector<Box> taken_;
};

std::string notes_svg(const Plot& plot, const Scale& x, const Scale& y) {
  NotePlacer placer(x.to);
  std::string svg;
  const auto for_each_point = [&](const auto& visit) {
    for (const PlotLine& line : plot.lines)
      for (std::size_t i = 0; i < std::min(line.x.size(), line.y.size()); ++i)
        if (i < line.names.size() && x.holds(line.x[i]) && y.holds(line.y[i]))
          visit(line, i, x(line.x[i]), y(line.y[i]));
  };
  for_each_point([&](const PlotLine&, std::size_t, double px, double py) { placer.avoid_marker(px, py); });
  for (const PlotMark& mark : plot.marks)
    if (x.holds(mark.x) && y.holds(mark.y)) {
      const double width = mark_width(mark);
      placer.avoid_text(mark_on_right(mark, plot, x) ? x(mark.x) + 9 : x(mark.x) - 9 - width, y(mark.y) - 12, width);
    }
  for_each_point([&](const PlotLine& line, std::size_t i, double px, double py) {
    if (i < line.notes.size()) svg += placer.svg(line.notes[i], px, py);
  });
  return svg;
}

std::string line_svg(const PlotLine& line, const Scale& x, const Scale& y) {
  std::string points;
  std::string markers;
  for (std::size_t i = 0; i < line.x.size(); ++i) {
    if (!x.holds(line.x[i]) || !y.holds(line.y[i])) continue;
    points += fmt::format("{:.1f},{:.1f} ", x(line.x[i]), y(line.y[i]));
    if (i < line.names.size())
      markers += fmt::format("<circle class='{} nl-dot' cx='{:.1f}' cy='{:.1f}' r='4'><title>{}</title></circle>\n",
                             style_class(line.style), x(line.x[i]), y(line.y[i]), xml_escaped(line.names[i]));
  }
  if (line.style == PlotLine::Style::points) return markers;
  return fmt::format("<polyline class='{}' points='{}'/>\n", style_class(line.style), points) + markers;
}

std::string mark_svg(const PlotMark& mark, const Plot& plot, const Scale& x, const Scale& y) {
  if (!x.holds(mark.x) || !y.holds(mark.y)) return "";
  const bool room = mark_on_right(mark, plot, x);
  return fmt::format(
      "<circle class='nl-ring' cx='{0:.1f}' cy='{1:.1f}' r='9'/><text class='nl-mark' text-anchor='{2}' x='{3:.1f}' "
      "y='{4:.1f}'>{5}</text>\n",
      x(mark.x), y(mark.y), room ? "start" : "end", x(mark.x) + (room ? 9 : -9), y(mark.y) - 12,
      xml_escaped(mark.label));
}

constexpr const char* plot_style =
    "<style>.nl-plot{font:12px system-ui,sans-serif;color:#333}.nl-plot text{fill:currentColor}"
    ".nl-grid{stroke:currentColor;stroke-opacity:.15}.nl-axis{stroke:currentColor;stroke-opacity:.6}"
    ".nl-tick{opacity:.75}.nl-main,.nl-second,.nl-third,.nl-fourth,.nl-fifth,.nl-dashed{fill:none;stroke-width:2;"
    "stroke-linejoin:round}"
    ".nl-main{stroke:#2f7ed8}.nl-second{stroke:#d8722f}.nl-third{stroke:#2fa56b;stroke-dasharray:9 "
    "3}.nl-fourth{stroke:#9a6fd8;stroke-dasharray:3 2}.nl-fifth{"
    "stroke:#c9a400}.nl-dashed{stroke:#888;stroke-dasharray:5 4}"
    ".nl-front{fill:none;stroke:#2fa56b;stroke-opacity:.3;stroke-width:11;stroke-linejoin:round;stroke-linecap:round}"
    ".nl-points{fill:none;stroke:#8a63c7;stroke-width:1.6}.nl-main.nl-dot{fill:#2f7ed8}.nl-second.nl-dot{fill:#d8722f}"
    ".nl-points.nl-dot{fill:#8a63c7;fill-opacity:.25}.nl-ring{fill:none;stroke:currentColor;stroke-width:1.6}"
    ".nl-mark{font-weight:600}.nl-note{font-size:10px;opacity:.65}</style>\n";

}  // namespace

std::vector<double> linear_ticks(double lo, double hi, int wanted) {
  const double raw = (hi - lo) / std::max(wanted, 1);
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  const double step = power * (raw <= power ? 1 : raw <= 2 * power ? 2 : raw <= 5 * power ? 5 : 10);
  std::vector<double> ticks;
  for (double k = std::ceil(lo / step - 1e-9); k * step <= hi + 1e-9 * step; ++k) ticks.push_back(k * step);
  return ticks;
}

std::string xml_escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string plot_svg(const Plot& plot) {
  Scale x{.from = left, .to = plot.width - right, .log = plot.log_x};
  Scale y{.from = plot.height - bottom, .to = top, .log = plot.log_y};
  for (const PlotLine& line : plot.lines) {
    for (std::size_t i = 0; i < std::min(line.x.size(), line.y.size()); ++i) {
      if (!x.holds(line.x[i]) || !y.holds(line.y[i])) continue;
      x.include(line.x[i]);
      y.include(line.y[i]);
    }
  }
  if (!plot.log_y) y.include(0);
  if (!plot.log_y) y.hi *= 1.05;
  x.settle();
  y.settle();
  const bool has_markers =
      std::any_of(plot.lines.begin(), plot.lines.end(), [](const auto& l) { return !l.names.empty(); });
  if (has_markers) {
    x.widen(0.04);
    y.widen(0.08);
  }
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' class='nl-plot' viewBox='0 0 {} {}' role='img'>\n<title>{}</title>\n",
      plot.width, plot.height, xml_escaped(plot.title));
  svg += plot_style + axes_svg(plot, x, y);
  for (const PlotLine& line : plot.lines) svg += line_svg(line, x, y);
  svg += notes_svg(plot, x, y);
  for (const PlotMark& mark : plot.marks) svg += mark_svg(mark, plot, x, y);
  return svg + legend_svg(plot) + "</svg>\n";
}

}  // namespace noiseloom
