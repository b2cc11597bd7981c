// R of a finished run, as it is and as 8 and 16 bit images would hold it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "noiseloom/core/parallel.h"
#include "noiseloom/image/encoding.h"
#include "noiseloom/image/texture_file.h"

namespace noiseloom {

struct RunScores {
  std::int64_t iterations = 0;  // of the last row of its history
  double relative_error = 0;
  std::optional<double> r_8bit;  // none for samples without natural bounds
  std::optional<double> r_16bit;
};

// Scores runs of one problem, one after another. Those of one seed have the same samples, but for void and cluster's,
// so that their mean distance is found once for each encoding; where it is an estimate, they are so compared by the
// same one.
class RunScorer {
 public:
  explicit RunScorer(int num_threads) : pool_(num_threads) {}
  // Throws UserError, naming what is damaged.
  RunScores score(const std::string& run_file);

 private:
  double relative_error(const Texture& texture, const RunConfig& config, int bits);

  ThreadPool pool_;
  std::map<std::tuple<bool, std::uint64_t, int>, double> mean_distance_;  // void and cluster?, seed, bits (0: floats)
};

// The texture as images of `bits` bits give it back: stored and decoded (encoding.h), directions made unit length
// again.
Texture through_bits(const Texture& texture, const SampleSpec& samples, const ValueRange& range, int bits);

}  // namespace noiseloom
