// The arrangement of samples that a file holds (optimizer.start): a run file, or a .npy of the texture's shape.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

class StartFile {
 public:
  // Rank 0 reads the file, every rank gets the slices that it wants. Throws UserError on every rank, naming the path:
  // for a file of another kind or shape, a run file whose samples are not all placed, and, with the first slices, where
  // the samples of a slice are not those of the source. *Collective*
  StartFile(const std::string& path, const Extents& extents, const SampleSource& source, std::vector<SliceIndex> wanted,
            const Communicator& communicator);

  // Of a wanted slice, once: the id of the sample of every cell. Calls for different slices may run at the same time.
  Permutation take_permutation(SliceIndex slice) { return std::move(permutations_.at(slice)); }

 private:
  std::map<SliceIndex, Permutation> permutations_;
};

// The id of each sample of an arrangement, [cell][channel], in a list of the same samples, [id][channel]; equal samples
// have their ids in the order of the cells. Empty where the two do not hold the same samples, bit for bit.
Permutation ids_of_arrangement(const std::vector<float>& arrangement, const std::vector<float>& list, int channels);

}  // namespace noiseloom
