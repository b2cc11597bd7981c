#include "noiseloom/report/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "noiseloom/report/number_text.h"

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

constexpr double letter = 6.6;  // width of one, on average, in units of a text 12 high

double text_width(const std::string& text) { return letter * static_cast<double>(text.size()); }

// Where 0 is meant, ticks that are added up miss it by a rounding error.
std::string tick_text(double v) { return std::abs(v) < 1e-12 ? "0" : number_text(v, 4); }

std::vector<double> ticks_of(const Scale& scale, int wanted) {
  return scale.log ? log_ticks(scale.lo, scale.hi) : linear_ticks(scale.lo, scale.hi, wanted);
}

// What lines look like, in the order of PlotLine::Style; those past the last of these have a look of their own below.
struct Look {
  const char* name;
  const char* colour;
  const char* dashes;
};
constexpr Look looks[] = {
    {"nl-main", "#2f7ed8", "none"},   {"nl-second", "#d8722f", "none"}, {"nl-third", "#2fa56b", "9 3"},
    {"nl-fourth", "#9a6fd8", "3 2"},  {"nl-fifth", "#c9a400", "none"},  {"nl-sixth", "#d0467f", "12 3 3 3"},
    {"nl-seventh", "#2aa7b8", "6 2"}, {"nl-eighth", "#8a6d4b", "2 3"},  {"nl-dashed", "#888", "5 4"},
    {"nl-front", "#2fa56b", "none"},  {"nl-points", "#8a63c7", "none"}};

static_assert(std::size(looks) == static_cast<std::size_t>(PlotLine::Style::points) + 1);

const char* style_class(PlotLine::Style style) { return looks[static_cast<std::size_t>(style)].name; }

constexpr int x_ticks = 7;
constexpr int y_ticks = 5;

// Ticks whose words would lie on those of the one before are drawn without words.
std::string axes_svg(const Plot& plot, const Scale& x, const Scale& y) {
  std::string svg;
  double above = std::numeric_limits<double>::infinity();  // where the last words begin
  for (const double tick : ticks_of(y, y_ticks)) {
    svg += fmt::format("<line class='nl-grid' x1='{:.1f}' x2='{:.1f}' y1='{:.1f}' y2='{:.1f}'/>", x.from, x.to, y(tick),
                       y(tick));
    if (y(tick) + 4 > above) continue;
    above = y(tick) - 10;
    svg += fmt::format("<text class='nl-tick' text-anchor='end' x='{:.1f}' y='{:.1f}'>{}</text>\n", x.from - 7,
                       y(tick) + 4, tick_text(tick));
  }
  double end = -std::numeric_limits<double>::infinity();  // of the last words
  for (const double tick : ticks_of(x, x_ticks)) {
    svg += fmt::format("<line class='nl-axis' x1='{0:.1f}' x2='{0:.1f}' y1='{1:.1f}' y2='{2:.1f}'/>", x(tick), y.from,
                       y.from + 5);
    const std::string text = tick_text(tick);
    const double half = text_width(text) / 2;
    const double middle = std::min(x(tick), plot.width - half);  // the last words would reach beyond the plot
    if (middle - half < end + letter) continue;
    end = middle + half;
    svg += fmt::format("<text class='nl-tick' text-anchor='middle' x='{:.1f}' y='{:.1f}'>{}</text>\n", middle,
                       y.from + 18, text);
  }
  svg += fmt::format("<line class='nl-axis' x1='{:.1f}' x2='{:.1f}' y1='{:.1f}' y2='{:.1f}'/>\n", x.from, x.to, y.from,
                     y.from);
  svg += fmt::format("<text class='nl-label' text-anchor='middle' x='{:.1f}' y='{:.1f}'>{}</text>\n",
                     (x.from + x.to) / 2, plot.height - 8, xml_escaped(plot.x_label));
  svg += fmt::format("<text class='nl-label' x='{:.1f}' y='16'>{}</text>\n", 4.0, xml_escaped(plot.y_label));
  return svg;
}

constexpr double legend_row = 18;  // height of one

// The legend stands right of the name of the y axis, in as many rows as it takes.
struct LegendEntry {
  const PlotLine* line;
  double begin;  // of its words; the sample of its line is to the left of them
  int row;
};
std::vector<LegendEntry> placed_legend(const Plot& plot) {
  constexpr double sample = 30;
  constexpr double gap = 20;
  const double room = plot.width - right - text_width(plot.y_label) - gap;
  std::vector<LegendEntry> entries;
  double end = 0;  // of the row so far, from its own beginning
  std::size_t first = 0;
  const auto move_to_the_right = [&] {
    for (; first < entries.size(); ++first) entries[first].begin += plot.width - right - end;
  };
  for (const PlotLine& line : plot.lines) {
    if (line.label.empty()) continue;
    const double width = sample + text_width(line.label);
    int row = entries.empty() ? 0 : entries.back().row;
    if (end > 0 && end + gap + width > room) {
      move_to_the_right();
      ++row;
      end = 0;
    }
    end += (end > 0 ? gap : 0) + width;
    entries.push_back({&line, end - text_width(line.label), row});
  }
  move_to_the_right();
  return entries;
}

std::string legend_svg(const Plot& plot) {
  std::string svg;
  for (const auto& [line, begin, row] : placed_legend(plot)) {
    const double base = 16 + legend_row * row;
    svg += fmt::format("<text class='nl-label' x='{:.1f}' y='{:.1f}'>{}</text>", begin, base, xml_escaped(line->label));
    if (line->style == PlotLine::Style::points)
      svg += fmt::format("<circle class='nl-points' cx='{:.1f}' cy='{:.1f}' r='4'/>\n", begin - 13, base - 4);
    else
      svg += fmt::format("<line class='{0}' x1='{1:.1f}' x2='{2:.1f}' y1='{3:.1f}' y2='{3:.1f}'/>\n",
                         style_class(line->style), begin - 30, begin - 7, base - 4);
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
    taken_.push_back({begin, begin + width, base - 11, base + 1});
  }

  // Below to the left of the point, where a falling curve leaves room, else above to the right, else nothing.
  std::string svg(const std::string& text, double x, double y) {
    const double width = text_width(text);
    for (const bool below : {true, false}) {
      const double begin = below ? x - 6 - width : x + 6;
      const double base = below ? y + 14 : y - 6;
      const Box box{begin, begin + width, base - 11, base + 1};
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

// The area between the lower and the upper ends.
std::string band_svg(const PlotLine& line, const Scale& x, const Scale& y) {
  std::string below;
  std::string above;
  for (std::size_t i = 0; i < std::min({line.x.size(), line.low.size(), line.high.size()}); ++i) {
    if (!x.holds(line.x[i]) || !y.holds(line.low[i]) || !y.holds(line.high[i])) continue;
    below += fmt::format("{:.1f},{:.1f} ", x(line.x[i]), y(line.low[i]));
    above.insert(0, fmt::format("{:.1f},{:.1f} ", x(line.x[i]), y(line.high[i])));
  }
  return fmt::format("<polygon class='{} nl-band' points='{}{}'/>\n", style_class(line.style), below, above);
}

std::string line_svg(const PlotLine& line, const Scale& x, const Scale& y) {
  std::string points;
  std::string markers = line.has_band ? band_svg(line, x, y) : "";
  for (std::size_t i = 0; i < line.x.size(); ++i) {
    if (!x.holds(line.x[i]) || !y.holds(line.y[i])) continue;
    points += fmt::format("{:.1f},{:.1f} ", x(line.x[i]), y(line.y[i]));
    if (!line.has_band && i < line.low.size() && i < line.high.size() && y.holds(line.low[i]) &&
        line.low[i] < line.high[i])
      markers += fmt::format("<line class='{0}' x1='{1:.1f}' x2='{1:.1f}' y1='{2:.1f}' y2='{3:.1f}'/>\n",
                             style_class(line.style), x(line.x[i]), y(line.low[i]), y(line.high[i]));
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

std::string plot_style() {
  std::string text =
      "<style>.nl-plot{font:12px system-ui,sans-serif;color:#333}.nl-plot text{fill:currentColor}"
      ".nl-grid{stroke:currentColor;stroke-opacity:.15}.nl-axis{stroke:currentColor;stroke-opacity:.6}"
      ".nl-tick{opacity:.75}";
  for (const Look& look : looks)
    text += fmt::format(
        ".{0}{{fill:none;stroke-width:2;stroke-linejoin:round;stroke:{1};stroke-dasharray:{2}}}"
        ".{0}.nl-dot,.{0}.nl-band{{fill:{1};stroke-dasharray:none}}",
        look.name, look.colour, look.dashes);
  return text +
         ".nl-band{stroke:none;fill-opacity:.2}.nl-front{stroke-opacity:.3;stroke-width:11;stroke-linecap:round}"
         ".nl-points{stroke-width:1.6}.nl-points.nl-dot{fill-opacity:.25}"
         ".nl-ring{fill:none;stroke:currentColor;stroke-width:1.6}.nl-mark{font-weight:600}.nl-note{opacity:.65}"
         "</style>\n";
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

PlotLine::Style style_of_line(std::size_t number) {
  return static_cast<PlotLine::Style>(number % (static_cast<std::size_t>(PlotLine::Style::eighth) + 1));
}

std::string plot_svg(const Plot& plot) {
  const std::vector<LegendEntry> legend = placed_legend(plot);
  const double legend_height = legend.empty() ? 0 : legend_row * legend.back().row;
  Scale x{.from = left, .to = plot.width - right, .log = plot.log_x};
  Scale y{.from = plot.height - bottom, .to = top + legend_height, .log = plot.log_y};
  for (const PlotLine& line : plot.lines) {
    for (std::size_t i = 0; i < std::min(line.x.size(), line.y.size()); ++i) {
      if (!x.holds(line.x[i]) || !y.holds(line.y[i])) continue;
      x.include(line.x[i]);
      y.include(line.y[i]);
      for (const std::vector<double>* ends : {&line.low, &line.high})
        if (i < ends->size() && y.holds((*ends)[i])) y.include((*ends)[i]);
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
  for (const double tick : ticks_of(y, y_ticks)) x.from = std::max(x.from, text_width(tick_text(tick)) + 12);
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' class='nl-plot' viewBox='0 0 {} {}' role='img'>\n<title>{}</title>\n",
      plot.width, plot.height, xml_escaped(plot.title));
  svg += plot_style() + axes_svg(plot, x, y);
  for (const PlotLine& line : plot.lines) svg += line_svg(line, x, y);
  svg += notes_svg(plot, x, y);
  for (const PlotMark& mark : plot.marks) svg += mark_svg(mark, plot, x, y);
  return svg + legend_svg(plot) + "</svg>\n";
}

std::string picture_with_axes(const std::string& image_source, int width, int height, const PictureAxes& axes) {
  constexpr double above = 8;
  const double base = above + height;
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' class='nl-plot nl-picture' viewBox='0 0 {} {:.0f}' role='img'>\n"
      "<title>{}</title>\n{}<image href='{}' x='{}' y='{}' width='{}' height='{}'/>\n",
      picture_width_with_axes(width), base + bottom, xml_escaped(axes.title), plot_style(), image_source, left, above,
      width, height);
  for (const double frequency : {-0.5, 0.0, 0.5}) {
    const double px = left + (frequency + 0.5) * width;
    const double py = base - (frequency + 0.5) * height;
    svg +=
        fmt::format("<line class='nl-axis' x1='{0:.1f}' x2='{0:.1f}' y1='{1:.1f}' y2='{2:.1f}'/>", px, base, base + 5);
    svg += fmt::format("<text class='nl-tick' text-anchor='middle' x='{:.1f}' y='{:.1f}'>{}</text>\n", px, base + 18,
                       tick_text(frequency));
    svg +=
        fmt::format("<line class='nl-axis' x1='{:.1f}' x2='{:.1f}' y1='{:.1f}' y2='{:.1f}'/>", left - 5, left, py, py);
    svg += fmt::format("<text class='nl-tick' text-anchor='end' x='{:.1f}' y='{:.1f}'>{}</text>\n", left - 7, py + 4,
                       tick_text(frequency));
  }
  svg += fmt::format("<text class='nl-label' text-anchor='middle' x='{:.1f}' y='{:.1f}'>{}</text>\n",
                     left + width / 2.0, base + bottom - 8, xml_escaped(axes.x_label));
  svg += fmt::format(
      "<text class='nl-label' text-anchor='middle' transform='translate(13 {:.1f}) rotate(-90)'>{}</text>\n",
      above + height / 2.0, xml_escaped(axes.y_label));
  return svg + "</svg>\n";
}

int picture_width_with_axes(int width) { return static_cast<int>(left + right) + width; }

}  // namespace noiseloom
