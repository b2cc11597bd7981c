// What a scene expects of its noises, as it is written, and whether it came out.
#pragma once

#include <string>
#include <vector>

namespace noiseloom::render {

// "a < b = c": each noise with what stands before it.
struct OrderTerm {
  std::string noise;
  char relation = 0;  // '<' or '='; 0 for the first
};
// Empty where the text is no order of at least two names.
std::vector<OrderTerm> parse_order(const std::string& text);

enum class Outcome { holds, undecided, fails };
std::string to_string(Outcome outcome);

// From differences between two errors, one for each repeat: whether their mean is below zero by more than two standard
// errors of the mean (holds), above it by as much (fails), or neither. Undecided where there is one alone.
Outcome outcome_of_less(const std::vector<double>& differences);
// Whether the mean is within three standard errors of zero, or no further than `margin`: repeats are of one texture,
// and do not show how it differs from another of its kind.
Outcome outcome_of_equal(const std::vector<double>& differences, double margin);

struct MeanAndError {
  double mean = 0;
  double error = 0;  // standard error of the mean; infinite for one value alone
};
MeanAndError mean_and_error(const std::vector<double>& values);

}  // namespace noiseloom::render
