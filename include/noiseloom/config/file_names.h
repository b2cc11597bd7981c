// Names of files inside a file of settings.
#pragma once

#include <map>
#include <string>

namespace noiseloom {

// What a file that is named and not there means: a fault, or nothing yet (a config that was stored in a run file
// describes samples that are in that file already).
enum class MissingFiles { refused, accepted };

// A file name that can be opened -> as the file of settings spells it. Names are relative to its folder; the stored
// text keeps the user's spelling, so that it can be read again from elsewhere.
using WrittenPaths = std::map<std::string, std::string>;

}  // namespace noiseloom
