#include "construct/order/vac_candidates.h"

#include <algorithm>
#include <utility>

namespace noiseloom {
namespace {

constexpr std::uint64_t none = ~std::uint64_t{0};

// Bounds of leaves of own slices that have a pixel left: every `stride`-th leaf, or all where that meets none.
void sample_bounds(VacSlices& slices, std::size_t stride, std::vector<std::uint32_t>& sample) {
  for (; sample.empty(); stride = 1) {
    for (std::size_t part = 0; part < slices.num_parts(); ++part) {
      const auto bounds = slices.part(part).bounds();
      for (std::size_t i = 0; i < bounds.size(); i += stride) {
        if (bounds[i] < vac_flag) sample.push_back(bounds[i]);
      }
    }
    if (stride == 1) return;
  }
}

}  // namespace

VacSearch::VacSearch(VacSlices& slices, VacExchange& exchange, const VacTieHash& hash)
    : slices_(slices), exchange_(exchange), hash_(hash) {
  std::size_t most_leaves = 0;
  for (std::size_t i = 0; i < slices_.num_parts(); ++i)
    most_leaves = std::max(most_leaves, slices_.part(i).bounds().size());
  max_found_ = std::max<std::size_t>(4096, most_leaves);
  max_found_if_lowered_ = std::max<std::size_t>(256, most_leaves / 4);
}

// What this rank finds right for its own slices; none when no leaf of them has a pixel left.
std::uint64_t VacSearch::own_proposal(double fraction) {
  constexpr std::size_t num_samples = 256;
  const std::size_t own_leaves = slices_.num_leaves();
  std::vector<std::uint32_t> sample;
  sample_bounds(slices_, std::max<std::size_t>(1, own_leaves / num_samples), sample);
  std::uint64_t own = none;
  if (!sample.empty()) {
    const auto rank = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(sample.size() - 1));
    std::nth_element(sample.begin(), sample.begin() + rank, sample.end());
    own = (std::uint64_t{sample[static_cast<std::size_t>(rank)]} << 32) | 0xFFFFFFFFU;
  }
  return own;
}

// The median of what the ranks find right: slices are alike, and any limit gives the same picks. 0 when no leaf of any
// rank has a pixel left.
std::uint64_t VacSearch::agreed(std::vector<std::uint64_t> all) {
  std::erase(all, none);
  if (all.empty()) return 0;
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

std::uint64_t VacSearch::propose(double fraction) {
  const std::uint64_t own = own_proposal(fraction);
  return agreed(exchange_.gather(std::span(&own, 1)));
}

void VacSearch::refresh_bounds(VacView view) {
  slices_.refresh_bounds(view);
  next_limit_ = 0;
  scanned_ = false;
}

// After a scan that found too many: a limit that the parts of this rank would have kept to.
std::uint64_t VacSearch::lower_limit() {
  std::uint64_t limit = none;
  for (std::size_t i = 0; i < slices_.num_parts(); ++i) {
    if (slices_.part(i).found_all()) continue;
    std::vector<VacCandidate> found = slices_.part(i).found();
    const auto quarter = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 4);
    std::nth_element(found.begin(), quarter, found.end(),
                     [](const VacCandidate& a, const VacCandidate& b) { return a.key() < b.key(); });
    limit = std::min(limit, quarter->key());
  }
  return limit;
}

std::optional<VacScan> VacSearch::scan_ahead(VacView view, double fraction) {
  if (next_limit_ == 0 && exchange_.alone()) next_limit_ = agreed({own_proposal(fraction)});
  if (next_limit_ == 0) return std::nullopt;
  scanned_ = true;
  return VacScan{view, hash_, next_limit_, max_found_};
}

std::uint64_t VacSearch::find(VacView view, double fraction, std::vector<VacCandidate>& found) {
  std::uint64_t limit = next_limit_ != 0 ? std::exchange(next_limit_, 0) : propose(fraction);
  std::size_t max_found = max_found_;
  std::vector<std::byte> bytes;
  std::vector<int> bytes_of_ranks;
  while (limit != 0) {
    if (!std::exchange(scanned_, false)) {
      slices_.for_each(
          [asked = VacScan{view, hash_, limit, max_found}](VacField& part, std::size_t) { part.scan(asked); });
    }
    std::uint64_t total = 0;
    bool fits = true;
    for (std::size_t i = 0; i < slices_.num_parts(); ++i) {
      total += slices_.part(i).found().size();
      fits = fits && slices_.part(i).found_all();
    }
    if (!exchange_.alone()) {
      bytes.clear();
      const VacPacker packer(limit);
      for (std::size_t i = 0; fits && i < slices_.num_parts(); ++i) packer.pack(slices_.part(i).found(), bytes);
      // Collectives cost more than what they carry, so this one has the next limit too.
      const std::uint64_t own[] = {total, fits ? 0U : 1U, bytes.size(), own_proposal(fraction)};
      const auto all = exchange_.gather(own);
      total = 0;
      fits = true;
      bytes_of_ranks.clear();
      std::vector<std::uint64_t> proposals;
      for (std::size_t i = 0; i < all.size(); i += std::size(own)) {
        total += all[i];
        fits = fits && all[i + 1] == 0;
        bytes_of_ranks.push_back(narrow<int>(all[i + 2]));
        proposals.push_back(all[i + 3]);
      }
      next_limit_ = agreed(std::move(proposals));
    }
    if (!fits) {
      const std::uint64_t lower = lower_limit();
      const auto limits = exchange_.gather(std::span(&lower, 1));
      limit = *std::min_element(limits.begin(), limits.end());
      max_found = max_found_if_lowered_;
    } else if (total > 0) {
      break;
    } else {
      limit = propose(fraction);  // every leaf that was opened now has a higher bound
    }
  }
  if (limit == 0) {
    found.clear();
    return 0;
  }
  if (exchange_.alone()) {
    std::vector<std::size_t> begins{0};
    for (std::size_t i = 0; i < slices_.num_parts(); ++i) {
      begins.push_back(begins.back() + slices_.part(i).found().size());
    }
    found.resize(begins.back());
    slices_.for_each([&](const VacField& part, std::size_t i) {
      std::ranges::copy(part.found(), found.begin() + static_cast<std::ptrdiff_t>(begins[i]));
    });
    return limit;
  }
  found.clear();
  VacPacker(limit).unpack(exchange_.gather(bytes, bytes_of_ranks), view, hash_, found);
  return limit;
}

}  // namespace noiseloom
