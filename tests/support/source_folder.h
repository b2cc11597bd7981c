// The repository that the tests were built from.
#pragma once

#include <string>

namespace noiseloom::testing_support {

std::string source_folder();

}  // namespace noiseloom::testing_support
