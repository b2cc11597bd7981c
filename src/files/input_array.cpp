#include "noiseloom/files/input_array.h"

#include <fmt/format.h>

#include <cmath>

#include "noiseloom/core/error.h"
#include "noiseloom/files/npy.h"

namespace noiseloom {

InputArrayPtr read_float_array(const std::string& path) {
  NpyArray array = read_npy(path);
  std::vector<float> values(array.values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<float>(array.values[i]);
    const bool vanishes = values[i] == 0 && array.values[i] != 0;
    if (!vanishes && (std::isfinite(values[i]) || !std::isfinite(array.values[i]))) continue;
    throw UserError(path, fmt::format("value {} = {}: too {} for float32; scale the values", i, array.values[i],
                                      vanishes ? "small" : "large"));
  }
  return std::make_shared<const InputArray>(InputArray{std::move(array.shape), std::move(values)});
}

InputArrayPtr read_double_array(const std::string& path) {
  NpyArray array = read_npy(path);
  return std::make_shared<const InputArray>(InputArray{std::move(array.shape), std::move(array.values)});
}

}  // namespace noiseloom
