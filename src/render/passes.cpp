// The table of passes, and what each does.
#include "noiseloom/render/passes.h"

#include <algorithm>
#include <cmath>

#include "render/effect_list.h"
#include "render/frames.h"
#include "render/job.h"

namespace noiseloom::render {
namespace {

constexpr const char* applies = "";

std::int64_t pixels_of(const Scene& scene) { return std::int64_t{scene.width} * scene.height; }

std::int64_t channels_of_all(const Scene& scene) {
  std::int64_t channels = 0;
  for (const Effect effect : effects_of(scene)) channels += calls_of(effect).channels(scene);
  return channels;
}

int most_channels_of(const Scene& scene) {
  int most = 0;
  for (const Effect effect : effects_of(scene)) most = std::max(most, calls_of(effect).channels(scene));
  return most;
}

std::int64_t taps_of_all(const Scene& scene) {
  std::int64_t taps = 0;
  for (const SpaceFilterSpec& filter : scene.space) taps += 2 * static_cast<std::int64_t>(taps_of(filter).size());
  return taps;
}

std::int64_t bytes_of_image(const Scene& scene) { return 4 * pixels_of(scene) * most_channels_of(scene); }

std::int64_t times_of(const Scene& scene) { return 1 + static_cast<std::int64_t>(scene.time.kernels.size()); }

// Noises.

void make_noises(Shared& shared) { shared.noises.make(&shared.opened); }

std::int64_t bytes_of_noises(const Scene&, std::span<const Noise> noises) {
  std::int64_t bytes = 0;
  for (const Noise& noise : noises) bytes += noise.texture == nullptr ? 0 : 4 * std::ssize(noise.texture->values);
  return bytes;
}

// The truth, before and after every filter over space.

Truth filtered_truth(const Shared& shared, Image image) {
  Truth truth;
  truth.after.push_back(std::move(image));
  for (const SpaceFilterSpec& filter : shared.scene.space)
    truth.after.push_back(filtered(truth.after.front(), taps_of(filter), shared.scene.border));
  return truth;
}

void make_truth(Shared& shared) {
  auto& all = shared.truth.make();
  for (const Effect effect : shared.effects) {
    const EffectCalls& calls = calls_of(effect);
    const int repeats = calls.truth_changes_with_repeat(shared.scene) ? shared.scene.repeats : 1;
    std::vector<Truth> truths;
    for (int repeat = 0; repeat < repeats; ++repeat) {
      truths.push_back(filtered_truth(shared, calls.truth(shared, repeat)));
      count_of(*shared.counts, Work::expectations) += pixels_of(shared.scene);
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
    count_of(counts, Work::expectations) += pixels_of(scene) * images;
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

// Estimates.

template <Effect effect>
Counts work_of_effect(const Scene& scene, std::span<const Noise> noises) {
  Counts counts{};
  const std::int64_t pixels = pixels_of(scene) * num_rendered(scene) * scene.repeats;
  const std::int64_t numbers = calls_of(effect).numbers(scene);
  for (const Noise& noise : noises) {
    const std::int64_t in_value = std::max(1, noise.numbers_in_value());
    count_of(counts, Work::estimates) += pixels;
    count_of(counts, Work::noise_values) += pixels * ((numbers + in_value - 1) / in_value);
  }
  return counts;
}

std::int64_t bytes_of_estimate(const Scene& scene, std::span<const Noise>) { return bytes_of_image(scene); }

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

const Image& over_time(const Job& job, std::size_t time) {
  return time == 0 ? job.estimate.get(Data::estimate, job.pass)
                   : job.accumulated.get(Data::accumulated, job.pass).images[time - 1];
}

void filter(Job& job) {
  if (!is_measured(job.scene(), job.frame)) return;
  std::vector<Image>& images = job.filtered.make();
  for (std::int64_t time = 0; time < times_of(job.scene()); ++time)
    for (const SpaceFilterSpec& filter : job.scene().space) {
      const Image& image = over_time(job, static_cast<std::size_t>(time));
      const std::vector<float> taps = taps_of(filter);
      images.push_back(filtered(image, taps, job.scene().border));
      count_of(*job.counts, Work::taps) += std::ssize(image.values) * 2 * std::ssize(taps);
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

double mean_square(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const double difference = static_cast<double>(a.values[i]) - static_cast<double>(b.values[i]);
    sum += difference * difference;
  }
  return sum / static_cast<double>(a.values.size());
}

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

Counts no_work(const Scene&, std::span<const Noise>) { return {}; }

std::string always(const Scene&) { return applies; }

constexpr Pass pass_table[] = {
    {"noises", {}, {Data::noises}, always, make_noises, nullptr, no_work, bytes_of_noises},
    {"picture",
     {},
     {Data::picture},
     [](const Scene& scene) -> std::string { return scene.dither.on ? applies : "nothing is dithered"; },
     [](Shared& shared) {
       shared.picture.make(test_picture(shared.scene.dither, shared.scene.width, shared.scene.height));
     },
     nullptr,
     no_work,
     [](const Scene& scene, std::span<const Noise>) {
       return 4 * pixels_of(scene) * channels_of(scene.dither.picture);
     }},
    {"truth", {Data::picture}, {Data::truth}, always, make_truth, nullptr, work_of_truth, bytes_of_truth},
    {"integrand",
     {Data::noises},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.integrand.on ? applies : "no effects.integrand"; },
     nullptr,
     [](Job& job) { integrand_calls.estimate(job); },
     work_of_effect<Effect::integrand>,
     bytes_of_estimate},
    {"dither",
     {Data::noises, Data::picture},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.dither.on ? applies : "no effects.dither"; },
     nullptr,
     [](Job& job) { dither_calls.estimate(job); },
     work_of_effect<Effect::dither>,
     bytes_of_estimate},
    {"transparency",
     {Data::noises},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.transparency.on ? applies : "no effects.transparency"; },
     nullptr,
     [](Job& job) { transparency_calls.estimate(job); },
     work_of_effect<Effect::transparency>,
     bytes_of_estimate},
    {"filter over time",
     {Data::estimate},
     {Data::accumulated},
     [](const Scene& scene) -> std::string { return scene.time.kernels.empty() ? "no filter.time.kernels" : applies; },
     nullptr,
     average,
     work_of_averages,
     bytes_of_averages},
    {"filter over space",
     {Data::estimate, Data::accumulated},
     {Data::filtered},
     [](const Scene& scene) -> std::string { return scene.space.empty() ? "no filter.space" : applies; },
     nullptr,
     filter,
     work_of_filters,
     bytes_of_filtered},
    {"errors",
     {Data::truth, Data::estimate, Data::accumulated, Data::filtered},
     {Data::errors},
     always,
     nullptr,
     measure,
     work_of_errors,
     bytes_of_errors},
    {"pictures",
     {Data::truth, Data::estimate, Data::accumulated, Data::filtered},
     {Data::pictures},
     [](const Scene& scene) -> std::string {
       return scene.puts_out("images") ? applies : "image.outputs has no images";
     },
     nullptr,
     keep,
     no_work,
     bytes_of_pictures},
};

// Whoever needs data comes after all that make it.
constexpr bool is_in_order() {
  for (std::size_t reader = 0; reader < std::size(pass_table); ++reader)
    for (std::size_t maker = reader; maker < std::size(pass_table); ++maker)
      if (pass_table[reader].needs.meets(pass_table[maker].makes)) return false;
  return true;
}
static_assert(is_in_order());

}  // namespace

std::span<const Pass> all_passes() { return pass_table; }

const EffectCalls& calls_of(Effect effect) {
  switch (effect) {
    case Effect::integrand:
      return integrand_calls;
    case Effect::dither:
      return dither_calls;
    case Effect::transparency:
      break;
  }
  return transparency_calls;
}

const Image& Job::after(std::size_t stage) const {
  const std::size_t in_time = 1 + scene().space.size();
  if (stage % in_time == 0) return over_time(*this, stage / in_time);
  return filtered.get(Data::filtered, pass)[stage / in_time * (in_time - 1) + stage % in_time - 1];
}

const Truth& Job::truth() const {
  const std::vector<Truth>& repeats = shared.truth.get(Data::truth, pass)[effect];
  return repeats[repeats.size() == 1 ? 0 : static_cast<std::size_t>(repeat)];
}

}  // namespace noiseloom::render
