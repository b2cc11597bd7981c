// How the problem is solved: the [optimizer] table of a config, without what only an order of all pixels needs
// (construct/spec.h).
#pragma once

#include <cstdint>

namespace noiseloom {

// `automatic` is none that runs: it stands for construct or anneal until the samples are known
// (config/config.h, settle_method).
enum class Method { anneal, fast, void_and_cluster, construct, automatic };
enum class Precision { float32, float64 };

// At most one rule is set; the others are zero. With none, construct ends when it has placed all samples.
struct StopSpec {
  std::int64_t iterations = 1000;  // one iteration = one candidate pair for every two samples
  double time_s = 0;               // the schedule is fitted to it
  double score = 0;                // stop at R <= score
  double improvement = 0;          // stop when a hundred iterations more lower R by less than this fraction

  static constexpr StopSpec none() { return {.iterations = 0}; }
  bool is_none() const { return iterations <= 0 && time_s <= 0 && score <= 0 && improvement <= 0; }
};

struct OptimizerSpec {
  Method method = Method::anneal;
  StopSpec stop = {};
  Precision precision = Precision::float32;
  double cutoff = -1;            // of the energy's footprint (never of R's); below 0: energy_cutoff() has it by method
  int background_features = 8;   // anneal, product over slices: features that stand for the other slices; 0: all taps
  int sieve_features = 16;       // anneal: features that a candidate is estimated with before it is judged; 0: none
  double temperature_start = 0;  // anneal: in units of the problem's mean |dE|; 0 = found from the problem
  double temperature_end = 0;
  int strata = 1;             // anneal: ids of a slice fall into so many equal runs, and swaps stay within one
  double fraction = 0.125;    // fast: first value of gamma
  bool grow_fraction = true;  // fast: double gamma when few swaps are accepted (the paper's rule)
};

}  // namespace noiseloom
