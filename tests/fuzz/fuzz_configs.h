// The configs that the fuzz targets of the readers try: few channels and many, signed or not, flat or deep.
#pragma once

#include <optional>
#include <string>

#include "noiseloom/config/config.h"

namespace noiseloom::fuzz {

inline std::optional<RunConfig> config_number(unsigned number) {
  const char* const configs[] = {
      "size = { x = 4, y = 3 }\nsamples = \"uniform\"", "size = { x = 4, y = 3, t = 2 }\nsamples = \"vector2\"",
      "size = { x = 4, y = 4, t = 4 }\nsamples = \"sphere\"", "size = { x = 4, y = 3, t = 2 }\nsamples = \"circle\""};
  if (number % 5 == 4) return std::nullopt;
  return parse_config(std::string("[texture]\n") + configs[number % 5] +
                          "\n[filter]\ngroups = [ { axes = \"xy\", kernel = \"box\", size = 3 } ]\n",
                      "fuzz", "", {});
}

}  // namespace noiseloom::fuzz
