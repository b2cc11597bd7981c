#include "render/truth_pass.h"

#include <algorithm>
#include <cmath>

#include "render/effect_list.h"
#include "render/filter_passes.h"
#include "render/job.h"
#include "render/scene_sizes.h"

namespace noiseloom::render {
namespace {

double rms_distance(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const double difference = static_cast<double>(a.values[i]) - static_cast<double>(b.values[i]);
    sum += difference * difference;
  }
  return std::sqrt(sum / static_cast<double>(a.values.size()));
}

Truth filtered_truth(const Shared& shared, Effect effect, Image image) {
  Truth truth;
  truth.after.push_back(std::move(image));
  for (std::size_t k = 0; k < shared.scene.space.size(); ++k)
    truth.after.push_back(filtered(shared, shared.pass, truth.after.front(), k));
  const auto converged = calls_of(effect).converged;
  const Image limit = converged == nullptr ? truth.after.front() : converged(shared);
  for (const Image& after : truth.after)
    truth.bias.push_back(shared.scene.motion.on ? std::nan("") : rms_distance(after, limit));
  return truth;
}

// Effects on surfaces have one channel.
Image image_around_truth(const Scene& scene) {
  Image image = make_image(scene.width, scene.height, 1);
  std::fill(image.values.begin(), image.values.end(), moving_truth);
  return image;
}

}  // namespace

void make_truth(Shared& shared) {
  auto& all = shared.truth.make();
  for (const Effect effect : shared.effects) {
    const EffectCalls& calls = calls_of(effect);
    const int repeats = calls.truth_changes_with_repeat(shared.scene) ? shared.scene.repeats : 1;
    std::vector<Truth> truths;
    for (int repeat = 0; repeat < repeats; ++repeat) {
      truths.push_back(filtered_truth(
          shared, effect, shared.scene.motion.on ? image_around_truth(shared.scene) : calls.truth(shared, repeat)));
      if (!shared.scene.motion.on) count_of(*shared.counts, Work::expectations) += pixels_of(shared.scene);
      count_of(*shared.counts, Work::taps) +=
          pixels_of(shared.scene) * calls.channels(shared.scene) * taps_of_all(shared.scene);
    }
    all.push_back(std::move(truths));
  }
}

Counts work_of_truth(const Scene& scene, std::span<const Noise>) {
  Counts counts{};
  for (const Effect effect : effects_of(scene)) {
    const EffectCalls& calls = calls_of(effect);
    const std::int64_t images = calls.truth_changes_with_repeat(scene) ? scene.repeats : 1;
    if (!scene.motion.on) count_of(counts, Work::expectations) += pixels_of(scene) * images;
    count_of(counts, Work::taps) += pixels_of(scene) * calls.channels(scene) * taps_of_all(scene) * images;
  }
  return counts;
}

std::int64_t bytes_of_truth(const Scene& scene, std::span<const Noise>) {
  std::int64_t bytes = 0;
  for (const Effect effect : effects_of(scene)) {
    const EffectCalls& calls = calls_of(effect);
    const std::int64_t images = calls.truth_changes_with_repeat(scene) ? scene.repeats : 1;
    bytes += 4 * images * pixels_of(scene) * calls.channels(scene) * (1 + std::ssize(scene.space));
  }
  return bytes;
}

}  // namespace noiseloom::render
