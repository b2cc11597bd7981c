#include "run/jobs/start_lattice.h"

#include <fmt/format.h>

#include "noiseloom/core/error.h"
#include "noiseloom/problem/footprint.h"

namespace noiseloom {

std::optional<Lattice> start_lattice(const RunConfig& config, int channels, const std::function<bool()>& goes_on) {
  const ProblemSpec& problem = config.problem;
  if (scale_of(problem.samples, channels) != SampleScale::line) {
    throw UserError(problem.samples.file,
                    fmt::format("its samples have {} channels; start = {{ pattern = \"lattice\" }} "
                                "takes scalars that are compared by their difference",
                                channels));
  }
  const Footprint overlap(problem.extents, problem.filter);
  if (overlap.slices()[0].taps.empty()) {
    throw UserError("optimizer.start.pattern",
                    "a lattice follows from how pixels of a slice act on each other, and by this filter none do");
  }
  return find_lattice(overlap, goes_on);
}

}  // namespace noiseloom
