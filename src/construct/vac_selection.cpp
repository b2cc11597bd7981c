#include "construct/vac_selection.h"

#include <algorithm>

#include "noiseloom/core/partition.h"

namespace noiseloom {
namespace {

// Few fall of so many, and telling each other costs little beside finding them.
constexpr std::size_t most_picks_ahead = 512;
constexpr std::size_t fewest_picks_ahead = 8;

}  // namespace

VacSelection::VacSelection(const VacSpec& spec, const VacKernel& kernel, VacFields& fields, VacExchange& exchange)
    : fields_(fields),
      exchange_(exchange),
      first_of_part_(fields.num_parts()),
      picked_(fields.num_parts()),
      fallen_(fields.num_parts()),
      picks_ahead_(most_picks_ahead) {
  const auto add = [&](std::vector<VacSelector>& to, const VacLayout& first, const VacLayout& last) {
    to.emplace_back(spec, kernel, narrow<std::int32_t>(first.slice_begin), narrow<std::int32_t>(last.slice_end));
  };
  add(of_all_, fields.part(0).layout(), fields.part(fields.num_parts() - 1).layout());
  if (fields.num_parts() == 1) return;
  for (std::size_t i = 0; i < fields.num_parts(); ++i) add(of_parts_, fields.part(i).layout(), fields.part(i).layout());
}

void VacSelection::begin(VacView view, const VacSearch& search, std::uint64_t limit) {
  if (fields_.by_threads() && fields_.num_parts() > 1) {
    selectors_ = of_parts_;
    for_each([&](VacSelector& selector, std::size_t part) { selector.begin(view, search.found(part), limit); });
    return;
  }
  selectors_ = of_all_;
  std::span<const VacCandidate> found = search.found(0);
  if (fields_.num_parts() > 1) {
    all_found_.clear();
    for (std::size_t part = 0; part < fields_.num_parts(); ++part) {
      first_of_part_[part] = all_found_.size();
      const auto of_part = search.found(part);
      all_found_.insert(all_found_.end(), of_part.begin(), of_part.end());
    }
    found = all_found_;
  }
  of_all_[0].begin(view, found, limit);
}

void VacSelection::for_each(const std::function<void(VacSelector&, std::size_t)>& body) {
  if (selectors_.size() == 1) return body(selectors_[0], 0);
  fields_.for_each([&](VacField&, std::size_t part) { body(selectors_[part], part); });
}

// The first `most` open picks of every part, as far as no part may have another before the last of them.
void VacSelection::offers_of_rank(std::size_t most) {
  VacOffer horizon;
  for (const VacSelector& selector : selectors_) {
    if (selector.num_open() >= most) horizon = std::min(horizon, selector.open(most - 1));
  }
  is_complete_ = horizon == VacOffer{};
  offers_.clear();
  for (const VacSelector& selector : selectors_) {
    const auto middle = static_cast<std::ptrdiff_t>(offers_.size());
    for (std::size_t k = 0; k < std::min(most, selector.num_open()); ++k) {
      if (selector.open(k) > horizon) break;
      offers_.push_back(selector.open(k));
    }
    std::inplace_merge(offers_.begin(), offers_.begin() + middle, offers_.end());
  }
  if (offers_.size() > most) {
    offers_.resize(most);
    is_complete_ = false;
  }
}

// The same of all ranks. A rank tells how many it has, whether these are all, and the picks.
void VacSelection::offers_of_all(std::size_t most) {
  if (exchange_.alone()) return;
  std::vector<std::uint64_t> words(2 + 2 * most);
  words[0] = offers_.size();
  words[1] = is_complete_ ? 1 : 0;
  for (std::size_t k = 0; k < offers_.size(); ++k) {
    words[2 + 2 * k] = offers_[k].key;
    words[3 + 2 * k] = offers_[k].order;
  }
  const std::vector<std::uint64_t> all = exchange_.gather(words);
  offers_.clear();
  VacOffer horizon;
  for (std::size_t rank = 0; rank < all.size(); rank += words.size()) {
    const auto middle = static_cast<std::ptrdiff_t>(offers_.size());
    for (std::size_t k = 0; k < all[rank]; ++k) {
      offers_.push_back({all[rank + 2 + 2 * k], all[rank + 3 + 2 * k]});
    }
    if (all[rank + 1] == 0) horizon = std::min(horizon, offers_.back());
    std::inplace_merge(offers_.begin(), offers_.begin() + middle, offers_.end());
  }
  is_complete_ = horizon == VacOffer{};
  offers_.erase(std::upper_bound(offers_.begin(), offers_.end(), horizon), offers_.end());
}

void VacSelection::select(VacView view, const VacSearch& search, std::uint64_t limit, std::size_t max_picks,
                          std::vector<std::uint64_t>& picks) {
  picks.clear();
  begin(view, search, limit);
  const bool alone = exchange_.alone() && selectors_.size() == 1;
  const auto ranks = static_cast<std::uint64_t>(exchange_.num_ranks());
  const auto share = static_cast<std::size_t>((search.num_found() + ranks - 1) / ranks);
  while (picks.size() < max_picks) {
    const std::size_t left = max_picks - picks.size();
    const std::size_t most = alone ? left : std::min({left, picks_ahead_, std::max(share, fewest_picks_ahead)});
    for_each([&](VacSelector& selector, std::size_t) { selector.pick(most); });
    offers_of_rank(most);
    offers_of_all(most);
    if (offers_.size() > left) offers_.resize(left);
    if (offers_.empty()) break;
    std::size_t num_settled = offers_.size();
    if (alone) {
      selectors_[0].settle_all();
    } else {
      num_settled = settle();
    }
    for (const VacOffer& pick : std::span(offers_).first(num_settled)) picks.push_back(position_of(view, pick));
    if (is_complete_ && num_settled == offers_.size()) break;
  }
  if (std::any_of(selectors_.begin(), selectors_.end(), [](const auto& selector) { return selector.num_open() > 0; })) {
    for_each([](VacSelector& selector, std::size_t) { selector.take_back_open(); });
  }
}

// How many of the offers stand. As many picks ahead as mostly stand.
std::size_t VacSelection::settle() {
  fallen_.assign(selectors_.size(), {});
  for_each([&](VacSelector& selector, std::size_t i) { fallen_[i] = selector.hear(offers_); });
  const VacOffer first = exchange_.least(*std::min_element(fallen_.begin(), fallen_.end()));
  const auto end = std::lower_bound(offers_.begin(), offers_.end(), first);
  const auto num_settled = static_cast<std::size_t>(end - offers_.begin());
  for (std::size_t i = 0; i < selectors_.size(); ++i) selectors_[i].settle(offers_, num_settled, fallen_[i]);
  if (num_settled < offers_.size() / 2) {
    picks_ahead_ = std::max(fewest_picks_ahead, picks_ahead_ / 2);
  } else if (num_settled == offers_.size()) {
    picks_ahead_ = std::min(most_picks_ahead, picks_ahead_ + picks_ahead_ / 2);
  }
  return num_settled;
}

void VacSelection::end(VacField& field, std::size_t part, std::span<const VacCandidate> found) {
  const bool has_own = selectors_.size() > 1;
  const VacSelector& selector = selectors_[has_own ? part : 0];
  const std::size_t first = has_own ? 0 : first_of_part_[part];
  picked_[part].clear();
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (selector.picked(first + i)) {
      picked_[part].push_back(found[i].position);
    } else {
      field.lower_bound_to(found[i].position, selector.energy(first + i));
    }
  }
}

}  // namespace noiseloom
