#include "accuracy/accuracy_score.h"

#include <cmath>

#include "noiseloom/image/encoding.h"
#include "noiseloom/measure/score_file.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

Texture through_bits(const Texture& texture, const SampleSpec& samples, const ValueRange& range, int bits) {
  Texture stored = texture;
  for (float& v : stored.values)
    v = static_cast<float>(from_unit(range, dequantise(quantise(to_unit(range, static_cast<double>(v)), bits), bits)));
  if (are_unit_vectors(samples)) normalise_directions(stored, "stored samples");
  return stored;
}

double RunScorer::relative_error(const Texture& texture, const RunConfig& config, int bits) {
  const ProblemSpec& problem = config.problem;
  const DistanceKind kind = distance_kind(problem.samples, texture.channels);
  const std::tuple samples(config.optimizer.method == Method::void_and_cluster, problem.seed, bits);
  if (!mean_distance_.contains(samples)) mean_distance_[samples] = mean_distance_of(texture, kind, pool_);
  return relative_error_of(texture, kind, problem.filter, mean_distance_[samples], pool_);
}

RunScores RunScorer::score(const std::string& run_file) {
  const TextureFile file = load_texture(run_file, std::nullopt);
  const ProblemSpec& problem = file.config->problem;
  RunScores scores;
  scores.relative_error = relative_error(file.texture, *file.config, 0);
  for (const auto& [name, values] : file.history)
    if (name == "iterations" && !values.empty()) scores.iterations = std::llround(values.back());
  if (const auto range = natural_range(problem.samples)) {
    scores.r_8bit = relative_error(through_bits(file.texture, problem.samples, *range, 8), *file.config, 8);
    scores.r_16bit = relative_error(through_bits(file.texture, problem.samples, *range, 16), *file.config, 16);
  }
  return scores;
}

}  // namespace noiseloom
