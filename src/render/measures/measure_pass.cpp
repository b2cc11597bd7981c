#include "render/measures/measure_pass.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "noiseloom/core/math.h"
#include "noiseloom/measure/spectrum.h"
#include "render/jobs/frames.h"
#include "render/jobs/scene_sizes.h"
#include "render/measures/pattern.h"
#include "render/pictures/a_trous.h"
#include "render/pictures/flip.h"
#include "render/pictures/spectra.h"

namespace noiseloom::render {
namespace {

// Sums over a row in eight parts, which the compiler keeps in vectors, added up in one order.
struct Sums {
  double plain = 0;
  double squares = 0;
};

Sums sums_of_row(const float* a, const float* b, std::size_t size) {
  constexpr std::size_t lanes = 8;
  double plain[lanes] = {};
  double squares[lanes] = {};
  const std::size_t whole = size - size % lanes;
  for (std::size_t i = 0; i < whole; i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const double difference = static_cast<double>(a[i + lane]) - static_cast<double>(b[i + lane]);
      plain[lane] += difference;
      squares[lane] += difference * difference;
    }
  for (std::size_t i = whole; i < size; ++i) {
    const double difference = static_cast<double>(a[i]) - static_cast<double>(b[i]);
    plain[i % lanes] += difference;
    squares[i % lanes] += difference * difference;
  }
  Sums sums;
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    sums.plain += plain[lane];
    sums.squares += squares[lane];
  }
  return sums;
}

// The mean square of the difference, and that around the mean of each channel.
struct Squares {
  double whole = 0;
  double around_mean = 0;
};

Squares squares_of(const Job& job, std::size_t stage) {
  const Image& image = job.after(stage);
  const auto width = static_cast<std::size_t>(image.width);
  const int rows = image.height * job.channels();
  std::vector<Sums> sums(static_cast<std::size_t>(rows));
  job.rows(rows, [&](int first, int last) {
    for (int row = first; row < last; ++row) {
      const std::size_t offset = static_cast<std::size_t>(row % image.height) * width;
      const int channel = row / image.height;
      sums[static_cast<std::size_t>(row)] =
          sums_of_row(image.row(channel, 0) + offset, job.truth_plane(stage, channel) + offset, width);
    }
  });
  const double pixels = static_cast<double>(image.pixels());
  Squares squares;
  for (int c = 0; c < job.channels(); ++c) {
    Sums sum;
    for (int y = 0; y < image.height; ++y) {
      const Sums& row = sums[static_cast<std::size_t>(c * image.height + y)];
      sum.plain += row.plain;
      sum.squares += row.squares;
    }
    squares.whole += sum.squares / pixels / job.channels();
    const double mean = sum.plain / pixels;
    squares.around_mean += std::max(0.0, sum.squares / pixels - mean * mean) / job.channels();
  }
  return squares;
}

Image truth_of(const Job& job, std::size_t stage) {
  const Image& like = job.after(stage);
  Image truth = make_image(like.width, like.height, job.channels());
  for (int c = 0; c < truth.channels; ++c) std::copy_n(job.truth_plane(stage, c), truth.pixels(), truth.row(c, 0));
  return truth;
}

Image difference_of(const Job& job, std::size_t stage) {
  Image difference = truth_of(job, stage);
  const Image& image = job.after(stage);
  for (std::size_t i = 0; i < difference.values.size(); ++i)
    difference.values[i] = image.values[i] - difference.values[i];
  return difference;
}

double share_unseen(const Job& job) {
  if (job.shared.effects[job.effect] != Effect::sparse) return std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::uint8_t>& seen = job.seen.get(Data::seen, job.pass);
  return static_cast<double>(std::count(seen.begin(), seen.end(), 0)) / static_cast<double>(seen.size());
}

// Of pictures of so many channels.
void count_measures(const Scene& scene, std::int64_t channels, std::int64_t pictures, Counts& counts) {
  const std::vector<Metric> metrics = metrics_of(scene);
  const std::int64_t values = pixels_of(scene) * pictures;
  count_of(counts, Work::differences) += values * channels;
  for (const Metric metric : metrics) {
    if (metric == Metric::ssim) count_of(counts, Work::taps) += values * 5 * 2 * 11;  // five pictures, filtered
    if (metric == Metric::flip) count_of(counts, Work::taps) += values * 2 * 8 * (21 + 19);
    if (metric == Metric::pattern || metric == Metric::median) count_of(counts, Work::ranks) += values;
    if (metric == Metric::low) count_of(counts, Work::transformed_values) += values * channels;
  }
}

void measure_stage(Job& job, std::size_t stage, std::span<double> errors) {
  const std::vector<Metric> metrics = metrics_of(job.scene());
  const auto per_metric = job.shared.stages.size() * static_cast<std::size_t>(job.scene().frames);
  const std::size_t place = stage * static_cast<std::size_t>(job.scene().frames) + static_cast<std::size_t>(job.frame);
  const Squares squares = squares_of(job, stage);
  std::array<double, 3> bands{};
  std::array<double, 3> quantiles{};
  for (std::size_t m = 0; m < metrics.size(); ++m) {
    double& error = errors[m * per_metric + place];
    switch (metrics[m]) {
      case Metric::rmse:
        error = squares.whole;
        break;
      case Metric::deviation:
        error = squares.around_mean;
        break;
      case Metric::ssim:
        error = structural_error(job.after(stage), truth_of(job, stage), job.channels(), job.scene().border, job.rows);
        break;
      case Metric::low:
        bands = powers_in_bands(difference_of(job, stage));
        error = bands[0];
        break;
      case Metric::middle:
        error = bands[1];
        break;
      case Metric::high:
        error = bands[2];
        break;
      case Metric::unseen:
        error = share_unseen(job);
        break;
      case Metric::pattern:
        error = pattern_error(difference_of(job, stage), job.channels(), mask_of_job(job));
        break;
      case Metric::flip:
        error = flip_error(job.after(stage), truth_of(job, stage), job.channels(), job.scene().border, job.rows);
        break;
      case Metric::median:
        quantiles = quantiles_of_error(difference_of(job, stage));
        error = quantiles[0];
        break;
      case Metric::p99:
        error = quantiles[1];
        break;
      case Metric::largest:
        error = quantiles[2];
        break;
    }
  }
}

}  // namespace

double structural_error(const Image& a, const Image& b, int channels, Border border, Rows rows) {
  constexpr double small = 0.01 * 0.01;
  constexpr double small_spread = 0.03 * 0.03;
  std::vector<float> taps;
  float sum = 0;
  for (int d = -5; d <= 5; ++d) taps.push_back(static_cast<float>(math::exp(-d * d / (2 * 1.5 * 1.5))));
  for (const float tap : taps) sum += tap;
  for (float& tap : taps) tap /= sum;
  const std::vector<float> x = brightness_of(a, channels);
  const std::vector<float> y = brightness_of(b, channels);
  const auto smoothed = [&](const auto& value_of) {
    Image image = make_image(a.width, a.height, 1);
    for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = value_of(i);
    return filtered(image, taps, border, rows).values;
  };
  const auto mean_x = smoothed([&](std::size_t i) { return x[i]; });
  const auto mean_y = smoothed([&](std::size_t i) { return y[i]; });
  const auto square_x = smoothed([&](std::size_t i) { return x[i] * x[i]; });
  const auto square_y = smoothed([&](std::size_t i) { return y[i] * y[i]; });
  const auto product = smoothed([&](std::size_t i) { return x[i] * y[i]; });
  double similarity = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double mx = static_cast<double>(mean_x[i]);
    const double my = static_cast<double>(mean_y[i]);
    const double spread_x = static_cast<double>(square_x[i]) - mx * mx;
    const double spread_y = static_cast<double>(square_y[i]) - my * my;
    const double together = static_cast<double>(product[i]) - mx * my;
    similarity += (2 * mx * my + small) * (2 * together + small_spread) /
                  ((mx * mx + my * my + small) * (spread_x + spread_y + small_spread));
  }
  return 1 - similarity / static_cast<double>(x.size());
}

std::array<double, 3> powers_in_bands(const Image& difference) {
  std::array<double, 3> powers{};
  Texture texture = make_texture(Extents({difference.width, difference.height}), difference.channels);
  texture.values = difference.values;
  double variance = 0;
  const double pixels = static_cast<double>(difference.pixels());
  for (int c = 0; c < difference.channels; ++c) {
    const float* const values = difference.row(c, 0);
    double sum = 0;
    double squares = 0;
    for (std::size_t i = 0; i < difference.pixels(); ++i) {
      sum += static_cast<double>(values[i]);
      squares += static_cast<double>(values[i]) * static_cast<double>(values[i]);
    }
    variance += std::max(0.0, squares / pixels - sum / pixels * sum / pixels) / difference.channels;
  }
  if (!(variance > 0)) return powers;
  const DistanceKind kind = difference.channels == 1 ? DistanceKind::absolute : DistanceKind::euclidean;
  const PlaneSpectrum spectrum = plane_spectrum(texture, kind, 0, 1);
  for (int v = 0; v < spectrum.height; ++v)
    for (int u = 0; u < spectrum.width; ++u) {
      const double fx = static_cast<double>(u - spectrum.width / 2) / spectrum.width;
      const double fy = static_cast<double>(v - spectrum.height / 2) / spectrum.height;
      const double frequency = std::sqrt(fx * fx + fy * fy);
      powers[frequency < 0.05 ? 0 : frequency < 0.15 ? 1 : 2] += variance * spectrum.at(u, v) / pixels;
    }
  return powers;
}

std::array<double, 3> quantiles_of_error(const Image& difference) {
  std::vector<float> errors(difference.pixels());
  for (int c = 0; c < difference.channels; ++c)
    for (std::size_t i = 0; i < errors.size(); ++i) errors[i] += difference.row(c, 0)[i] * difference.row(c, 0)[i];
  const auto at = [&](std::size_t rank) {
    std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(rank), errors.end());
    return std::sqrt(static_cast<double>(errors[rank]) / difference.channels);
  };
  const std::size_t last = errors.size() - 1;
  return {at(last / 2), at(last - last / 100), at(last)};
}

void measure(Job& job) {
  const Scene& scene = job.scene();
  if (!job.errors.is_there())
    job.errors.make(std::vector<double>(metrics_of(scene).size() * job.shared.stages.size() *
                                        static_cast<std::size_t>(scene.frames)));
  if (!is_measured(scene, job.frame)) return;
  std::vector<double>& errors = job.errors.get(Data::errors, job.pass);
  for (std::size_t stage = 0; stage < job.shared.stages.size(); ++stage) {
    measure_stage(job, stage, errors);
    count_measures(scene, job.channels(), 1, *job.counts);
  }
}

Counts work_of_errors(const Scene& scene, std::span<const Noise> noises) {
  Counts counts{};
  const std::int64_t pictures = std::ssize(stages_of(scene)) * num_measured(scene) * scene.repeats * std::ssize(noises);
  for (const Effect effect : effects_of(scene))
    count_measures(scene, calls_of(effect).channels(scene), pictures, counts);
  return counts;
}

// The curves of all jobs, which are kept to the end.
std::int64_t bytes_of_errors(const Scene& scene, std::span<const Noise> noises) {
  return 8 * std::ssize(metrics_of(scene)) * std::ssize(stages_of(scene)) * scene.frames * scene.repeats *
         std::ssize(noises) * std::ssize(effects_of(scene));
}

// Pictures: of the last frame of the first repeat.

void keep(Job& job) {
  if (job.repeat != 0 || job.frame != job.scene().frames - 1) return;
  Pictures& pictures = job.pictures.make();
  for (std::size_t stage = 0; stage < job.shared.stages.size(); ++stage) {
    Image image = job.after(stage);
    image.channels = job.channels();
    image.values.resize(image.pixels() * static_cast<std::size_t>(image.channels));
    pictures.after.push_back(std::move(image));
    if (truth_changes_with_frame(job.scene(), job.shared.effects[job.effect]))
      pictures.truths.push_back(truth_of(job, stage));
  }
}

std::int64_t bytes_of_pictures(const Scene& scene, std::span<const Noise> noises) {
  return 4 * pixels_of(scene) * channels_of_all(scene) * std::ssize(stages_of(scene)) * std::ssize(noises);
}

void see(Job& job) {
  if (job.shared.effects[job.effect] != Effect::sparse) return;
  const Image& now = job.estimate.get(Data::estimate, job.pass);
  if (!job.seen.is_there()) job.seen.make(std::vector<std::uint8_t>(now.pixels()));
  std::vector<std::uint8_t>& seen = job.seen.get(Data::seen, job.pass);
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (now.values[i] > 0) seen[i] = 1;
}

// Spectra: of the errors of all frames of the first repeat.

void stack(Job& job) {
  const Scene& scene = job.scene();
  if (job.repeat != 0) return;
  const auto times = static_cast<std::size_t>(times_of(scene));
  if (!job.stacks.is_there())
    job.stacks.make(
        std::vector<Texture>(times, make_texture(Extents({scene.width, scene.height, scene.frames}), job.channels())));
  std::vector<Texture>& stacks = job.stacks.get(Data::stacks, job.pass);
  for (std::size_t time = 0; time < times; ++time) {
    const Image difference = difference_of(job, time * (1 + scene.space.size()));
    std::copy(difference.values.begin(), difference.values.end(), stacks[time].slice(SliceIndex(job.frame)));
  }
  if (job.frame != scene.frames - 1) return;
  for (std::size_t time = 0; time < times; ++time) {
    job.spectra.push_back(error_spectrum(stacks[time], time > 0));
    count_of(*job.counts, Work::transformed_values) += 2 * pixels_of(scene) * scene.frames * job.channels();
  }
  stacks.clear();
}

Counts work_of_spectra(const Scene& scene, std::span<const Noise> noises) {
  Counts counts{};
  count_of(counts, Work::transformed_values) =
      2 * pixels_of(scene) * scene.frames * channels_of_all(scene) * times_of(scene) * std::ssize(noises);
  return counts;
}

std::int64_t bytes_of_spectra(const Scene& scene, std::span<const Noise>) {
  return bytes_of_image(scene) * scene.frames * times_of(scene);
}

}  // namespace noiseloom::render
