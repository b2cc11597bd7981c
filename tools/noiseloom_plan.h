// What plan prints.
#pragma once

#include <string>

#include "noiseloom/run/plan.h"

namespace noiseloom {

std::string plan_text(const RunPlan& plan);
// One object; numbers in bytes and seconds.
std::string plan_json(const RunPlan& plan);

}  // namespace noiseloom
