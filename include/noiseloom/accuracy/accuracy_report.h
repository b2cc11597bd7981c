// The page that `accuracy` writes: R against seconds, what each setting buys, and the command of every point.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/accuracy/accuracy_table.h"
#include "noiseloom/report/report.h"

namespace noiseloom {

struct AccuracyStudy {
  std::string name;  // the config's path
  RunConfig config;
  std::vector<AccuracyRow> rows;
  std::vector<LeftOut> left_out;
  double budget_s = 0;
  double spent_s = 0;
  std::string state;  // "complete", or why it is not, as a sentence without full stop
  ReportOrigin origin = {};
};

// Self-contained HTML.
std::string accuracy_html(const AccuracyStudy& study);

}  // namespace noiseloom
