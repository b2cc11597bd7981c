#include "optimize/vac_candidates.h"

#include <algorithm>

namespace noiseloom {

std::uint64_t vac_propose_limit(std::span<const std::uint32_t> bounds, double fraction) {
  constexpr std::size_t num_samples = 1024;
  std::vector<std::uint32_t> sample;
  for (std::size_t stride = std::max<std::size_t>(1, bounds.size() / num_samples); sample.empty(); stride = 1) {
    for (std::size_t i = 0; i < bounds.size(); i += stride) {
      if (bounds[i] < vac_flag) sample.push_back(bounds[i]);
    }
    if (stride == 1) break;
  }
  if (sample.empty()) return 0;
  const auto rank = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(sample.size() - 1));
  std::nth_element(sample.begin(), sample.begin() + rank, sample.end());
  return (std::uint64_t{sample[static_cast<std::size_t>(rank)]} << 32) | 0xFFFFFFFFU;
}

std::uint64_t vac_find_candidates(VacField& field, VacView view, const VacTieHash& hash, double fraction,
                                  std::size_t max_found, std::vector<VacCandidate>& found) {
  found.clear();
  std::uint64_t limit = vac_propose_limit(field.bounds(), fraction);
  while (limit != 0) {
    if (field.scan(view, hash, limit, max_found, found)) {
      if (!found.empty()) return limit;
      limit = vac_propose_limit(field.bounds(), fraction);  // every leaf that was opened now has a higher bound
      continue;
    }
    for (const VacCandidate& c : found) field.lower_bound_to(c.position, c.energy);
    const auto middle = found.begin() + static_cast<std::ptrdiff_t>(max_found / 4);
    std::nth_element(found.begin(), middle, found.end(),
                     [](const VacCandidate& a, const VacCandidate& b) { return a.key() < b.key(); });
    limit = middle->key();
  }
  return limit;
}

}  // namespace noiseloom
