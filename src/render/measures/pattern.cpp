#include "render/measures/pattern.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "render/jobs/job.h"
#include "render/pictures/a_trous.h"

namespace noiseloom::render {
namespace {

constexpr int side_of_window = 8;

// The places of values in their order, less the middle one; equal values share the mean of theirs.
std::vector<double> ranks_of(const std::vector<float>& values) {
  std::vector<std::size_t> order(values.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> ranks(values.size());
  for (std::size_t first = 0; first < order.size();) {
    std::size_t end = first + 1;  // what is no number equals not even itself
    while (end < order.size() && values[order[end]] == values[order[first]]) ++end;
    for (std::size_t i = first; i < end; ++i)
      ranks[order[i]] = 0.5 * static_cast<double>(first + end) - 0.5 * static_cast<double>(values.size());
    first = end;
  }
  return ranks;
}

}  // namespace

double pattern_error(const Image& image, int channels, const std::vector<float>& mask) {
  const std::vector<float> brightness = brightness_of(image, channels);
  double sum = 0;
  int windows = 0;
  std::vector<float> values;
  std::vector<float> wanted;
  for (int top = 0; top < image.height; top += side_of_window)
    for (int left = 0; left < image.width; left += side_of_window) {
      values.clear();
      wanted.clear();
      for (int y = top; y < std::min(top + side_of_window, image.height); ++y)
        for (int x = left; x < std::min(left + side_of_window, image.width); ++x) {
          const std::size_t i =
              static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x);
          values.push_back(brightness[i]);
          wanted.push_back(mask[i]);
        }
      const std::vector<double> a = ranks_of(values);
      const std::vector<double> b = ranks_of(wanted);
      double together = 0;
      double square_a = 0;
      double square_b = 0;
      for (std::size_t i = 0; i < a.size(); ++i) {
        together += a[i] * b[i];
        square_a += a[i] * a[i];
        square_b += b[i] * b[i];
      }
      if (!(square_a > 0 && square_b > 0)) continue;
      sum += together / std::sqrt(square_a * square_b);
      ++windows;
    }
  return windows == 0 ? 1 : 1 - sum / windows;
}

std::vector<float> mask_of_job(const Job& job) {
  const std::vector<Noise>& noises = *job.shared.noises.get(Data::noises, job.pass);
  const auto has_seeds = [](const Noise& noise) { return noise.spec.kind == NoiseKind::heitz_belcour; };
  if (has_seeds(noises[job.noise])) return mask_of(job, noises[job.noise], job.frame);
  const auto first = std::find_if(noises.begin(), noises.end(), has_seeds);
  if (first == noises.end()) throw std::logic_error("a pattern is measured without a noise that follows one");
  return mask_of(job, *first, job.frame);
}

}  // namespace noiseloom::render
