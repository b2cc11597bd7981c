#include "noiseloom/core/error.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace noiseloom {
namespace {

std::string joined(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) {
    if (!text.empty()) text += '\n';
    text += fault.where.empty() ? fault.text : fault.where + ": " + fault.text;
  }
  return text;
}

// Levenshtein distance.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

}  // namespace

UserError::UserError(std::vector<Fault> faults) : std::runtime_error(joined(faults)), faults_(std::move(faults)) {}

void throw_if_any(std::vector<Fault> faults) {
  if (!faults.empty()) throw UserError(std::move(faults));
}

std::string nearest_word(const std::string& word, const std::vector<std::string>& accepted) {
  std::string best;
  std::size_t best_distance = word.size() <= 3 ? 2 : std::max<std::size_t>(word.size() / 3, 2) + 1;
  for (const std::string& candidate : accepted) {
    const std::size_t distance = edit_distance(word, candidate);
    const bool abbreviates = word.size() >= 2 && candidate.starts_with(word);
    if (distance < best_distance || (abbreviates && best.empty())) {
      best = candidate;
      best_distance = std::min(best_distance, distance);
    }
  }
  return best;
}

void detail::check_failed(const char* file, int line, const char* expression, const std::string& values) {
  std::fprintf(stderr, "%s:%d: internal error: %s%s%s\n", file, line, expression, values.empty() ? "" : " with ",
               values.c_str());
  std::abort();
}

}  // namespace noiseloom
