#include "render/filter_passes.h"

#include <algorithm>
#include <cmath>

#include "render/frames.h"
#include "render/scene_sizes.h"

namespace noiseloom::render {

// Averages over the frames so far. Sums of all frames are kept in double: there may be many.

void average(Job& job) {
  const Scene& scene = job.scene();
  const Image& now = job.estimate.get(Data::estimate, job.pass);
  const std::vector<std::string>& kernels = scene.time.kernels;
  if (!job.accumulated.is_there()) {
    Averages& made = job.accumulated.make();
    made.images.assign(kernels.size(), make_image(now.width, now.height, now.channels));
    if (std::find(kernels.begin(), kernels.end(), "mc") != kernels.end()) made.sums.assign(now.values.size(), 0);
  }
  Averages& averages = job.accumulated.get(Data::accumulated, job.pass);
  const double frames = static_cast<double>(job.frame + 1);
  for (std::size_t k = 0; k < kernels.size(); ++k) {
    std::vector<float>& image = averages.images[k].values;
    if (kernels[k] == "mc") {
      for (std::size_t i = 0; i < image.size(); ++i) {
        averages.sums[i] += static_cast<double>(now.values[i]);
        image[i] = static_cast<float>(averages.sums[i] / frames);
      }
    } else {
      const double first = scene.time.start == EmaStart::full ? (job.frame == 0 ? 1 : 0) : 1 / frames;
      const float alpha = static_cast<float>(std::max(scene.time.alpha, first));
      // Written so that alpha = 1 gives the frame itself.
      for (std::size_t i = 0; i < image.size(); ++i) image[i] = alpha * now.values[i] + (1 - alpha) * image[i];
    }
  }
  count_of(*job.counts, Work::averages) += std::ssize(now.values) * std::ssize(kernels);
}

Counts work_of_averages(const Scene& scene, std::span<const Noise> noises) {
  Counts counts{};
  count_of(counts, Work::averages) = pixels_of(scene) * channels_of_all(scene) * std::ssize(scene.time.kernels) *
                                     scene.frames * scene.repeats * std::ssize(noises);
  return counts;
}

std::int64_t bytes_of_averages(const Scene& scene, std::span<const Noise>) {
  return bytes_of_image(scene) * (times_of(scene) - 1) + 2 * bytes_of_image(scene);
}

// Filters over space.

namespace {

const Image& over_time(const Job& job, std::size_t time) {
  return time == 0 ? job.estimate.get(Data::estimate, job.pass)
                   : job.accumulated.get(Data::accumulated, job.pass).images[time - 1];
}

}  // namespace

Image filtered(const Shared& shared, std::string_view pass, const Image& image, std::size_t filter) {
  const SpaceFilterSpec& spec = shared.scene.space[filter];
  if (spec.edges.empty()) return filtered(image, taps_of(spec), shared.scene.border);
  return filtered(image, shared.edge_weights.get(Data::edge_weights, pass)[filter], shared.scene.border);
}

void filter(Job& job) {
  if (!is_measured(job.scene(), job.frame)) return;
  std::vector<Image>& images = job.filtered.make();
  for (std::int64_t time = 0; time < times_of(job.scene()); ++time) {
    const Image& image = over_time(job, static_cast<std::size_t>(time));
    for (std::size_t k = 0; k < job.scene().space.size(); ++k)
      images.push_back(filtered(job.shared, job.pass, image, k));
    count_of(*job.counts, Work::taps) += std::ssize(image.values) * taps_of_all(job.scene());
  }
}

Counts work_of_filters(const Scene& scene, std::span<const Noise> noises) {
  Counts counts{};
  count_of(counts, Work::taps) = pixels_of(scene) * channels_of_all(scene) * taps_of_all(scene) * times_of(scene) *
                                 num_measured(scene) * scene.repeats * std::ssize(noises);
  return counts;
}

std::int64_t bytes_of_filtered(const Scene& scene, std::span<const Noise>) {
  return bytes_of_image(scene) * times_of(scene) * std::ssize(scene.space);
}

// Errors.

namespace {

// Eight sums, which the compiler keeps in vectors, added up in one order.
double mean_square(const Image& a, const Image& b) {
  constexpr std::size_t lanes = 8;
  double sums[lanes] = {};
  const std::size_t size = a.values.size();
  const std::size_t whole = size - size % lanes;
  for (std::size_t i = 0; i < whole; i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const double difference = static_cast<double>(a.values[i + lane]) - static_cast<double>(b.values[i + lane]);
      sums[lane] += difference * difference;
    }
  for (std::size_t i = whole; i < size; ++i) {
    const double difference = static_cast<double>(a.values[i]) - static_cast<double>(b.values[i]);
    sums[i % lanes] += difference * difference;
  }
  double sum = 0;
  for (const double one : sums) sum += one;
  return sum / static_cast<double>(size);
}

}  // namespace

void measure(Job& job) {
  const Scene& scene = job.scene();
  if (!job.errors.is_there())
    job.errors.make(std::vector<double>(job.shared.stages.size() * static_cast<std::size_t>(scene.frames)));
  if (!is_measured(scene, job.frame)) return;
  std::vector<double>& errors = job.errors.get(Data::errors, job.pass);
  const Truth& truth = job.truth();
  for (std::size_t stage = 0; stage < job.shared.stages.size(); ++stage) {
    const Image& image = job.after(stage);
    errors[stage * static_cast<std::size_t>(scene.frames) + static_cast<std::size_t>(job.frame)] =
        mean_square(image, truth.after[stage % truth.after.size()]);
    count_of(*job.counts, Work::differences) += std::ssize(image.values);
  }
}

Counts work_of_errors(const Scene& scene, std::span<const Noise> noises) {
  Counts counts{};
  count_of(counts, Work::differences) = pixels_of(scene) * channels_of_all(scene) * std::ssize(stages_of(scene)) *
                                        num_measured(scene) * scene.repeats * std::ssize(noises);
  return counts;
}

std::int64_t bytes_of_errors(const Scene& scene, std::span<const Noise>) {
  return 8 * std::ssize(stages_of(scene)) * scene.frames;
}

// Pictures: of the last frame of the first repeat.

void keep(Job& job) {
  if (job.repeat != 0 || job.frame != job.scene().frames - 1) return;
  std::vector<Image>& pictures = job.pictures.make();
  for (std::size_t stage = 0; stage < job.shared.stages.size(); ++stage) pictures.push_back(job.after(stage));
}

std::int64_t bytes_of_pictures(const Scene& scene, std::span<const Noise> noises) {
  return 4 * pixels_of(scene) * channels_of_all(scene) * std::ssize(stages_of(scene)) * std::ssize(noises);
}

const Image& Job::after(std::size_t stage) const {
  const std::size_t in_time = 1 + scene().space.size();
  if (stage % in_time == 0) return over_time(*this, stage / in_time);
  return filtered.get(Data::filtered, pass)[stage / in_time * (in_time - 1) + stage % in_time - 1];
}

}  // namespace noiseloom::render
