#include "noiseloom/study/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace noiseloom {
namespace {

constexpr double view_width = 620;
constexpr double view_height = 300;
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
  double operator()(double v) const {
    const double t = log ? (std::log10(v) - std::log10(lo)) / (std::log10(hi) - std::log10(lo)) : (v - lo) / (hi - lo);
    return from + (to - from) * t;
  }
};

// Powers of ten inside lo..hi and 2 and 5 times them; the powers alone where that would be many, even steps where they
// would be few.
std::vector<double> log_ticks(double lo, double hi) {
  if (hi / lo < 8) return linear_ticks(lo, hi, 5);
  const bool many = hi / lo > 200;
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
  return style == PlotLine::Style::main ? "nl-main" : style == PlotLine::Style::second ? "nl-second" : "nl-dashed";
}

std::string axes_svg(const Plot& plot, const Scale& x, const Scale& y) {
  std::string svg;
  for (const double tick : y.log ? log_ticks(y.lo, y.hi) : linear_ticks(y.lo, y.hi, 5)) {
    svg += fmt::format("<line class='nl-grid' x1='{:.1f}' x2='{:.1f}' y1='{:.1f}' y2='{:.1f}'/>", x.from, x.to, y(tick),
                       y(tick));
    svg += fmt::format("<text class='nl-tick' text-anchor='end' x='{:.1f}' y='{:.1f}'>{}</text>\n", x.from - 7,
                       y(tick) + 4, tick_text(tick));
  }
  for (const double tick : linear_ticks(x.lo, x.hi, 7)) {
    svg += fmt::format("<line class='nl-axis' x1='{0:.1f}' x2='{0:.1f}' y1='{1:.1f}' y2='{2:.1f}'/>", x(tick), y.from,
                       y.from + 5);
    svg += fmt::format("<text class='nl-tick' text-anchor='middle' x='{:.1f}' y='{:.1f}'>{}</text>\n", x(tick),
                       y.from + 18, tick_text(tick));
  }
  svg += fmt::format("<line class='nl-axis' x1='{:.1f}' x2='{:.1f}' y1='{:.1f}' y2='{:.1f}'/>\n", x.from, x.to, y.from,
                     y.from);
  svg += fmt::format("<text class='nl-label' text-anchor='middle' x='{:.1f}' y='{:.1f}'>{}</text>\n",
                     (x.from + x.to) / 2, view_height - 8, xml_escaped(plot.x_label));
  svg += fmt::format("<text class='nl-label' x='{:.1f}' y='16'>{}</text>\n", 4.0, xml_escaped(plot.y_label));
  return svg;
}

std::string legend_svg(const Plot& plot) {
  std::string svg;
  double end = view_width - right;
  for (auto line = plot.lines.rbegin(); line != plot.lines.rend(); ++line) {
    if (line->label.empty()) continue;
    const double begin = end - 6.6 * static_cast<double>(line->label.size());
    svg += fmt::format("<text class='nl-label' x='{:.1f}' y='16'>{}</text>", begin, xml_escaped(line->label));
    svg += fmt::format("<line class='{}' x1='{:.1f}' x2='{:.1f}' y1='12' y2='12'/>\n", style_class(line->style),
                       begin - 30, begin - 7);
    end = begin - 50;
  }
  return svg;
}

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
  Scale x{.from = left, .to = view_width - right};
  Scale y{.from = view_height - bottom, .to = top, .log = plot.log_y};
  for (const PlotLine& line : plot.lines) {
    for (const double v : line.x) x.include(v);
    for (const double v : line.y) y.include(v);
  }
  if (!plot.log_y) y.include(0);
  if (!plot.log_y) y.hi *= 1.05;
  x.settle();
  y.settle();
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' class='nl-plot' viewBox='0 0 {} {}' role='img'>\n<title>{}</title>\n"
      "<style>.nl-plot{{font:12px system-ui,sans-serif;color:#333}}.nl-plot text{{fill:currentColor}}"
      ".nl-grid{{stroke:currentColor;stroke-opacity:.15}}.nl-axis{{stroke:currentColor;stroke-opacity:.6}}"
      ".nl-tick{{opacity:.75}}.nl-main,.nl-second,.nl-dashed{{fill:none;stroke-width:2;stroke-linejoin:round}}"
      ".nl-main{{stroke:#2f7ed8}}.nl-second{{stroke:#d8722f}}.nl-dashed{{stroke:#888;stroke-dasharray:5 4}}</style>\n",
      view_width, view_height, xml_escaped(plot.title));
  svg += axes_svg(plot, x, y);
  for (const PlotLine& line : plot.lines) {
    svg += fmt::format("<polyline class='{}' points='", style_class(line.style));
    for (std::size_t i = 0; i < line.x.size(); ++i)
      if (x.holds(line.x[i]) && y.holds(line.y[i])) svg += fmt::format("{:.1f},{:.1f} ", x(line.x[i]), y(line.y[i]));
    svg += "'/>\n";
  }
  return svg + legend_svg(plot) + "</svg>\n";
}

}  // namespace noiseloom
