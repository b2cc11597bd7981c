#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <regex>

#include "measure/verify_parts.h"
#include "noiseloom/measure/spectrum.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom::verify {
namespace {

// Whether somebody says that the texture was made for filters over its slices: a config, or a name as published.
std::string why_made_for_time(const Subject& subject, const std::string& path) {
  if (subject.stored.config) {
    for (const GroupSpec& group : subject.stored.config->problem.filter.groups) {
      const auto acts_along = [&group](int axis) {
        const auto has = [axis](const std::vector<int>& axes) {
          return std::find(axes.begin(), axes.end(), axis) != axes.end();
        };
        return has(group.axes) && !has(group.kernel.tile_axes);  // tiles act on each other at their edges alone
      };
      if (acts_along(2)) return "its config filters over slices";
    }
    return "";
  }
  static const std::regex names(R"(stbn|stblue|spatio|2dx1d|_exp(onential)?[_0-9.]|xyt)", std::regex::icase);
  const std::string name = std::filesystem::path(path).filename().string();
  return std::regex_search(name, names) ? "its name says so" : "";
}

// Mean power of the lower quarter of the frequencies along the first slice axis, and how far chance takes it from 1.
struct Low {
  double power = 1;
  double deviation = 0;
};
Low low_power(const Texture& texture, const AxesSpectrum& spectrum) {
  const auto n = static_cast<std::size_t>(spectrum.sizes[0]);
  const std::size_t bins = std::max<std::size_t>(1, n / 8);
  double sum = 0;
  for (std::size_t k = 1; k <= bins; ++k) sum += spectrum.power[k];
  const double lines = static_cast<double>(texture.extents.num_cells()) / static_cast<double>(n);
  return {sum / static_cast<double>(bins), 1 / std::sqrt(lines * static_cast<double>(bins))};
}

// x with exp(-n (x - 1 - ln x)) = p: the mean of n exponential numbers of mean 1 exceeds it with odds below p
// (Chernoff).
double mean_exceeded_with_odds(double n, double p) {
  double low = 1;
  double high = 1e6;
  for (int i = 0; i < 100; ++i) {
    const double x = std::sqrt(low * high);
    (n * (x - 1 - std::log(x)) < -std::log(p) ? low : high) = x;
  }
  return high;
}

// The power around a frequency, without itself and the four largest: what a smooth spectrum has there.
double power_around(const PlaneSpectrum& spectrum, int x, int y) {
  constexpr int reach = 3;
  std::vector<double> around;
  for (int dy = -reach; dy <= reach; ++dy)
    for (int dx = -reach; dx <= reach; ++dx) {
      const int u = (x + dx + spectrum.width) % spectrum.width;
      const int v = (y + dy + spectrum.height) % spectrum.height;
      if ((dx != 0 || dy != 0) && (u != spectrum.width / 2 || v != spectrum.height / 2))
        around.push_back(spectrum.at(u, v));
    }
  std::nth_element(around.begin(), around.end() - 5, around.end());
  double largest = 0;
  for (auto p = around.begin(); p != around.end() - 4; ++p) largest = std::max(largest, *p);
  return largest;
}

// Of how many independent planes the spectrum is a mean, at least: power over that around it varies by one over their
// number. Slices that are one slice, shifted, have one spectrum.
double independent_planes(const PlaneSpectrum& spectrum, std::int32_t slices) {
  std::vector<double> ratios;
  for (int y = 1; y + 1 < spectrum.height; ++y)
    for (int x = 1; x + 1 < spectrum.width; ++x) {
      double around = 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) around += dx != 0 || dy != 0 ? spectrum.at(x + dx, y + dy) / 8 : 0;
      if (around > 0) ratios.push_back(spectrum.at(x, y) / around);
    }
  if (ratios.empty()) return 1;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  const double median = *middle;
  for (double& r : ratios) r = std::abs(r - median);
  std::nth_element(ratios.begin(), middle, ratios.end());
  constexpr double fewest = 4;  // below, the median deviation of so skew a distribution says little
  const double planes = 1 / (1.4826 * *middle * 1.4826 * *middle);
  return planes < fewest ? 1 : std::min(planes * 0.8, static_cast<double>(slices));
}

// A frequency that towers above all others near it is seen as a pattern. What is asked is beyond chance, beyond the
// largest of the neighbours, and has some power at all.
void check_peaks(const Subject& subject, DistanceKind kind, Verification& found) {
  constexpr int smallest = 16;
  const Extents& extents = subject.texture.extents;
  if (extents.width() < smallest || extents.height() < smallest) return;
  const PlaneSpectrum spectrum = plane_spectrum(subject.texture, kind, 0, 1);
  const double frequencies = static_cast<double>(extents.cells_per_slice()) / 2;
  const double bound = mean_exceeded_with_odds(independent_planes(spectrum, extents.num_slices()), odds / frequencies);
  struct Peak {
    int x, y;
    double power, around;
  };
  std::vector<Peak> peaks;
  for (int y = 0; y <= spectrum.height / 2; ++y)
    for (int x = 0; x < spectrum.width; ++x) {
      if (x == spectrum.width / 2 && y == spectrum.height / 2) continue;
      // Edges that the texture ends at are lines of other values, by right.
      if ((x == spectrum.width / 2 && ends_along(subject, 1)) || (y == spectrum.height / 2 && ends_along(subject, 0)))
        continue;
      const double power = spectrum.at(x, y);
      constexpr double visible = 4;  // times white noise
      if (power < visible) continue;
      const double around = power_around(spectrum, x, y);
      if (power > std::max(bound, 2.0) * around) peaks.push_back({x, y, power, around});
    }
  if (peaks.empty()) return;
  const Peak& largest =
      *std::max_element(peaks.begin(), peaks.end(), [](const Peak& a, const Peak& b) { return a.power < b.power; });
  const auto frequency = [](int at, int size) { return static_cast<double>(at - size / 2) / size; };
  found.findings.push_back(
      {"peaks", true,
       fmt::format(
           "{} frequenc{} of the slices' spectrum stand out, which is seen as a pattern: {:.4f}, {:.4f} cycles a "
           "pixel has {:.1f} times the power of white noise, its neighbours at most {:.2f}",
           peaks.size(), peaks.size() == 1 ? "y" : "ies", frequency(largest.x, spectrum.width),
           frequency(largest.y, spectrum.height), largest.power, largest.around)});
}

}  // namespace

void check_time(const Subject& subject, const std::string& path, double space, double joint, Verification& found) {
  const Extents& extents = subject.texture.extents;
  for (const GroupQuality& group : found.quality.groups) {
    if (group.axes != std::vector<int>{2} || extents.num_axes() != 3 || extents.size(2) < 4) continue;
    const Low low = low_power(subject.texture, group.spectrum);
    // White noise strays farther with odds below one in a million. Slices that know nothing of each other have the
    // error of one slice under both filters, up to a share of 0.25 / sqrt(pixels) (64 x 64 pixels, 8 to 32 slices,
    // found by trying).
    const double low_bound = std::max(5 * low.deviation, 0.02);
    const double gain_bound = 6 * 0.25 / std::sqrt(static_cast<double>(extents.cells_per_slice()));
    const bool alone = std::abs(low.power - 1) < low_bound;
    const bool gains = joint < space * (1 - gain_bound);
    // Half as far: chance does that now and then, and so does a texture that is hardly blue. It is called neither.
    const bool may_gain = low.power < 1 - low_bound / 2 || joint < space * (1 - gain_bound / 2);
    const std::string axis = extents.name(2);
    const std::string by_power =
        fmt::format("the lower quarter of its frequencies has the power {:.3f} (white noise: within {:.3f} of 1)",
                    low.power, low_bound);
    const std::string by_gain = fmt::format(
        "an exponential average behind a Gauss leaves {:.3f} times the error that the Gauss leaves alone (slices that "
        "know nothing of each other: no less than {:.3f})",
        joint / space, 1 - gain_bound);
    // What is said is what it was decided by.
    if (!alone) {
      found.findings.push_back(
          {"time", false, fmt::format("{} is {}: {}", axis, low.power < 1 ? "blue" : "red", by_power)});
    } else if (gains) {
      found.findings.push_back({"time", false, fmt::format("{} is blue where a Gauss looks: {}", axis, by_gain)});
    } else if (may_gain) {
      found.findings.push_back(
          {"time", false, fmt::format("{} is white, or hardly blue: {}, and {}", axis, by_power, by_gain)});
    } else if (const std::string why = why_made_for_time(subject, path); !why.empty()) {
      found.findings.push_back(
          {"white-in-time", true,
           fmt::format("made for filters over {} ({}), but white along it: {}, and {}", axis, why, by_power, by_gain)});
    } else {
      found.findings.push_back({"time", false, fmt::format("{} is white: {}, and {}", axis, by_power, by_gain)});
    }
  }
}

void check_spectra(const Subject& subject, Verification& found) {
  const DistanceKind kind = distance_kind(subject.samples, subject.texture.channels);
  const FilterSpec* const filter = subject.stored.config ? &subject.stored.config->problem.filter : nullptr;
  found.quality = spectral_quality(subject.texture, kind, filter);
  check_peaks(subject, kind, found);
}

}  // namespace noiseloom::verify
