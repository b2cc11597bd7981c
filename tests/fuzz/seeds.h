// Small sound inputs that a fuzz target begins with. Each target defines them; seeds.cpp writes them.
#pragma once

#include <string>
#include <vector>

namespace noiseloom::fuzz {

std::vector<std::string> seeds();

}  // namespace noiseloom::fuzz
