// Strata of equal mass: the image is halved by mass again and again across its longer side, floor(n/2) strata to the
// low side and the rest to the high side. Before each cut the dark border is left out, so that strata hug what is
// bright and near numbers lie near each other.
#include "samples/space_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include "noiseloom/core/error.h"
#include "noiseloom/core/math.h"
#include "noiseloom/samples/luminance.h"
#include "samples/image_geometry.h"
#include "samples/mass_grid.h"

namespace noiseloom {
namespace {

class ImageSpace : public SampleSpace {
 public:
  ImageSpace(SpaceTraits traits, InputArrayPtr luminance, ImageGeometry geometry, MassGrid grid, double total)
      : SampleSpace(std::move(traits)),
        array_(std::move(luminance)),
        luminance_(std::get<SharedValues<float>>(array_->values)),
        geometry_(std::move(geometry)),
        grid_(std::move(grid)),
        total_(total) {}

  void sample(std::int64_t n, std::int64_t id, const double* jitter, float* sample) const override {
    NOISELOOM_CHECK(id >= 0 && id < n);
    const TexelBox box = descend(n, [id](const Cut& cut, std::int64_t first) { return id < first + cut.below; }).box;
    sample_in(box, jitter, sample);
  }

  void list(std::int64_t n, const JitterOf& jitter, float* samples) const override {
    std::array<double, 2> at{};
    for_each_stratum({grid_.whole(), 0, n}, [&](std::int64_t id, const TexelBox& box) {
      jitter(id, at.data());
      sample_in(box, at.data(), samples);
      samples += traits().channels;
    });
  }

  std::int64_t invert(std::int64_t n, const float* sample) const override {
    const TexelPoint point = geometry_.to_texels(sample);
    return descend(
               n, [&point](const Cut& cut, std::int64_t) { return point.at[cut.axis == GridAxis::x ? 0 : 1] < cut.at; })
        .first;
  }

  double density(const float* sample) const override {
    const TexelPoint point = geometry_.to_texels(sample);
    const auto texel = static_cast<std::size_t>(point.texel[1]) * static_cast<std::size_t>(grid_.width()) +
                       static_cast<std::size_t>(point.texel[0]);
    return static_cast<double>(luminance_[texel]) / total_;
  }

  // From many samples, as it has no closed form on the disk and the sphere.
  double share_below(int channel, double value) const override {
    std::call_once(sorted_once_, [this] { sort_coordinates(); });
    const std::vector<float>& sorted = sorted_[static_cast<std::size_t>(channel)];
    const auto below = std::lower_bound(sorted.begin(), sorted.end(), static_cast<float>(value)) - sorted.begin();
    return static_cast<double>(below) / static_cast<double>(sorted.size());
  }

 private:
  struct Cut {
    GridAxis axis;
    double at;
    std::int64_t below;  // strata on the low side
  };
  struct Part {
    TexelBox box;
    std::int64_t first;
    std::int64_t count;
  };

  // Requires more than one stratum. Trims the part's box.
  Cut cut(Part& part) const {
    part.box = grid_.trimmed(part.box);
    const GridAxis axis = geometry_.longer_axis(part.box);
    const std::int64_t below = part.count / 2;
    return {axis, grid_.cut(part.box, axis, static_cast<double>(below) / static_cast<double>(part.count)), below};
  }

  static Part low_side(const Part& part, const Cut& cut) {
    Part side = {part.box, part.first, cut.below};
    side.box.high[cut.axis == GridAxis::x ? 0 : 1] = cut.at;
    return side;
  }
  static Part high_side(const Part& part, const Cut& cut) {
    Part side = {part.box, part.first + cut.below, part.count - cut.below};
    side.box.low[cut.axis == GridAxis::x ? 0 : 1] = cut.at;
    return side;
  }

  template <class GoesLow>
  Part descend(std::int64_t n, const GoesLow& goes_low) const {
    Part part = {grid_.whole(), 0, n};
    while (part.count > 1) {
      const Cut c = cut(part);
      part = goes_low(c, part.first) ? low_side(part, c) : high_side(part, c);
    }
    return part;
  }

  template <class Visit>
  void for_each_stratum(Part part, const Visit& visit) const {
    if (part.count == 1) return visit(part.first, part.box);
    const Cut c = cut(part);
    for_each_stratum(low_side(part, c), visit);
    for_each_stratum(high_side(part, c), visit);
  }

  // Rounding may carry a sample over the border of its stratum; then it is drawn towards the middle of its texel's part
  // of the stratum, and at last to the middle of the texel: a sample never lies where there is no density.
  void sample_in(const TexelBox& box, const double* jitter, float* sample) const {
    const TexelPoint drawn = grid_.point(box, jitter[0], jitter[1]);
    std::array<double, 2> stratum_middle;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double low = std::max<double>(box.low[axis], drawn.texel[axis]);
      const double high = std::min<double>(box.high[axis], drawn.texel[axis] + 1);
      stratum_middle[axis] = 0.5 * (low + high);
    }
    for (const double keep : {1.0, 0.984375, 0.875, 0.5, 0.0}) {
      TexelPoint point = drawn;
      for (std::size_t axis = 0; axis < 2; ++axis) {
        point.at[axis] = stratum_middle[axis] + keep * (drawn.at[axis] - stratum_middle[axis]);
      }
      const TexelPoint stored = store(point, sample);
      if (stored.texel == drawn.texel && box.contains(stored.at[0], stored.at[1]) && is_inside(sample)) return;
    }
    TexelPoint middle = drawn;
    for (std::size_t axis = 0; axis < 2; ++axis) middle.at[axis] = drawn.texel[axis] + 0.5;
    store(middle, sample);
  }

  // Writes a sample as it is kept, and says where that lies.
  TexelPoint store(const TexelPoint& point, float* sample) const {
    std::array<double, 3> exact{};
    geometry_.to_sample(point, exact.data());
    std::transform(exact.data(), exact.data() + traits().channels, sample,
                   [](double x) { return static_cast<float>(x); });
    return geometry_.to_texels(sample);
  }

  bool is_inside(const float* sample) const {
    if (traits().support != Support::unit_disk) return true;
    const double x = sample[0];
    const double y = sample[1];
    return x * x + y * y <= 1;
  }

  void sort_coordinates() const {
    constexpr std::int64_t count = 1 << 16;
    const auto channels = static_cast<std::size_t>(traits().channels);
    std::vector<float> samples(static_cast<std::size_t>(count) * channels);
    list(
        count, [](std::int64_t, double* jitter) { jitter[0] = jitter[1] = 0.5; }, samples.data());
    sorted_.resize(channels);
    for (std::size_t c = 0; c < channels; ++c) {
      for (std::size_t i = c; i < samples.size(); i += channels) sorted_[c].push_back(samples[i]);
      std::sort(sorted_[c].begin(), sorted_[c].end());
    }
  }

  InputArrayPtr array_;
  const SharedValues<float>& luminance_;  // [y][x]
  ImageGeometry geometry_;
  MassGrid grid_;
  double total_;  // the integral of the luminance over the space
  mutable std::once_flag sorted_once_;
  mutable std::vector<std::vector<float>> sorted_;  // of each channel
};

std::string texel_text(std::size_t index, std::size_t width) {
  return fmt::format("pixel {}, {} (column, row, from 0)", index % width, index / width);
}

void check_values(const SharedValues<float>& luminance, std::size_t width, const std::string& path) {
  for (const auto& [what, is_wrong] :
       {std::pair<const char*, bool (*)(float)>{"not finite", [](float v) { return !std::isfinite(v); }},
        std::pair<const char*, bool (*)(float)>{"negative", [](float v) { return v < 0; }}}) {
    const auto count = std::count_if(luminance.begin(), luminance.end(), is_wrong);
    if (count == 0) continue;
    const auto first =
        static_cast<std::size_t>(std::find_if(luminance.begin(), luminance.end(), is_wrong) - luminance.begin());
    throw UserError(path, fmt::format("no density: {} of {} pixels {} {}; the first is {}: {}", count, luminance.size(),
                                      count == 1 ? "is" : "are", what, texel_text(first, width), luminance[first]));
  }
}

// The luminance of an image as masses of its texels, checked.
struct Density {
  Density(const InputArrayPtr& luminance, ImageDomain onto, const std::string& path);
  Density(const Density&) = delete;
  Density& operator=(const Density&) = delete;

  int width;
  int height;
  ImageGeometry geometry;
  double total = 0;
  MassGrid::MassOf mass_of;  // as long as this and the luminance live
};

Density::Density(const InputArrayPtr& luminance, ImageDomain onto, const std::string& path)
    : width(narrow<int>(luminance->shape.at(1))),
      height(narrow<int>(luminance->shape.at(0))),
      geometry(onto, width, height) {
  const auto& values = std::get<SharedValues<float>>(luminance->values);
  NOISELOOM_CHECK(luminance->shape.size() == 2);
  check_values(values, static_cast<std::size_t>(width), path);
  mass_of = [this, &values](int x, int y) {
    const std::size_t texel =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    return static_cast<double>(values[texel]) * geometry.measure(x, y);
  };
  for (int y = 0; y < height; ++y) {
    double row = 0;
    for (int x = 0; x < width; ++x) row += mass_of(x, y);
    total += row;
  }
  if (total > 0) return;
  const bool black = std::all_of(values.begin(), values.end(), [](float v) { return v == 0; });
  throw UserError(path, fmt::format("no density: every pixel {}is black", black ? "" : "that lies in the space "));
}

}  // namespace

SpaceTraits image_space_traits(ImageDomain onto) {
  SpaceTraits traits = {.name = "image",
                        .meaning = "a point or direction whose density is the luminance of an image",
                        .aliases = "",
                        .channels = 2,
                        .dimensions = 2,
                        .distance = DistanceKind::euclidean,
                        .range = ValueRange{0, 1},
                        .support = Support::unit_interval,
                        .has_constant_density = false,
                        .nvidia_name = "vec2_importance",
                        .ea_name = "vector2_importance"};
  if (onto == ImageDomain::square) return traits;
  traits.range = ValueRange{-1, 1};
  if (onto == ImageDomain::disk) {
    traits.support = Support::unit_disk;
    traits.nvidia_name = "disk_importance";
    traits.ea_name = "disk_importance";
    return traits;
  }
  traits.channels = 3;
  traits.distance = DistanceKind::angle;
  traits.support = Support::unit_vectors;
  traits.nvidia_name = onto == ImageDomain::sphere ? "unitvec3_importance" : "unitvec3_hemisphere_importance";
  traits.ea_name = onto == ImageDomain::sphere ? "sphere_importance" : "sphere_hemisphere_importance";
  return traits;
}

std::shared_ptr<const SampleSpace> image_space(InputArrayPtr luminance, ImageDomain onto, const std::string& path,
                                               SharedValues<std::uint64_t> masses) {
  Density density(luminance, onto, path);
  MassGrid grid = masses.empty() ? MassGrid(density.width, density.height, density.mass_of)
                                 : MassGrid(density.width, density.height, std::move(masses));
  return std::make_shared<ImageSpace>(image_space_traits(onto), std::move(luminance), std::move(density.geometry),
                                      std::move(grid), density.total);
}

std::size_t num_image_masses(const InputArray& luminance) {
  return MassGrid::num_sums(narrow<int>(luminance.shape[1]), narrow<int>(luminance.shape[0]));
}

void make_image_masses(const SampleSpec& spec, std::span<std::uint64_t> masses) {
  const Density density(spec.array, spec.onto, spec.file);
  MassGrid::sum_up(density.width, density.height, density.mass_of, masses);
}

std::shared_ptr<const SampleSpace> shared_image_space(const SampleSpec& spec) {
  static std::mutex mutex;
  static std::weak_ptr<const SampleSpace> newest;
  static std::weak_ptr<const InputArray> newest_array;
  static ImageDomain newest_onto;
  const InputArrayPtr array = spec.array ? spec.array : read_luminance(spec);
  const std::lock_guard lock(mutex);
  auto space = newest.lock();
  if (space && newest_array.lock() == array && newest_onto == spec.onto) return space;
  space = image_space(array, spec.onto, spec.file, spec.masses);
  newest = space;
  newest_array = array;
  newest_onto = spec.onto;
  return space;
}

}  // namespace noiseloom
