// /order of a run file: the place of every pixel of a mask in the sequence in which pixels are turned on.
#pragma once

#include <string>

#include "noiseloom/files/run_file.h"

namespace noiseloom {

inline constexpr const char* order_name = "/order";

// True for a run file of a method that orders pixels (void and cluster).
bool is_order_run(const RunFileContent& content);

// Throws UserError for a run file of such a method that is not finished: it is no texture yet.
void require_finished_order(const RunFileContent& content, const std::string& path);

}  // namespace noiseloom
