#include "run/start_lattice.h"

#include <fmt/format.h>

#include "noiseloom/core/error.h"
#include "noiseloom/problem/footprint.h"

namespace noiseloom {

Lattice start_lattice(const RunConfig& config, int channels) {
  const ProblemSpec& problem = config.problem;
  if (scale_of(problem.samples, channels) != SampleScale::line) {
    throw UserError(problem.samples.file,
                    fmt::format("its samples have {} channels; start = {{ pattern = \"lattice\" }} "
                                "takes scalars that are compared by their difference",
                                channels));
  }
  return find_lattice(Footprint(problem.extents, problem.filter));
}

}  // namespace noiseloom
