// Samples from a user's .npy file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/files/input_array.h"
#include "noiseloom/samples/spec.h"

namespace noiseloom {

// How many channels the samples of a file of that shape have. Throws UserError, naming the path and the shapes that are
// accepted.
int channels_of_shape(const std::vector<std::int64_t>& shape, std::int64_t cells_per_slice, std::int32_t num_slices,
                      const std::string& path);

class SampleFile {
 public:
  // Checks what was read from the file at `path` as SampleSource promises; UserError naming the path.
  SampleFile(InputArrayPtr array, const std::string& path, DistanceKind distance, std::int64_t cells_per_slice,
             std::int32_t num_slices);

  int channels() const { return static_cast<int>(channels_); }
  // The slice's samples in a locality-preserving order, [id][channel].
  std::vector<float> list(SliceIndex slice) const;

 private:
  std::size_t cells_;
  std::size_t channels_ = 1;
  bool shared_ = true;         // one list for all slices
  InputArrayPtr array_;        // unless shared: [slice][as in the file][channel]
  std::vector<float> values_;  // if shared: in order already
};

}  // namespace noiseloom
