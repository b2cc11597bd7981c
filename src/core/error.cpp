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

// Edits (a character inserted, dropped, changed, or two neighbours exchanged) that lead from a to b.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1), d[i - 1][j] + 1, d[i][j - 1] + 1});
      const bool exchanged = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (exchanged) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
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
    const bool abbreviates = word.size() >= 2 && candidate.starts_with(word);
    // Each edit changes the length by at most one, so that words of megabytes need no table.
    const std::size_t least = std::max(word.size(), candidate.size()) - std::min(word.size(), candidate.size());
    if (least >= best_distance && !abbreviates) continue;
    const std::size_t distance = edit_distance(word, candidate);
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
