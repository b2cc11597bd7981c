#include "noiseloom/render/expectation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <sstream>

namespace noiseloom::render {

std::vector<OrderTerm> parse_order(const std::string& text) {
  std::istringstream words(text);
  std::vector<OrderTerm> terms;
  char relation = 0;
  bool name_follows = true;
  for (std::string word; words >> word;) {
    const bool is_relation = word == "<" || word == "=";
    if (is_relation == name_follows) return {};
    if (is_relation) {
      relation = word.front();
    } else {
      terms.push_back({word, relation});
    }
    name_follows = is_relation;
  }
  if (name_follows || terms.size() < 2) return {};
  return terms;
}

std::string to_string(Outcome outcome) {
  return outcome == Outcome::holds ? "holds" : outcome == Outcome::fails ? "fails" : "undecided";
}

MeanAndError mean_and_error(const std::vector<double>& values) {
  const double count = static_cast<double>(values.size());
  MeanAndError result;
  for (const double value : values) result.mean += value / count;
  double squares = 0;
  for (const double value : values) squares += (value - result.mean) * (value - result.mean);
  result.error = values.size() < 2 ? std::numeric_limits<double>::infinity() : std::sqrt(squares / (count - 1) / count);
  return result;
}

Outcome outcome_of_less(const std::vector<double>& differences) {
  const MeanAndError difference = mean_and_error(differences);
  if (difference.mean < -2 * difference.error) return Outcome::holds;
  if (difference.mean > 2 * difference.error) return Outcome::fails;
  return Outcome::undecided;
}

Outcome outcome_of_equal(const std::vector<double>& differences, double margin) {
  if (differences.size() < 2) return Outcome::undecided;
  const MeanAndError difference = mean_and_error(differences);
  return std::fabs(difference.mean) <= std::max(3 * difference.error, margin) ? Outcome::holds : Outcome::fails;
}

}  // namespace noiseloom::render
