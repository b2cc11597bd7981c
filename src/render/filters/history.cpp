// Averages over time of what moves, is rejected at random, or kept within bounds. A pixel's history is that of the
// place that it shows: where that was seen a frame before, on the same shape. Else, and where it is rejected, it begins
// again.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "noiseloom/core/random.h"
#include "render/filters/filter_passes.h"
#include "render/jobs/scene_sizes.h"
#include "render/pictures/a_trous.h"

namespace noiseloom::render {
namespace {

// Pixels of the frame before that a history is read from, and their weights, which add up to 1. None: there is no
// history.
struct Taps {
  int count = 0;
  std::array<std::size_t, 16> pixels{};
  std::array<float, 16> weights{};

  void add(std::size_t pixel, double weight) {
    pixels[static_cast<std::size_t>(count)] = pixel;
    weights[static_cast<std::size_t>(count)] = static_cast<float>(weight);
    ++count;
  }
};

// Of four places in a row, at -1, 0, 1, 2, for what lies between at 0 <= t < 1 [Catmull74].
std::array<double, 4> catmull_rom(double t) {
  return {t * (-0.5 + t * (1 - 0.5 * t)), 1 + t * t * (-2.5 + 1.5 * t), t * (0.5 + t * (2 - 1.5 * t)),
          t * t * (-0.5 + 0.5 * t)};
}

class Histories {
 public:
  Histories(const Job& job, const Hits* now) : job_(job), scene_(job.scene()), now_(now) {}

  Taps taps(int x, int y) const {
    Taps taps;
    if (job_.frame == 0 || is_rejected(place(x, y))) return taps;
    if (now_ == nullptr) {
      taps.add(place(x, y), 1);
      return taps;
    }
    const Shape shape = now_->at(x, y).shape;
    const Step step = step_of(scene_.motion, shape);
    const double from_x = x - step.right;
    const double from_y = y - step.down;
    // What is far outside must not be rounded to an integer.
    if (!(from_x > -2 && from_y > -2 && from_x < scene_.width + 1 && from_y < scene_.height + 1)) return taps;
    const int left = static_cast<int>(std::floor(from_x));
    const int top = static_cast<int>(std::floor(from_y));
    const double part_x = from_x - left;
    const double part_y = from_y - top;
    if (part_x == 0 && part_y == 0) {
      if (shows(left, top, shape)) taps.add(place(left, top), 1);
      return taps;
    }
    if (scene_.time.resampling == Resampling::catmull_rom) {
      add_cubic(taps, left, top, part_x, part_y, shape);
      if (taps.count > 0) return taps;
    }
    add_linear(taps, left, top, part_x, part_y, shape);
    return taps;
  }

 private:
  std::size_t place(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(scene_.width) + static_cast<std::size_t>(x);
  }
  bool shows(int x, int y, Shape shape) const {
    return x >= 0 && y >= 0 && x < scene_.width && y < scene_.height && job_.hits_before.at(x, y).shape == shape;
  }

  // Sixteen pixels, or none where one of them shows something else.
  void add_cubic(Taps& taps, int left, int top, double part_x, double part_y, Shape shape) const {
    const auto across = catmull_rom(part_x);
    const auto down = catmull_rom(part_y);
    for (int dy = -1; dy <= 2; ++dy)
      for (int dx = -1; dx <= 2; ++dx) {
        if (!shows(left + dx, top + dy, shape)) {
          taps.count = 0;
          return;
        }
        taps.add(place(left + dx, top + dy),
                 across[static_cast<std::size_t>(dx + 1)] * down[static_cast<std::size_t>(dy + 1)]);
      }
  }

  // Those of four pixels that show the same.
  void add_linear(Taps& taps, int left, int top, double part_x, double part_y, Shape shape) const {
    double sum = 0;
    for (int dy = 0; dy <= 1; ++dy)
      for (int dx = 0; dx <= 1; ++dx) {
        const double weight = (dx == 0 ? 1 - part_x : part_x) * (dy == 0 ? 1 - part_y : part_y);
        if (!(weight > 0) || !shows(left + dx, top + dy, shape)) continue;
        taps.add(place(left + dx, top + dy), weight);
        sum += weight;
      }
    for (int i = 0; i < taps.count; ++i) taps.weights[static_cast<std::size_t>(i)] /= static_cast<float>(sum);
  }

  bool is_rejected(std::size_t pixel) const {
    const double chance = scene_.time.rejection;
    if (chance <= 0) return false;
    const RandomBlock block = random_block(scene_.seed, purpose_of_rejection, static_cast<std::uint32_t>(job_.frame),
                                           static_cast<std::uint32_t>(job_.repeat), pixel);
    return to_unit_double(block[0], block[1]) < chance;
  }

  const Job& job_;
  const Scene& scene_;
  const Hits* now_;
};

// The values that a history may have: those around the pixel in the frame.
struct Bounds {
  float least;
  float most;
};

Bounds bounds_around(const Image& image, int channel, int x, int y, const TimeFilterSpec& time) {
  float least = image.row(channel, y)[x];
  float most = least;
  float sum = 0;
  float squares = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const float value =
          image.row(channel, inside(y + dy, image.height, Border::clamp))[inside(x + dx, image.width, Border::clamp)];
      least = std::min(least, value);
      most = std::max(most, value);
      sum += value;
      squares += value * value;
    }
  if (time.clamp == Clamp::min_max) return {least, most};
  const float mean = sum / 9;
  const float spread = static_cast<float>(time.gamma) * std::sqrt(std::max(0.0F, squares / 9 - mean * mean));
  return {mean - spread, mean + spread};
}

// A value that is not finite must not stay: 0 times NaN is NaN.
float blended(float alpha, float now, float before) { return alpha == 1 ? now : alpha * now + (1 - alpha) * before; }

template <class ValueOf>
float sum_over(const Taps& taps, ValueOf value_of) {
  float sum = 0;
  for (int i = 0; i < taps.count; ++i)
    sum += taps.weights[static_cast<std::size_t>(i)] * value_of(taps.pixels[static_cast<std::size_t>(i)]);
  return sum;
}

}  // namespace

bool has_histories(const Scene& scene) {
  return scene.motion.on || scene.time.rejection > 0 || scene.time.clamp != Clamp::none;
}

void trace_moving_hits(Job& job) {
  const Scene& scene = job.scene();
  const MotionSpec& motion = scene.motion;
  if (job.moving_hits.is_there()) job.hits_before = std::move(job.moving_hits.get(Data::moving_hits, job.pass));
  const double frame = static_cast<double>(job.frame);
  job.moving_hits.make(make_hits(scene.width, scene.height, frame * (motion.camera[0] - motion.sphere[0]),
                                 frame * (motion.camera[1] - motion.sphere[1]), job.rows,
                                 mesh_of(job.shared, job.pass)));
  count_of(*job.counts, Work::primary_rays) += pixels_of(scene);
}

void average_histories(Job& job) {
  const Scene& scene = job.scene();
  const Image& now = job.estimate.get(Data::estimate, job.pass);
  const std::vector<std::string>& kernels = scene.time.kernels;
  const std::size_t pixels = now.pixels();
  const int channels = job.channels();
  Averages before;
  if (job.accumulated.is_there()) before = std::move(job.accumulated.get(Data::accumulated, job.pass));
  Averages& averages = job.accumulated.make();
  averages.images.assign(kernels.size(), make_image(now.width, now.height, now.channels));
  averages.lengths.resize(pixels);
  std::vector<float> brightness;
  if (is_guided_by_variance(scene)) {
    brightness = brightness_of(now, channels);
    averages.squares.assign(kernels.size(), std::vector<float>(pixels));
  }
  const Histories histories(job, scene.motion.on ? &job.moving_hits.get(Data::moving_hits, job.pass) : nullptr);

  const auto average_pixel = [&](int x, int y) {
    const std::size_t here =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(now.width) + static_cast<std::size_t>(x);
    const Taps taps = histories.taps(x, y);
    int length = 1;
    if (taps.count > 0) {
      length = before.lengths[taps.pixels[0]];
      for (int i = 1; i < taps.count; ++i)
        length = std::min(length, before.lengths[taps.pixels[static_cast<std::size_t>(i)]]);
      ++length;
    }
    averages.lengths[here] = length;
    for (std::size_t k = 0; k < kernels.size(); ++k) {
      const float alpha = static_cast<float>(weight_of_frame(scene.time, kernels[k], length));
      for (int c = 0; c < now.channels; ++c) {
        const std::size_t plane = static_cast<std::size_t>(c) * pixels;
        const float value = now.values[plane + here];
        float history = sum_over(taps, [&](std::size_t pixel) { return before.images[k].values[plane + pixel]; });
        if (scene.time.clamp != Clamp::none && c < channels && taps.count > 0) {
          const Bounds bounds = bounds_around(now, c, x, y, scene.time);
          history = std::clamp(history, bounds.least, bounds.most);
        }
        averages.images[k].values[plane + here] = taps.count == 0 ? value : blended(alpha, value, history);
      }
      if (brightness.empty()) continue;
      const float square = brightness[here] * brightness[here];
      const float history = sum_over(taps, [&](std::size_t pixel) { return before.squares[k][pixel]; });
      averages.squares[k][here] = taps.count == 0 ? square : blended(alpha, square, history);
    }
  };
  job.rows(now.height, [&](int first, int last) {
    for (int y = first; y < last; ++y)
      for (int x = 0; x < now.width; ++x) average_pixel(x, y);
  });
  count_of(*job.counts, Work::averages) += std::ssize(now.values) * std::ssize(kernels);
  count_of(*job.counts, Work::history_reads) += static_cast<std::int64_t>(pixels);
}

Counts work_of_histories(const Scene& scene, std::span<const Noise> noises) {
  Counts counts = work_of_averages(scene, noises);
  count_of(counts, Work::history_reads) =
      pixels_of(scene) * std::ssize(effects_of(scene)) * scene.frames * scene.repeats * std::ssize(noises);
  return counts;
}

}  // namespace noiseloom::render
