// The programs of published.cpp's table, a file each.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/published/line.h"

namespace noiseloom {

PublishedLine read_fastnoise(const std::vector<std::string>& words);
PublishedLine read_stbn_scalar(const std::vector<std::string>& words);
PublishedLine read_stbn_vector(const std::vector<std::string>& words);
std::string fastnoise_help();
std::string stbn_scalar_help();
std::string stbn_vector_help();

}  // namespace noiseloom
