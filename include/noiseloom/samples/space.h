// A sample space: the set that a sample lives in, with its distribution and its distance, as one object.
//
// The built-in spaces are the rows of one table (src/samples/spaces.cpp), and each stands in a file of its own
// (src/samples/space_*.cpp). To add a space, write its file and its row: configs, help, names of published files,
// exports and the score find it there. A space may have parameters, such as the angle of a cone: what they are called
// and what they may be stands in its traits, and a config gives them beside its name.
//
// Samples are stratified: the measure is cut into n equal parts, and each part gives one sample. Strata are numbered
// along an order in which near numbers lie near each other in the space (for scalars: ascending values), as the
// optimiser proposes partners by the distance of their numbers. A sample is float32; n may be any number >= 1. For n up
// to 2^24 (tent: 2^23) a sample lies in its own stratum as rounded to float; beyond, where a stratum may hold no float,
// beside it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/samples/spec.h"

namespace noiseloom {

// An interval of values. lo < hi.
struct ValueRange {
  double lo = 0;
  double hi = 1;
  friend bool operator==(const ValueRange&, const ValueRange&) = default;
};

// The set that the samples of a space fill.
enum class Support {
  line,
  half_line,
  unit_interval,
  signed_unit_interval,
  unit_disk,
  unit_vectors,
  upper_unit_vectors
};  // lines and intervals: of every channel; half_line: values >= 0; unit_disk: or a part of it

// A number that the space depends on. A config gives it by its name: { space = "cone", angle = 30 }.
struct SpaceParameter {
  std::string name;
  std::string meaning;  // for the help: a sentence
  double initial = 0;   // where a config does not say
  double least = 0;
  double most = 1;
  bool whole = false;     // an integer
  std::string unit = {};  // for the help
};

struct SpaceTraits {
  std::string name;     // as a config spells it
  std::string meaning;  // for the help: what a sample is
  std::string aliases;  // what people call it elsewhere, separated by spaces: leads to a suggestion, is not accepted
  int channels = 1;     // numbers in a sample
  int dimensions = 1;   // independent random numbers that a sample takes
  DistanceKind distance = DistanceKind::absolute;
  std::optional<ValueRange> range;  // what every channel lies in; none: unbounded
  Support support = Support::unit_interval;
  bool has_constant_density = true;
  bool is_net = false;  // sizes of textures must be powers of two, and hold 2^23 pixels at most
  std::vector<SpaceParameter> parameters = {};
  // In the names of published files: "vec2" in NVIDIA's, "vector2_uniform" in those of FAST's authors.
  std::string nvidia_name;
  std::string ea_name;
};

class SampleSpace {
 public:
  // Writes traits().dimensions numbers in (0, 1) for the sample of a stratum.
  using JitterOf = std::function<void(std::int64_t id, double* jitter)>;

  explicit SampleSpace(SpaceTraits traits) : traits_(std::move(traits)) {}
  virtual ~SampleSpace() = default;
  SampleSpace(const SampleSpace&) = delete;
  SampleSpace& operator=(const SampleSpace&) = delete;

  const SpaceTraits& traits() const { return traits_; }

  // Writes the sample of stratum `id` of `n` at `jitter`: traits().dimensions numbers in (0, 1). Requires 0 <= id < n.
  virtual void sample(std::int64_t n, std::int64_t id, const double* jitter, float* sample) const = 0;
  // The same for all n strata, interleaved [id][channel], bit for bit.
  virtual void list(std::int64_t n, const JitterOf& jitter, float* samples) const = 0;
  // What slice `slice` of a texture holds, n strata in the same order: list(), or where the slices are parts of one set
  // of points (nets), that part, which depends on the texture's seed alone.
  virtual void list_of_slice(std::int64_t n, SliceIndex /*slice*/, std::uint64_t /*seed*/, const JitterOf& jitter,
                             float* samples) const {
    list(n, jitter, samples);
  }
  // The stratum, of n, that holds a sample.
  virtual std::int64_t invert(std::int64_t n, const float* sample) const = 0;
  // Density of a sample with respect to length, area or solid angle (circle: turns). Positive for every sample that
  // sample() gives.
  virtual double density(const float* sample) const = 0;
  // The share of all samples whose `channel` is below `value`: the distribution function of one coordinate.
  virtual double share_below(int channel, double value) const = 0;

 private:
  SpaceTraits traits_;
};

// All built-in spaces, in the order of the help, with their initial parameters.
std::span<const SampleSpace* const> sample_spaces();
// The built-in space of that name; null where there is none.
const SampleSpace* find_sample_space(std::string_view name);
// The space of a spec, which stays until the program ends. Requires that it names one, and no file, and that it has no
// parameters or as many as the space.
const SampleSpace& sample_space(const SampleSpec& spec);
// The same, or that of an image: then it is made, from spec.array or else from the file, unless one of the same array
// is in use. Throws UserError where the image is no density.
std::shared_ptr<const SampleSpace> space_of(const SampleSpec& spec);
// What is known of either without the image.
SpaceTraits space_traits(const SampleSpec& spec);
// What the parameters of a space are where a config does not say.
std::vector<double> initial_parameters(const SpaceTraits& traits);

}  // namespace noiseloom
