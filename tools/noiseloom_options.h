// Command lines of both programs: read by CLI11, with words that help where they are wrong.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>

namespace noiseloom {

// Reads `argv` (without the program's name: argv[0] is the command) into the variables that `app` was given. Returns 0
// where the command line itself ends the command (--help, printed if `prints`). Throws UserError for a wrong one: every
// word that was not expected, with the option that may have been meant.
std::optional<int> read_options(CLI::App& app, int argc, char** argv, bool prints = true);

}  // namespace noiseloom
