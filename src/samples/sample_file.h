// Samples from a user's .npy file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/samples/spec.h"

namespace noiseloom {

class SampleFile {
 public:
  // Reads and checks the file as SampleSource promises; UserError.
  SampleFile(const std::string& path, DistanceKind distance, std::int64_t cells_per_slice, SliceIndex num_slices);

  int channels() const { return static_cast<int>(channels_); }
  // The slice's samples in a locality-preserving order, [id][channel].
  std::vector<float> list(SliceIndex slice) const;

 private:
  std::size_t cells_;
  std::size_t channels_ = 1;
  bool shared_ = true;  // one list for all slices, in order already; else [slice][as in the file][channel]
  std::vector<float> values_;
};

}  // namespace noiseloom
