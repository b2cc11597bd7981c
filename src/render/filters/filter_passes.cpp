#include "render/filters/filter_passes.h"

#include <algorithm>
#include <cmath>

#include "render/jobs/frames.h"
#include "render/jobs/scene_sizes.h"
#include "render/pictures/a_trous.h"

namespace noiseloom::render {

// Averages over the frames so far. Sums of all frames are kept in double: there may be many.

double weight_of_frame(const TimeFilterSpec& time, const std::string& kernel, std::int64_t length) {
  const double mean = 1 / static_cast<double>(length);
  if (kernel != "ema") return mean;
  const double first = time.start == EmaStart::cumulative ? mean : length == 1 ? 1 : 0;
  return std::max(time.alpha, first);
}

namespace {

// Written so that alpha = 1 gives the frame itself.
void blend(float alpha, const std::vector<float>& now, std::vector<float>& average, std::size_t first,
           std::size_t last) {
  for (std::size_t i = first; i < last; ++i) average[i] = alpha * now[i] + (1 - alpha) * average[i];
}

}  // namespace

void average(Job& job) {
  const Scene& scene = job.scene();
  const Image& now = job.estimate.get(Data::estimate, job.pass);
  const std::vector<std::string>& kernels = scene.time.kernels;
  const bool is_guided = is_guided_by_variance(scene);
  if (!job.accumulated.is_there()) {
    Averages& made = job.accumulated.make();
    made.images.assign(kernels.size(), make_image(now.width, now.height, now.channels));
    if (is_guided) made.squares.assign(kernels.size(), std::vector<float>(now.pixels()));
    if (std::find(kernels.begin(), kernels.end(), "mc") != kernels.end()) made.sums.assign(now.values.size(), 0);
  }
  Averages& averages = job.accumulated.get(Data::accumulated, job.pass);
  const auto width = static_cast<std::size_t>(now.width);
  const double frames = static_cast<double>(job.frame + 1);
  for (std::size_t k = 0; k < kernels.size(); ++k) {
    std::vector<float>& image = averages.images[k].values;
    const float alpha = static_cast<float>(weight_of_frame(scene.time, kernels[k], job.frame + 1));
    job.rows(now.height * now.channels, [&](int first_row, int last_row) {
      const std::size_t first = static_cast<std::size_t>(first_row) * width;
      const std::size_t last = static_cast<std::size_t>(last_row) * width;
      if (kernels[k] != "mc") return blend(alpha, now.values, image, first, last);
      for (std::size_t i = first; i < last; ++i) {
        averages.sums[i] += static_cast<double>(now.values[i]);
        image[i] = static_cast<float>(averages.sums[i] / frames);
      }
    });
    if (!is_guided) continue;
    std::vector<float> squares = brightness_of(now, job.channels());
    for (float& value : squares) value *= value;
    blend(alpha, squares, averages.squares[k], 0, squares.size());
  }
  count_of(*job.counts, Work::averages) += std::ssize(now.values) * std::ssize(kernels);
}

Counts work_of_averages(const Scene& scene, std::span<const Noise> noises) {
  Counts counts{};
  count_of(counts, Work::averages) = pixels_of(scene) * planes_of_all(scene) * std::ssize(scene.time.kernels) *
                                     scene.frames * scene.repeats * std::ssize(noises);
  return counts;
}

std::int64_t bytes_of_averages(const Scene& scene, std::span<const Noise>) {
  const std::int64_t squares = is_guided_by_variance(scene) ? 4 * pixels_of(scene) * (times_of(scene) - 1) : 0;
  return bytes_of_image(scene) * (times_of(scene) - 1) + 2 * bytes_of_image(scene) + squares;
}

// Filters over space.

const Image& over_time(const Job& job, std::size_t time) {
  return time == 0 ? job.estimate.get(Data::estimate, job.pass)
                   : job.accumulated.get(Data::accumulated, job.pass).images[time - 1];
}

Image filtered(const Shared& shared, std::string_view pass, const Image& image, std::size_t filter, Rows rows) {
  const SpaceFilterSpec& spec = shared.scene.space[filter];
  if (spec.edges.empty()) return filtered(image, taps_of(spec), shared.scene.border, rows);
  return filtered(image, shared.edge_weights.get(Data::edge_weights, pass)[filter], shared.scene.border, rows);
}

namespace {

// Frames that a history must have before its own variance says more than that among neighbours.
constexpr int long_history = 4;

// What an average of `length` frames leaves of the variance of independent ones, for lengths up to `most`.
std::vector<float> variances_left(const TimeFilterSpec& time, const std::string& kernel, std::int64_t most) {
  std::vector<float> left = {1};
  for (std::int64_t length = 1; length <= most; ++length) {
    const double weight = weight_of_frame(time, kernel, length);
    left.push_back(
        static_cast<float>(weight * weight + (1 - weight) * (1 - weight) * static_cast<double>(left.back())));
  }
  return left;
}

// Of the noise that is left in a picture, pixel by pixel.
std::vector<float> variance_of(const Job& job, const Image& image, std::size_t time) {
  const std::vector<float> brightness = brightness_of(image, job.channels());
  std::vector<float> around = variance_around(brightness, image.width, image.height, job.scene().border, job.rows);
  if (time == 0) return around;
  const Averages& averages = job.accumulated.get(Data::accumulated, job.pass);
  const std::vector<float>& squares = averages.squares[time - 1];
  const std::vector<float> left = variances_left(job.scene().time, job.scene().time.kernels[time - 1], job.frame + 1);
  for (std::size_t i = 0; i < around.size(); ++i) {
    const std::int64_t length = averages.lengths.empty() ? job.frame + 1 : averages.lengths[i];
    if (length < long_history) continue;
    around[i] = std::max(0.0F, squares[i] - brightness[i] * brightness[i]) * left[static_cast<std::size_t>(length)];
  }
  return around;
}

Image guided(const Job& job, const Image& image, std::size_t time, const SpaceFilterSpec& filter) {
  const Hits* hits = nullptr;
  if (!filter.edges.empty())
    hits = job.scene().motion.on ? &job.moving_hits.get(Data::moving_hits, job.pass)
                                 : &job.shared.hits.get(Data::hits, job.pass);
  return a_trous(image, job.channels(), variance_of(job, image, time), hits, filter, job.scene().border, job.rows);
}

}  // namespace

void filter(Job& job) {
  const Scene& scene = job.scene();
  if (!is_measured(scene, job.frame)) return;
  std::vector<Image>& images = job.filtered.make();
  for (std::size_t time = 0; time < static_cast<std::size_t>(times_of(scene)); ++time) {
    const Image& image = over_time(job, time);
    for (std::size_t k = 0; k < scene.space.size(); ++k)
      images.push_back(is_linear(scene.space[k]) ? filtered(job.shared, job.pass, image, k, job.rows)
                                                 : guided(job, image, time, scene.space[k]));
    count_taps(scene, image.channels, 1, *job.counts);
  }
}

Counts work_of_filters(const Scene& scene, std::span<const Noise> noises) {
  Counts counts{};
  const std::int64_t pictures = times_of(scene) * num_measured(scene) * scene.repeats * std::ssize(noises);
  for (const Effect effect : effects_of(scene)) count_taps(scene, planes_of(scene, effect), pictures, counts);
  return counts;
}

std::int64_t bytes_of_filtered(const Scene& scene, std::span<const Noise>) {
  return bytes_of_image(scene) * times_of(scene) * std::ssize(scene.space);
}

int Job::channels() const { return calls_of(shared.effects[effect]).channels(scene()); }

const Image& Job::after(std::size_t stage) const {
  const std::size_t in_time = 1 + scene().space.size();
  if (stage % in_time == 0) return over_time(*this, stage / in_time);
  return filtered.get(Data::filtered, pass)[stage / in_time * (in_time - 1) + stage % in_time - 1];
}

const float* Job::truth_plane(std::size_t stage, int channel) const {
  const std::size_t in_time = 1 + scene().space.size();
  if (truth_changes_with_frame(scene(), shared.effects[effect])) return after(stage).row(channels() + channel, 0);
  const std::vector<Truth>& repeats = shared.truth.get(Data::truth, pass)[effect];
  return repeats[repeats.size() == 1 ? 0 : static_cast<std::size_t>(repeat)].after[stage % in_time].row(channel, 0);
}

}  // namespace noiseloom::render
