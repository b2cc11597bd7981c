#include "study/accuracy_score.h"

#include <cmath>

#include "noiseloom/problem/sample_space.h"
#include "noiseloom/study/encoding.h"
#include "noiseloom/study/score_file.h"

namespace noiseloom {

Texture through_bits(const Texture& texture, const SampleSpec& samples, const ValueRange& range, int bits) {
  Texture stored = texture;
  for (float& v : stored.values)
    v = static_cast<float>(from_unit(range, dequantise(quantise(to_unit(range, static_cast<double>(v)), bits), bits)));
  if (distance_kind(samples, texture.channels) == DistanceKind::angle) normalise_directions(stored, "stored samples");
  return stored;
}

RunScores score_run(const std::string& run_file, ThreadPool& pool) {
  const TextureFile file = load_texture(run_file, std::nullopt);
  const ProblemSpec& problem = file.config->problem;
  const DistanceKind kind = distance_kind(problem.samples, file.texture.channels);
  const auto score = [&](const Texture& texture) {
    return score_texture(texture, kind, problem.filter, {}, pool).relative_error;
  };
  RunScores scores;
  scores.relative_error = score(file.texture);
  for (const auto& [name, values] : file.history)
    if (name == "iterations" && !values.empty()) scores.iterations = std::llround(values.back());
  if (const auto range = natural_range(problem.samples)) {
    scores.r_8bit = score(through_bits(file.texture, problem.samples, *range, 8));
    scores.r_16bit = score(through_bits(file.texture, problem.samples, *range, 16));
  }
  return scores;
}

}  // namespace noiseloom
