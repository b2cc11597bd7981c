// Commands of noiseloom-study that stand in files of their own. Each adds itself to the command line; `status` becomes
// the exit status when the command has run.
#pragma once

#include <CLI/CLI.hpp>

namespace noiseloom {

void add_accuracy(CLI::App& app, int& status);

}  // namespace noiseloom
