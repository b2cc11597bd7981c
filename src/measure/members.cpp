#include "noiseloom/measure/members.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>

#include "measure/members_parts.h"
#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

using members::kind_of;
using members::MemberSpectrum;
using members::num_bands;
using members::OfOneSize;
using members::size_of;
using members::Transforms;

constexpr double rare = 1e-6;  // odds below which something is a fault
// Products of frequencies over all pairs: some ten seconds of one processor.
constexpr double most_work = 2e9;

// Of a normal number that lies so many standard deviations from 0 or further, somewhere among `count`.
double odds_among(double deviations, double count) {
  return std::min(1.0, count * std::erfc(deviations / std::sqrt(2.0)));
}

struct PairCorrelations {
  double unshifted = 0;
  double shifted = 0;
  std::size_t shift = 0;
  double sigma = 1;  // of r at any shift
  double bands[num_bands] = {};
  double band_sigmas[num_bands] = {};
};

class PairWork {
 public:
  explicit PairWork(const Transforms& transforms)
      : transforms_(transforms), product_(transforms.half()), values_(transforms.cells()) {}

  PairCorrelations of(const MemberSpectrum& a, const MemberSpectrum& b) {
    PairCorrelations found;
    double variance[num_bands] = {};
    std::fill(product_.begin(), product_.end(), 0);
    const std::size_t half = transforms_.half();
    for (std::size_t i = 0; i < a.spectrum.size(); ++i) {
      const std::complex<double> one(a.spectrum[i]);
      const std::complex<double> other(b.spectrum[i]);
      product_[i % half] += one * std::conj(other);
    }
    for (std::size_t k = 0; k < half; ++k) {
      found.bands[transforms_.band(k)] += transforms_.weight(k) * product_[k].real();
      variance[transforms_.band(k)] += transforms_.weight(k) * std::norm(product_[k]);
    }
    transforms_.inverse(product_, values_);
    const double scale = std::sqrt(a.power * b.power);
    double all = 0;
    for (int band = 0; band < num_bands; ++band) {
      all += variance[band];
      found.unshifted += found.bands[band] / scale;
      const double band_scale = std::sqrt(a.band_power[band] * b.band_power[band]);
      found.bands[band] = band_scale > 0 ? found.bands[band] / band_scale : 0;
      found.band_sigmas[band] = band_scale > 0 ? std::sqrt(variance[band]) / band_scale : 1;
    }
    found.sigma = std::sqrt(all) / scale;
    const auto largest =
        std::max_element(values_.begin(), values_.end(), [](double x, double y) { return std::abs(x) < std::abs(y); });
    found.shift = static_cast<std::size_t>(largest - values_.begin());
    found.shifted = *largest / scale;
    return found;
  }

 private:
  const Transforms& transforms_;
  std::vector<std::complex<double>> product_;
  std::vector<double> values_;
};

void keep_larger(LargestCorrelation& largest, double value, double sigma, const auto& where) {
  const double deviations = sigma > 0 ? std::abs(value) / sigma : 0;
  if (deviations <= largest.deviations) return;
  largest = {value, deviations, 1, where()};
}

// The members of one size, and what is found of them.
class PairedMembers {
 public:
  PairedMembers(const std::vector<MemberFile>& files, const OfOneSize& size, MembersVerification& found)
      : files_(files), size_(size), found_(found), transforms_(size.extents) {}

  void read(double most_work_of_this, ThreadPool& pool);
  void correlate(ThreadPool& pool);
  void add_powers();
  void compare_distributions();
  std::size_t num_read() const { return spectra_.size(); }
  // How many shifts of pairs were looked at.
  double num_shifted() const { return static_cast<double>(pairs_) * static_cast<double>(transforms_.cells()); }

 private:
  bool is_pair(const MemberSpectrum& a, const MemberSpectrum& b) const { return a.seed.empty() || a.seed != b.seed; }
  void count_pairs();
  void compare_values(const std::vector<const MemberSpectrum*>& alike, double tests);
  void compare_powers(const std::vector<const MemberSpectrum*>& alike, double tests);
  const std::string& name(const MemberSpectrum& member) const { return files_[member.number].name; }
  std::string pair_name(const MemberSpectrum& a, const MemberSpectrum& b) const {
    return fmt::format("{} and {}", name(a), name(b));
  }

  const std::vector<MemberFile>& files_;
  const OfOneSize& size_;
  MembersVerification& found_;
  Transforms transforms_;
  std::vector<MemberSpectrum> spectra_;
  std::int64_t pairs_ = 0;
};

// By the values, as rounding gives constant ones some power.
bool is_constant(const MemberSpectrum& one, std::size_t cells) {
  for (std::size_t first = 0; first < one.values.size(); first += cells) {
    if (one.values[first] != one.values[first + cells - 1]) return false;
  }
  return true;
}

void PairedMembers::read(double most_work_of_this, ThreadPool& pool) {
  const double work = static_cast<double>(size_.extents.num_cells()) * size_.channels;
  const auto most = static_cast<std::size_t>(std::max(2.0, std::sqrt(2 * most_work_of_this / work)));
  const std::size_t count = std::min(size_.numbers.size(), most);
  std::vector<std::optional<MemberSpectrum>> loaded(count);
  const auto number = [&](std::size_t i) { return size_.numbers[i * size_.numbers.size() / count]; };
  pool.for_each(static_cast<std::int64_t>(count), [&](std::int64_t at, int) {
    const auto i = static_cast<std::size_t>(at);
    const MemberFile& file = files_[number(i)];
    const StoredTexture stored = members::load(file);
    if (!size_of(stored).is_same(size_))
      throw UserError(file.path, fmt::format("has {} cells of {} channels, and another member of its settings {} of {}",
                                             stored.texture.extents.to_string(), stored.texture.channels,
                                             size_.extents.to_string(), size_.channels));
    MemberSpectrum spectrum = members::spectrum_of(stored.texture, kind_of(stored), number(i), transforms_);
    spectrum.seed = file.seed;
    if (file.seed.empty() && stored.config) spectrum.seed = std::to_string(stored.config->problem.seed);
    loaded[i] = std::move(spectrum);
  });
  for (std::optional<MemberSpectrum>& one : loaded) {
    if (is_constant(*one, transforms_.cells())) {
      found_.findings.push_back({"constant", true, fmt::format("all values of {} are equal", name(*one))});
    } else {
      spectra_.push_back(std::move(*one));
    }
  }
  found_.read += count;
  count_pairs();
}

void PairedMembers::count_pairs() {
  for (std::size_t i = 0; i < spectra_.size(); ++i) {
    bool compared = false;
    for (std::size_t j = 0; j < spectra_.size(); ++j) {
      const bool is_one = j != i && is_pair(spectra_[i], spectra_[j]);
      compared = compared || is_one;
      if (j < i) ++(is_one ? pairs_ : found_.pairs_of_one_seed);
    }
    found_.compared += compared ? 1 : 0;
  }
  found_.pairs += pairs_;
}

void PairedMembers::correlate(ThreadPool& pool) {
  std::mutex mutex;
  pool.for_each(static_cast<std::int64_t>(spectra_.size()), [&](std::int64_t i, int) {
    PairWork work(transforms_);
    const MemberSpectrum& a = spectra_[static_cast<std::size_t>(i)];
    for (std::size_t j = 0; j < static_cast<std::size_t>(i); ++j) {
      const MemberSpectrum& b = spectra_[j];
      if (!is_pair(a, b)) continue;
      const PairCorrelations pair = work.of(b, a);
      const std::lock_guard lock(mutex);
      keep_larger(found_.unshifted, pair.unshifted, pair.sigma, [&] { return pair_name(b, a); });
      if (pair.shift != 0) {
        keep_larger(found_.shifted, pair.shifted, pair.sigma, [&] {
          return fmt::format("{}, moved by {}", pair_name(b, a), transforms_.shift_text(pair.shift));
        });
      }
      for (int band = 0; band < num_bands; ++band) {
        keep_larger(found_.bands[static_cast<std::size_t>(band)].largest, pair.bands[band], pair.band_sigmas[band],
                    [&] { return pair_name(b, a); });
      }
    }
  });
}

// Adds this size's part to the mean power of each band.
void PairedMembers::add_powers() {
  double count = 0;
  for (int band = 0; band < num_bands; ++band) count += transforms_.frequencies_in_band(band);
  for (int band = 0; band < num_bands; ++band) {
    const double own = transforms_.frequencies_in_band(band);
    double power = 0;
    double whole = 0;
    for (const MemberSpectrum& one : spectra_) {
      power += one.band_power[band];
      whole += one.power;
    }
    if (own > 0 && whole > 0)
      found_.bands[static_cast<std::size_t>(band)].power +=
          power / whole * count / own * static_cast<double>(spectra_.size());
  }
}

void PairedMembers::compare_distributions() {
  std::map<std::string, std::vector<const MemberSpectrum*>> groups;
  for (const MemberSpectrum& one : spectra_) groups[files_[one.number].settings].push_back(&one);
  for (const auto& [settings, alike] : groups) {
    if (alike.size() < 2) continue;
    found_.alike += alike.size();
    compare_values(alike, static_cast<double>(files_.size()));
    compare_powers(alike, static_cast<double>(files_.size()) * num_bands);
  }
}

// Kolmogorov's distance of two distributions, each given by its sorted values: where the first one steps, it is largest
// either just before the step or at it.
double distance_of(std::span<const float> values, std::span<const float> all) {
  const auto share = [](std::size_t count, std::span<const float> of) {
    return static_cast<double>(count) / static_cast<double>(of.size());
  };
  double distance = 0;
  std::size_t seen = 0;  // of `all`
  for (std::size_t begin = 0; begin < values.size();) {
    const float value = values[begin];
    std::size_t end = begin;
    while (end < values.size() && values[end] == value) ++end;
    while (seen < all.size() && all[seen] < value) ++seen;
    distance = std::max(distance, std::abs(share(begin, values) - share(seen, all)));
    while (seen < all.size() && all[seen] <= value) ++seen;
    distance = std::max(distance, std::abs(share(end, values) - share(seen, all)));
    begin = end;
  }
  return distance;
}

void PairedMembers::compare_values(const std::vector<const MemberSpectrum*>& alike, double tests) {
  const std::size_t cells = transforms_.cells();
  const std::size_t signals = alike.front()->values.size() / cells;
  const double bound =
      std::sqrt(std::log(2 * tests * static_cast<double>(signals) / rare) / (2 * static_cast<double>(cells)));
  for (std::size_t signal = 0; signal < signals; ++signal) {
    std::vector<float> all;
    for (const MemberSpectrum* one : alike) {
      const auto begin = one->values.begin() + static_cast<std::ptrdiff_t>(signal * cells);
      all.insert(all.end(), begin, begin + static_cast<std::ptrdiff_t>(cells));
    }
    std::sort(all.begin(), all.end());
    for (const MemberSpectrum* one : alike) {
      const double distance = distance_of(std::span(one->values).subspan(signal * cells, cells), all);
      found_.distance = std::max(found_.distance, distance / bound);
      if (distance <= bound) continue;
      found_.findings.push_back({"distribution", true,
                                 fmt::format("the values of {} are not distributed as those of the other members: the "
                                             "distance is {:.4f}, and chance makes no more than {:.4f}",
                                             name(*one), distance, bound)});
    }
  }
}

void PairedMembers::compare_powers(const std::vector<const MemberSpectrum*>& alike, double tests) {
  if (alike.size() < 4) return;  // too few to tell what is usual
  const auto others = static_cast<double>(alike.size() - 1);
  for (int band = 0; band < num_bands; ++band) {
    std::vector<double> logs;
    for (const MemberSpectrum* one : alike)
      logs.push_back(std::log(std::max(one->band_power[band], 1e-12 * one->power)));
    for (std::size_t i = 0; i < alike.size(); ++i) {
      double sum = 0;
      double squares = 0;
      for (std::size_t j = 0; j < logs.size(); ++j) sum += j == i ? 0 : logs[j];
      for (std::size_t j = 0; j < logs.size(); ++j) squares += j == i ? 0 : std::pow(logs[j] - sum / others, 2);
      const double freedom = others - 1;
      const double spread = std::sqrt(squares / freedom * (1 + 1 / others)) + 1e-9;
      const double t = std::abs(logs[i] - sum / others) / spread;
      // Student's t as a normal number [Wallace 1959].
      const double deviations =
          (8 * freedom + 1) / (8 * freedom + 3) * std::sqrt(freedom * std::log1p(t * t / freedom));
      if (odds_among(deviations, tests) >= rare) continue;
      found_.findings.push_back(
          {"spectrum", true,
           fmt::format("{} has {:.3g} times the power of the other members between {:.3f} and {:.3f} cycles a pixel",
                       name(*alike[i]), std::exp(logs[i] - sum / others), 0.5 * band / num_bands,
                       0.5 * (band + 1) / num_bands)});
    }
  }
}

void note_correlation(const LargestCorrelation& largest, const std::string& what, MembersVerification& found) {
  if (largest.odds >= rare) return;
  found.findings.push_back({"correlation", true,
                            fmt::format("{} are correlated{}: r {:.4f}, {:.1f} standard deviations", largest.where,
                                        what, largest.value, largest.deviations)});
}

void find_repeated(const std::vector<MemberFile>& files, MembersVerification& found) {
  std::map<std::string, std::size_t> seen;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto [first, is_new] = seen.emplace(files[i].checksum, i);
    if (is_new) continue;
    found.findings.push_back(
        {"repeated", true, fmt::format("{} and {} hold the same values", files[first->second].name, files[i].name)});
  }
}

void correlate(const std::vector<std::unique_ptr<PairedMembers>>& sizes, MembersVerification& found, ThreadPool& pool) {
  if (found.pairs == 0) return;
  found.bands.resize(num_bands);
  double shifted = 0;
  std::size_t members = 0;
  for (const std::unique_ptr<PairedMembers>& one : sizes) {
    one->correlate(pool);
    one->add_powers();
    shifted += one->num_shifted();
    members += one->num_read();
  }
  const auto pairs = static_cast<double>(found.pairs);
  found.unshifted.odds = odds_among(found.unshifted.deviations, pairs);
  found.shifted.odds = odds_among(found.shifted.deviations, shifted);
  note_correlation(found.unshifted, "", found);
  note_correlation(found.shifted, "", found);
  for (int i = 0; i < num_bands; ++i) {
    MembersVerification::Band& band = found.bands[static_cast<std::size_t>(i)];
    band.first = 0.5 * i / num_bands;
    band.last = i + 1 < num_bands ? 0.5 * (i + 1) / num_bands : std::sqrt(0.5);
    band.power /= static_cast<double>(members);
    band.largest.odds = odds_among(band.largest.deviations, pairs * num_bands);
    if (found.unshifted.odds < rare && band.largest.where == found.unshifted.where) continue;  // said already
    note_correlation(band.largest, fmt::format(" between {:.3f} and {:.3f} cycles a pixel", band.first, band.last),
                     found);
  }
}

}  // namespace

MembersVerification verify_members(const std::vector<MemberFile>& files, ThreadPool& pool) {
  if (files.size() < 2)
    throw UserError("the bank", "has fewer than two members that are done: there is nothing to compare");
  MembersVerification found;
  found.members = files.size();
  find_repeated(files, found);
  const std::vector<OfOneSize> sizes = members::by_size(files, pool);
  std::vector<std::unique_ptr<PairedMembers>> paired;
  std::size_t before = 0;  // read, of other sizes
  for (const OfOneSize& size : sizes) {
    PairedMembers& one = *paired.emplace_back(std::make_unique<PairedMembers>(files, size, found));
    one.read(most_work / static_cast<double>(sizes.size()), pool);
    found.pairs_of_other_sizes += static_cast<std::int64_t>(before * one.num_read());
    before += one.num_read();
  }
  correlate(paired, found, pool);
  for (const std::unique_ptr<PairedMembers>& one : paired) one->compare_distributions();
  return found;
}

}  // namespace noiseloom
