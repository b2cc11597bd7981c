#include "support/source_folder.h"

namespace noiseloom::testing_support {

std::string source_folder() { return NOISELOOM_SOURCE_DIR; }

}  // namespace noiseloom::testing_support
