#include "noiseloom/measure/quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "noiseloom/core/json.h"
#include "noiseloom/core/quantity_text.h"

namespace noiseloom {
namespace {

constexpr int num_first_bins = 3;

std::vector<std::vector<int>> groups_of(const Extents& extents, const FilterSpec* filter) {
  std::vector<std::vector<int>> groups;
  const auto add = [&](std::vector<int> axes) {
    std::erase_if(axes, [&](int axis) { return extents.size(axis) == 1; });
    std::sort(axes.begin(), axes.end());
    if (!axes.empty() && std::find(groups.begin(), groups.end(), axes) == groups.end()) groups.push_back(axes);
  };
  add({0, 1});
  for (int axis = 2; axis < extents.num_axes(); ++axis) add({axis});
  if (filter != nullptr)
    for (const GroupSpec& group : filter->groups) add(group.axes);
  return groups;
}

GroupQuality measure(const Texture& texture, DistanceKind kind, const std::string& name, const std::vector<int>& axes) {
  GroupQuality group{name, axes, axes_spectrum(texture, kind, axes), 0, {}};
  group.low_frequency_power = power_below(group.spectrum, low_frequency);
  if (axes.size() == 1 && axes[0] >= 2)
    for (std::int64_t k = 1; k <= std::min<std::int64_t>(num_first_bins, group.spectrum.sizes[0] / 2); ++k)
      group.first_bins.push_back(group.spectrum.power[static_cast<std::size_t>(k)]);
  return group;
}

template <class Text>
std::string listed(const std::vector<double>& values, Text text) {
  std::string list;
  for (const double v : values) list += (list.empty() ? "" : ", ") + text(v);
  return list;
}

}  // namespace

SpectralQuality spectral_quality(const Texture& texture, DistanceKind kind, const FilterSpec* filter,
                                 std::int64_t most_positions) {
  SpectralQuality quality;
  for (const std::vector<int>& axes : groups_of(texture.extents, filter)) {
    std::string name;
    std::int64_t positions = 1;
    for (const int axis : axes) {
      name += texture.extents.name(axis);
      positions *= texture.extents.size(axis);
    }
    if (positions > most_positions)
      quality.left_out.push_back(name);
    else
      quality.groups.push_back(measure(texture, kind, name, axes));
  }
  return quality;
}

std::string quality_text(const SpectralQuality& quality) {
  std::string text;
  for (const GroupQuality& group : quality.groups)
    if (std::isfinite(group.low_frequency_power))
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", group.name, digits_text(group.low_frequency_power));
  if (!text.empty()) text = fmt::format("power below {} cycles a pixel (white noise: 1): {}\n", low_frequency, text);
  for (const GroupQuality& group : quality.groups)
    if (!group.first_bins.empty())
      text += fmt::format("power at the lowest frequencies along {}: {}\n", group.name,
                          listed(group.first_bins, digits_text));
  return text;
}

std::string quality_json(const SpectralQuality& quality) {
  std::string powers;
  std::string bins;
  for (const GroupQuality& group : quality.groups) {
    powers += fmt::format("{}{}: {}", powers.empty() ? "" : ", ", json_string(group.name),
                          json_number(group.low_frequency_power));
    if (!group.first_bins.empty())
      bins += fmt::format("{}{}: [{}]", bins.empty() ? "" : ", ", json_string(group.name),
                          listed(group.first_bins, json_number));
  }
  return fmt::format("\"low_frequency_power\": {{{}}}, \"first_bins\": {{{}}}", powers, bins);
}

}  // namespace noiseloom
