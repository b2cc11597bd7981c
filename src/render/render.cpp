#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <set>

#include "noiseloom/core/error.h"
#include "noiseloom/core/stopwatch.h"
#include "noiseloom/render/result.h"
#include "render/jobs/effects.h"
#include "render/jobs/frames.h"
#include "render/jobs/job.h"

namespace noiseloom::render {
namespace {

const char* what_else(Effect effect) {
  switch (effect) {
    case Effect::occlusion:
      return " or directions";
    case Effect::convolution:
      return " or points of the kernel: disk, hexagon, star, or an image onto the square that is the kernel";
    case Effect::sky:
      return " or directions of the sky's image onto the hemisphere";
    default:
      return "";
  }
}

// An effect of unit numbers cannot use directions, nor what is not spread evenly over 0..1.
void check_noises(const Scene& scene, const std::vector<Noise>& noises) {
  std::vector<Fault> faults;
  for (const Noise& noise : noises)
    for (const Effect effect : effects_of(scene))
      if (calls_of(effect).numbers(scene, noise) == 0)
        faults.push_back(
            {"noise \"" + noise.spec.name + "\"",
             fmt::format(
                 "holds samples of {}; {} takes numbers that are spread evenly over 0 to 1 (uniform, vector2, ...){}",
                 noise.samples.space, name_of(effect), what_else(effect))});
  throw_if_any(std::move(faults));
}

// A small texture has few places to read further values at: where two of a pixel are read at one place they are the
// same number, and what should be independent is not.
std::string note_of_places(const Scene& scene, const Noise& noise, Effect effect) {
  const int numbers = calls_of(effect).numbers(scene, noise);
  if (noise.texture == nullptr || numbers == 0) return {};
  const Extents& extents = noise.texture->extents;
  const auto values = static_cast<int>(values_of_pixel(noise, numbers));
  const TextureRead read = {.width = extents.width(),
                            .height = extents.height(),
                            .num_slices = extents.num_slices(),
                            .values = values,
                            .from = noise.spec.values_from};
  std::set<std::array<std::int64_t, 3>> places;
  for (int i = 0; i < values; ++i) {
    const TextureRead::Place place = read.place(0, i);
    places.insert({place.dx, place.dy, place.slice.value()});
  }
  const auto apart = std::ssize(places);
  if (apart == values) return {};
  return fmt::format(
      "noise \"{}\": of the {} values that {} reads for a pixel and frame only {} are at places of their own, as the "
      "texture is small ({}): the others are the same numbers again, and the mean of the estimate another",
      noise.spec.name, values, name_of(effect), apart, extents.to_string());
}

bool is_pass_of(const Pass& pass, Effect effect) {
  return !pass.makes.has(Data::estimate) || pass.name == name_of(effect);
}

ResultPicture picture_of(const Image& image) { return {image.width, image.height, image.channels, image.values}; }

// Runs all frames of a job and adds what its passes did to theirs.
class Jobs {
 public:
  Jobs(const Shared& shared, Result& result) : shared_(shared), result_(result) {}

  // `rows`: the threads on which rows of its pictures are made.
  void run(std::int64_t number, Rows rows) {
    const auto repeats = static_cast<std::int64_t>(result_.repeats);
    const auto num_noises = std::ssize(result_.noises);
    Job job{.shared = shared_,
            .effect = static_cast<std::size_t>(number / (num_noises * repeats)),
            .noise = static_cast<std::size_t>(number / repeats % num_noises),
            .repeat = static_cast<int>(number % repeats),
            .rows = rows};
    std::vector<PassResult> passes(result_.passes.size());
    for (job.frame = 0; job.frame < shared_.scene.frames; ++job.frame)
      if (is_rendered(shared_.scene, job.frame)) run_frame(job, passes);
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < passes.size(); ++i) {
      result_.passes[i].calls += passes[i].calls;
      result_.passes[i].seconds += passes[i].seconds;
      for (std::size_t k = 0; k < passes[i].counted.size(); ++k) result_.passes[i].counted[k] += passes[i].counted[k];
    }
    store(job);
  }

 private:
  void run_frame(Job& job, std::vector<PassResult>& passes) const {
    for (std::size_t i = 0; i < passes.size(); ++i) {
      const PlannedPass& planned = result_.passes[i].planned;
      const Pass& pass = *planned.pass;
      if (!planned.on || pass.frame == nullptr || !is_pass_of(pass, shared_.effects[job.effect])) continue;
      const Stopwatch watch;
      job.pass = pass.name;
      job.counts = &passes[i].counted;
      pass.frame(job);
      ++passes[i].calls;
      passes[i].seconds += watch.seconds() * (job.rows.pool == nullptr ? 1 : job.rows.pool->num_threads());
    }
  }

  void store(Job& job) {
    const std::vector<double>& errors = job.errors.get(Data::errors, "results");
    const std::size_t place =
        (job.effect * result_.noises.size() + job.noise) * static_cast<std::size_t>(result_.repeats) +
        static_cast<std::size_t>(job.repeat);
    const std::size_t curve = errors.size() / result_.metrics.size();
    for (std::size_t m = 0; m < result_.metrics.size(); ++m) {
      std::vector<double>& all = m == 0 ? result_.squares : result_.further[m - 1];
      std::copy_n(errors.begin() + static_cast<std::ptrdiff_t>(m * curve), curve,
                  all.begin() + static_cast<std::ptrdiff_t>(place * curve));
    }
    const std::size_t of_noise = job.effect * result_.noises.size() + job.noise;
    if (!job.spectra.empty())
      std::move(job.spectra.begin(), job.spectra.end(),
                result_.spectra.begin() + static_cast<std::ptrdiff_t>(of_noise * result_.num_times()));
    if (!job.pictures.is_there()) return;
    const Pictures& pictures = job.pictures.get(Data::pictures, "results");
    for (std::size_t stage = 0; stage < pictures.after.size(); ++stage)
      result_.pictures[of_noise * pictures.after.size() + stage] = picture_of(pictures.after[stage]);
    if (job.noise != 0) return;
    for (std::size_t stage = 0; stage < pictures.truths.size(); ++stage)
      result_.truths[job.effect * pictures.after.size() + stage] = picture_of(pictures.truths[stage]);
  }

  const Shared& shared_;
  Result& result_;
  std::mutex mutex_;
};

// Nothing can be said of noises by an error that is no number.
void check_errors(const Result& result) {
  std::vector<Fault> faults;
  for (std::size_t effect = 0; effect < result.effects.size(); ++effect)
    for (std::size_t noise = 0; noise < result.noises.size(); ++noise) {
      const auto curves =
          static_cast<std::ptrdiff_t>(result.squares.size() / result.effects.size() / result.noises.size());
      const auto first =
          result.squares.begin() + static_cast<std::ptrdiff_t>(effect * result.noises.size() + noise) * curves;
      if (std::all_of(first, first + curves, [](double square) { return std::isfinite(square); })) continue;
      faults.push_back({"noise \"" + result.noises[noise] + "\"",
                        fmt::format("its error in {} is no finite number: its samples, or the numbers of the scene, "
                                    "are beyond what is computed with",
                                    name_of(result.effects[effect]))});
    }
  throw_if_any(std::move(faults));
}

// How far filters take the truth from itself, and the pictures of it.
void store_truth(const Shared& shared, Result& result) {
  for (std::size_t effect = 0; effect < result.effects.size(); ++effect) {
    const Truth& truth = shared.truth.get(Data::truth, "results")[effect].front();
    for (std::size_t stage = 0; stage < result.stages.size(); ++stage)
      result.bias.push_back(truth.bias[stage % truth.bias.size()]);
    if (!shared.scene.puts_out("images") || truth_changes_with_frame(shared.scene, result.effects[effect])) continue;
    for (std::size_t stage = 0; stage < result.stages.size(); ++stage)
      result.truths[effect * result.stages.size() + stage] = picture_of(truth.after[stage % truth.after.size()]);
  }
}

// As many jobs at a time as there are threads, each on one; the rest, which would leave threads idle, one after the
// other, the rows of their pictures on all.
void run_jobs(const Shared& shared, Result& result, ThreadPool& pool) {
  const auto count = std::ssize(result.effects) * std::ssize(result.noises) * result.repeats;
  const std::int64_t rest = count % pool.num_threads();
  Jobs jobs(shared, result);
  pool.for_each(count - rest, [&](std::int64_t number, int) { jobs.run(number, {}); });
  for (std::int64_t number = count - rest; number < count; ++number) jobs.run(number, {&pool});
}

}  // namespace

std::vector<std::string> notes_of_reading(const Scene& scene, const std::vector<Noise>& noises) {
  std::vector<std::string> notes;
  for (const Noise& noise : noises)
    for (const std::string& note : noise.notes) notes.push_back(fmt::format("noise \"{}\": {}", noise.spec.name, note));
  for (const Noise& noise : noises)
    for (const Effect effect : effects_of(scene))
      if (const std::string note = note_of_places(scene, noise, effect); !note.empty()) notes.push_back(note);
  if (!scene.occlusion.on) return notes;
  for (const Noise& noise : noises) {
    const Directions kind = noise.directions();
    if (kind == Directions::none || scene.occlusion.uniform != (kind == Directions::cosine)) continue;
    notes.push_back(fmt::format("noise \"{}\": its directions are bent to {}, as all noises of the scene are read",
                                noise.spec.name,
                                scene.occlusion.uniform ? "equal density" : "the density of the cosine"));
  }
  return notes;
}

Result render(const Scene& scene, const std::vector<Noise>& noises, ThreadPool& pool) {
  return render(scene, noises, pool, all_passes());
}

Result render(const Scene& scene, const std::vector<Noise>& noises, ThreadPool& pool, std::span<const Pass> passes) {
  check_noises(scene, noises);
  const Stopwatch watch;
  Result result;
  result.effects = effects_of(scene);
  for (const Noise& noise : noises) {
    if (noise.spec.kind == NoiseKind::white && !result.white) result.white = result.noises.size();
    result.noises.push_back(noise.spec.name);
  }
  result.stages = stages_of(scene);
  result.metrics = metrics_of(scene);
  result.frames = scene.frames;
  result.repeats = scene.repeats;
  result.threads = pool.num_threads();
  Shared shared{.scene = scene, .effects = result.effects, .stages = result.stages, .pool = pool, .opened = noises};
  for (const PlannedPass& planned : plan_passes(passes, scene, noises)) {
    PassResult pass{.planned = planned};
    if (planned.on && planned.pass->prepare != nullptr) {
      const Stopwatch watch_of_pass;
      shared.pass = planned.pass->name;
      shared.counts = &pass.counted;
      planned.pass->prepare(shared);
      pass.calls = 1;
      pass.seconds = watch_of_pass.seconds();
    }
    result.passes.push_back(pass);
  }
  const std::size_t curves = result.effects.size() * noises.size() * static_cast<std::size_t>(scene.repeats);
  result.squares.resize(curves * result.stages.size() * static_cast<std::size_t>(scene.frames));
  result.further.assign(result.metrics.size() - 1, result.squares);
  if (scene.puts_out("images")) {
    result.pictures.resize(result.effects.size() * noises.size() * result.stages.size());
    result.truths.resize(result.effects.size() * result.stages.size());
  }
  if (scene.puts_out("spectra")) result.spectra.resize(result.effects.size() * noises.size() * result.num_times());
  result.notes = notes_of_reading(scene, noises);
  result.notes.insert(result.notes.end(), shared.notes.begin(), shared.notes.end());
  run_jobs(shared, result, pool);
  check_errors(result);
  store_truth(shared, result);
  if (scene.puts_out("predictions")) result.predictions = shared.predictions.get(Data::predictions, "results");
  result.seconds = watch.seconds();
  return result;
}

}  // namespace noiseloom::render
