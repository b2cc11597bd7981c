// The numbers of a user's file (a list of samples, the taps of a filter) as they were read, once and by one process:
// they are handed to the other ranks and kept in the run file, and whoever has them never opens the user's file again.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "noiseloom/core/shared_values.h"

namespace noiseloom {

struct InputArray {
  std::vector<std::int64_t> shape;  // as the file says; the last dimension varies fastest
  // Samples are float, as the texture holds them; taps are double.
  std::variant<SharedValues<float>, SharedValues<double>> values;

  friend bool operator==(const InputArray&, const InputArray&) = default;
};

// Shared by all copies of a config.
using InputArrayPtr = std::shared_ptr<const InputArray>;

// A .npy file as float, each value rounded, or as double. UserError as read_npy, and where rounding would make a value
// infinite or zero that is not.
InputArrayPtr read_float_array(const std::string& path);
InputArrayPtr read_double_array(const std::string& path);

}  // namespace noiseloom
