// NumPy's .npz: a zip archive of .npy files, stored as they are [PKWARE's APPNOTE 6.3.3; NumPy's format].
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace noiseloom {

struct NpzArray {
  std::string name;                 // as numpy.load shows it
  std::vector<std::int64_t> shape;  // the last dimension varies fastest
  std::vector<float> values;        // as many as the shape says
};

// Writes the file `path` anew. Throws EnvironmentError; UserError where an array takes 4 GiB or more, which needs
// another kind of archive.
void write_npz(const std::string& path, const std::vector<NpzArray>& arrays);

}  // namespace noiseloom
