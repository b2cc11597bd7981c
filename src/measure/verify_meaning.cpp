#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "measure/verify_parts.h"
#include "noiseloom/image/encoding.h"
#include "noiseloom/image/sample_check.h"
#include "noiseloom/measure/distribution.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom::verify {
namespace {

const float* plane(const Texture& texture, SliceIndex slice, std::size_t channel) {
  return texture.slice(slice) + channel * static_cast<std::size_t>(texture.extents.cells_per_slice());
}

bool is_constant(const Texture& texture, std::size_t channel) {
  const auto cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  const float first = *plane(texture, SliceIndex(0), channel);
  for (const SliceIndex s : texture.extents.slices())
    if (std::any_of(plane(texture, s, channel), plane(texture, s, channel) + cells,
                    [first](float v) { return v != first; }))
      return false;
  return true;
}

bool is_copy(const Texture& texture, std::size_t a, std::size_t b) {
  const auto cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  for (const SliceIndex s : texture.extents.slices())
    if (!std::equal(plane(texture, s, a), plane(texture, s, a) + cells, plane(texture, s, b))) return false;
  return true;
}

// Channels that vary and repeat none before them; alpha is no part of a sample of fewer than four channels.
std::vector<std::size_t> channels_in_use(const StoredTexture& stored) {
  std::vector<std::size_t> used;
  for (std::size_t c = 0; c < static_cast<std::size_t>(stored.texture.channels); ++c) {
    const bool copy =
        std::any_of(used.begin(), used.end(), [&](std::size_t u) { return is_copy(stored.texture, u, c); });
    if (!copy && !is_constant(stored.texture, c)) used.push_back(c);
  }
  if (used.empty()) used.push_back(0);
  return used;
}

// The samples of a space, from the numbers of those channels.
Texture decoded(const StoredTexture& stored, const std::vector<std::size_t>& channels, const SampleSpec& samples) {
  Texture texture = make_texture(stored.texture.extents, static_cast<int>(channels.size()));
  const auto cells = static_cast<std::size_t>(stored.texture.extents.cells_per_slice());
  for (const SliceIndex s : texture.extents.slices())
    for (std::size_t i = 0; i < channels.size(); ++i)
      std::copy_n(plane(stored.texture, s, channels[i]), cells, texture.slice(s) + i * cells);
  if (stored.values) return texture;
  const ValueRange range = natural_range(samples).value_or(ValueRange{});
  const bool has_negative = std::any_of(texture.values.begin(), texture.values.end(), [](float v) { return v < 0; });
  if (!stored.codes && (range == ValueRange{} || has_negative)) return texture;
  for (float& v : texture.values) v = static_cast<float>(from_unit(range, static_cast<double>(v)));
  return texture;
}

double step_of(const StoredTexture& stored, const SampleSpec& samples) {
  const ValueRange range = natural_range(samples).value_or(ValueRange{});
  return stored.step * (range.hi - range.lo);
}

struct Candidate {
  Subject subject;
  double outside = 0;   // share of samples outside the space
  double distance = 0;  // of the distribution, over what chance allows
  double badness() const { return 1000 * outside + std::max(distance - 1, 0.0); }
};

Candidate candidate(const StoredTexture& stored, const std::vector<std::size_t>& channels, const std::string& space) {
  SampleSpec samples;
  samples.space = space;
  Candidate c{{stored, channels, samples, decoded(stored, channels, samples), step_of(stored, samples)}};
  c.outside = static_cast<double>(count_outside(c.subject.texture, samples, c.subject.step)) /
              static_cast<double>(c.subject.texture.extents.num_cells());
  c.distance = distribution_distance(c.subject.texture, samples);
  return c;
}

// The narrower first: of spaces that fit alike, that one is taken. (Directions of a sphere have the distribution of a
// cube's points in each of their numbers.)
const std::vector<std::string>& spaces_of(std::size_t channels) {
  static const std::map<std::size_t, std::vector<std::string>> spaces = {
      {1, {"uniform", "tent", "gauss"}},
      {2, {"disk", "hexagon", "vector2", "triangle", "gauss2"}},
      {3, {"hemisphere-cosine", "hemisphere", "sphere", "vector3"}},
      {4, {"rotation", "vector4"}}};
  static const std::vector<std::string> none;
  const auto found = spaces.find(channels);
  return found == spaces.end() ? none : found->second;
}

// "R, G, B, A"
std::string joined_names(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

Subject meaning_of(const StoredTexture& stored, bool is_given, std::string& why) {
  std::vector<std::size_t> used = channels_in_use(stored);
  if (stored.config) {
    const SampleSpec& samples = stored.config->problem.samples;
    const auto wanted = samples.is_file() ? used.size() : static_cast<std::size_t>(num_channels(samples));
    std::vector<std::size_t> channels;
    for (std::size_t c = 0; c < std::min(wanted, static_cast<std::size_t>(stored.texture.channels)); ++c)
      channels.push_back(c);
    why = is_given ? "the config given says so" : "the file says so";
    return {stored, channels, samples, decoded(stored, channels, samples), step_of(stored, samples)};
  }
  std::vector<Candidate> candidates;
  for (std::size_t count = std::min<std::size_t>(used.size(), 4); count >= 1; --count) {
    // Fewer than vary only where the last one is alpha, which may hold a density.
    if (count != used.size() &&
        !(used.size() <= 4 && stored.channel_names[used.back()] == "A" && count + 1 == used.size()))
      continue;
    const std::vector<std::size_t> channels(used.begin(), used.begin() + static_cast<std::ptrdiff_t>(count));
    for (const std::string& space : spaces_of(count)) candidates.push_back(candidate(stored, channels, space));
  }
  if (candidates.empty()) {
    SampleSpec samples;
    samples.space = fmt::format("vector{}", std::clamp<std::size_t>(used.size(), 2, 8));
    used.resize(std::min<std::size_t>(used.size(), 8));
    why = fmt::format("{} channels vary", used.size());
    return {stored, used, samples, decoded(stored, used, samples), step_of(stored, samples)};
  }
  const auto best = std::min_element(candidates.begin(), candidates.end(),
                                     [](const Candidate& a, const Candidate& b) { return a.badness() < b.badness(); });
  why = fmt::format("{} of the channels {} hold{} values of {} own, and of the spaces of that many this one {}",
                    used.size() == 1 ? "one" : std::to_string(used.size()), joined_names(stored.channel_names),
                    used.size() == 1 ? "s" : "", used.size() == 1 ? "its" : "their",
                    best->outside == 0 && best->distance <= 1 ? "fits" : "is the nearest");
  return best->subject;
}

}  // namespace noiseloom::verify
