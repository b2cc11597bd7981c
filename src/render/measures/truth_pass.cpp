#include "render/measures/truth_pass.h"

#include <algorithm>
#include <cmath>

#include "render/filters/filter_passes.h"
#include "render/jobs/effect_list.h"
#include "render/jobs/job.h"
#include "render/jobs/scene_sizes.h"

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
    truth.after.push_back(is_linear(shared.scene.space[k])
                              ? filtered(shared, shared.pass, truth.after.front(), k, {&shared.pool})
                              : truth.after.front());
  const auto converged = calls_of(effect).converged;
  const Image limit = converged == nullptr ? truth.after.front() : converged(shared);
  for (const Image& after : truth.after) truth.bias.push_back(rms_distance(after, limit));
  return truth;
}

// Where jobs make it frame by frame.
Truth truth_elsewhere(const Scene& scene) {
  Truth truth;
  truth.bias.assign(1 + scene.space.size(), std::nan(""));
  return truth;
}

std::int64_t images_of(const Scene& scene, Effect effect) {
  if (truth_changes_with_frame(scene, effect)) return 0;
  return calls_of(effect).truth_changes_with_repeat(scene) ? scene.repeats : 1;
}

void add_work(const EffectCalls& calls, const Scene& scene, std::int64_t images, Counts& counts) {
  if (calls.work_of_truth == nullptr) return;
  const Counts of_pixel = calls.work_of_truth(scene);
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] += of_pixel[i] * pixels_of(scene) * images;
}

std::int64_t taps_of_linear(const Scene& scene, std::int64_t channels) {
  std::int64_t taps = 0;
  for (const SpaceFilterSpec& filter : scene.space) taps += is_linear(filter) ? channels * taps_of_filter(filter) : 0;
  return taps;
}

}  // namespace

void make_truth(Shared& shared) {
  const Scene& scene = shared.scene;
  auto& all = shared.truth.make();
  for (const Effect effect : shared.effects) {
    const EffectCalls& calls = calls_of(effect);
    std::vector<Truth> truths;
    for (int repeat = 0; repeat < images_of(scene, effect); ++repeat) {
      truths.push_back(filtered_truth(shared, effect, calls.truth(shared, repeat)));
      count_of(*shared.counts, Work::expectations) += pixels_of(scene);
      count_of(*shared.counts, Work::taps) += pixels_of(scene) * taps_of_linear(scene, calls.channels(scene));
      add_work(calls, scene, 1, *shared.counts);
    }
    if (truths.empty()) truths.push_back(truth_elsewhere(scene));
    all.push_back(std::move(truths));
  }
}

Counts work_of_truth(const Scene& scene, std::span<const Noise>) {
  Counts counts{};
  for (const Effect effect : effects_of(scene)) {
    const EffectCalls& calls = calls_of(effect);
    const std::int64_t pixels = pixels_of(scene) * images_of(scene, effect);
    count_of(counts, Work::expectations) += pixels;
    count_of(counts, Work::taps) += pixels * taps_of_linear(scene, calls.channels(scene));
    add_work(calls, scene, images_of(scene, effect), counts);
  }
  return counts;
}

std::int64_t bytes_of_truth(const Scene& scene, std::span<const Noise>) {
  std::int64_t bytes = 0;
  for (const Effect effect : effects_of(scene))
    bytes += 4 * images_of(scene, effect) * pixels_of(scene) * calls_of(effect).channels(scene) *
             (1 + std::ssize(scene.space));
  return bytes;
}

}  // namespace noiseloom::render
