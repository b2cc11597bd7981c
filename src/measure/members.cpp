#include "noiseloom/measure/members.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <optional>

#include "measure/members_parts.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/json.h"

namespace noiseloom {
namespace {

using members::MemberSpectrum;
using members::num_bands;
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
      const std::complex<double> product = one * std::conj(other);
      const std::size_t k = i % half;
      product_[k] += product;
      found.bands[transforms_.band(k)] += transforms_.weight(k) * product.real();
      variance[transforms_.band(k)] += transforms_.weight(k) * std::norm(product);
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
  PairedMembers(const std::vector<MemberFile>& files, MembersVerification& found) : files_(files), found_(found) {}

  void load(const std::vector<std::size_t>& numbers, ThreadPool& pool);
  void correlate(ThreadPool& pool);
  void compare_distributions();

 private:
  void compare_values(const std::vector<const MemberSpectrum*>& alike, double tests);
  void compare_powers(const std::vector<const MemberSpectrum*>& alike, double tests);
  const std::string& name(const MemberSpectrum& member) const { return files_[member.number].name; }
  std::string pair_name(const MemberSpectrum& a, const MemberSpectrum& b) const {
    return fmt::format("{} and {}", name(a), name(b));
  }

  const std::vector<MemberFile>& files_;
  MembersVerification& found_;
  std::unique_ptr<Transforms> transforms_;
  std::vector<MemberSpectrum> spectra_;
};

void PairedMembers::load(const std::vector<std::size_t>& numbers, ThreadPool& pool) {
  const auto load_one = [&](std::size_t number) { return load_stored_texture(files_[number].path, std::nullopt); };
  const StoredTexture first = load_one(numbers.front());
  const double work = static_cast<double>(first.texture.extents.num_cells()) * first.texture.channels;
  const auto most = static_cast<std::size_t>(std::max(2.0, std::sqrt(2 * most_work / work)));
  const std::size_t count = std::min(numbers.size(), most);
  transforms_ = std::make_unique<Transforms>(first.texture.extents);
  std::vector<std::optional<MemberSpectrum>> loaded(count);
  pool.for_each(static_cast<std::int64_t>(count), [&](std::int64_t i, int) {
    const std::size_t number = numbers[static_cast<std::size_t>(i) * numbers.size() / count];
    const StoredTexture stored = load_one(number);
    const bool fits =
        stored.texture.extents == first.texture.extents && stored.texture.channels == first.texture.channels;
    if (!fits) return;
    const DistanceKind kind = stored.config ? distance_kind(stored.config->problem.samples, stored.texture.channels)
                                            : DistanceKind::euclidean;
    MemberSpectrum spectrum = members::spectrum_of(stored.texture, kind, number, *transforms_);
    if (spectrum.power > 0) loaded[static_cast<std::size_t>(i)] = std::move(spectrum);
  });
  for (std::optional<MemberSpectrum>& one : loaded) {
    if (one) spectra_.push_back(std::move(*one));
  }
  found_.compared = spectra_.size();
}

void PairedMembers::correlate(ThreadPool& pool) {
  std::mutex mutex;
  found_.pairs = static_cast<std::int64_t>(spectra_.size() * (spectra_.size() - (spectra_.empty() ? 0 : 1)) / 2);
  found_.bands.resize(num_bands);
  pool.for_each(static_cast<std::int64_t>(spectra_.size()), [&](std::int64_t i, int) {
    PairWork work(*transforms_);
    const MemberSpectrum& a = spectra_[static_cast<std::size_t>(i)];
    for (std::size_t j = 0; j < static_cast<std::size_t>(i); ++j) {
      const MemberSpectrum& b = spectra_[j];
      const PairCorrelations pair = work.of(b, a);
      const std::lock_guard lock(mutex);
      keep_larger(found_.unshifted, pair.unshifted, pair.sigma, [&] { return pair_name(b, a); });
      keep_larger(found_.shifted, pair.shifted, pair.sigma,
                  [&] { return fmt::format("{}, moved by {}", pair_name(b, a), transforms_->shift_text(pair.shift)); });
      for (int band = 0; band < num_bands; ++band) {
        keep_larger(found_.bands[static_cast<std::size_t>(band)].largest, pair.bands[band], pair.band_sigmas[band],
                    [&] { return pair_name(b, a); });
      }
    }
  });
  const auto pairs = static_cast<double>(found_.pairs);
  found_.unshifted.odds = odds_among(found_.unshifted.deviations, pairs);
  found_.shifted.odds = odds_among(found_.shifted.deviations, pairs * static_cast<double>(transforms_->cells()));
  for (int band = 0; band < num_bands; ++band) {
    MembersVerification::Band& of = found_.bands[static_cast<std::size_t>(band)];
    of.first = 0.5 * band / num_bands;
    of.last = band + 1 < num_bands ? 0.5 * (band + 1) / num_bands : std::sqrt(0.5);
    double whole = 0;
    for (const MemberSpectrum& one : spectra_) {
      of.power += one.band_power[band];
      whole += one.power;
    }
    double count = 0;
    for (int other = 0; other < num_bands; ++other) count += transforms_->frequencies_in_band(other);
    const double own = transforms_->frequencies_in_band(band);
    of.power = own > 0 && whole > 0 ? of.power / whole * count / own : 0;
    of.largest.odds = odds_among(of.largest.deviations, pairs * num_bands);
  }
}

void PairedMembers::compare_distributions() {
  std::map<std::string, std::vector<const MemberSpectrum*>> groups;
  for (const MemberSpectrum& one : spectra_) groups[files_[one.number].settings].push_back(&one);
  for (const auto& [settings, alike] : groups) {
    if (alike.size() < 2) continue;
    compare_values(alike, static_cast<double>(spectra_.size()));
    compare_powers(alike, static_cast<double>(spectra_.size()) * num_bands);
  }
}

void PairedMembers::compare_values(const std::vector<const MemberSpectrum*>& alike, double tests) {
  const std::size_t cells = transforms_->cells();
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
      double distance = 0;
      std::size_t seen = 0;  // of `all`, up to the value looked at
      for (std::size_t i = 0; i < cells; ++i) {
        const float value = one->values[signal * cells + i];
        if (i + 1 < cells && one->values[signal * cells + i + 1] == value) continue;
        while (seen < all.size() && all[seen] <= value) ++seen;
        distance = std::max(distance, std::abs(static_cast<double>(i + 1) / static_cast<double>(cells) -
                                               static_cast<double>(seen) / static_cast<double>(all.size())));
      }
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

}  // namespace

MembersVerification verify_members(const std::vector<MemberFile>& files, ThreadPool& pool) {
  if (files.size() < 2)
    throw UserError("the bank", "has fewer than two members that are done: there is nothing to compare");
  MembersVerification found;
  found.members = files.size();
  std::map<std::string, std::size_t> seen;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto [first, is_new] = seen.emplace(files[i].checksum, i);
    if (is_new) continue;
    found.findings.push_back(
        {"repeated", true, fmt::format("{} and {} hold the same values", files[first->second].name, files[i].name)});
  }
  std::vector<std::size_t> numbers(files.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = i;
  PairedMembers comparison(files, found);
  comparison.load(numbers, pool);
  comparison.correlate(pool);
  note_correlation(found.unshifted, "", found);
  note_correlation(found.shifted, "", found);
  for (const MembersVerification::Band& band : found.bands) {
    note_correlation(band.largest, fmt::format(" between {:.3f} and {:.3f} cycles a pixel", band.first, band.last),
                     found);
  }
  comparison.compare_distributions();
  return found;
}

std::string members_text(const MembersVerification& found, const std::string& name) {
  std::string text =
      fmt::format("{}: {} members, {} of them compared, {} pairs\n", name, found.members, found.compared, found.pairs);
  const auto line = [&](const std::string& what, const LargestCorrelation& largest) {
    text += fmt::format("{:<24} largest |r| {:.4f}, {:.1f} standard deviations, odds {:.2g}{}{}\n", what,
                        std::abs(largest.value), largest.deviations, largest.odds, largest.where.empty() ? "" : ": ",
                        largest.where);
  };
  line("same place", found.unshifted);
  line("any shift", found.shifted);
  for (const MembersVerification::Band& band : found.bands) {
    line(fmt::format("{:.3f} to {:.3f}, power {:.3g}", band.first, band.last, band.power), band.largest);
  }
  text += fmt::format("values: {:.2f} of the distance that chance makes once in a million\n", found.distance);
  for (const Finding& finding : found.findings) text += fmt::format("FAULT {}\n", finding.text);
  return text + (found.is_sound() ? "the members are uncorrelated and alike\n" : "");
}

std::string members_json(const MembersVerification& found, const std::string& name) {
  const auto correlation = [](const LargestCorrelation& largest) {
    return json_object(
        {{"r", largest.value}, {"deviations", largest.deviations}, {"odds", largest.odds}, {"where", largest.where}});
  };
  std::string bands;
  for (const MembersVerification::Band& band : found.bands) {
    bands += fmt::format("{}{{\"from\": {}, \"to\": {}, \"power\": {}, \"largest\": {}}}", bands.empty() ? "" : ", ",
                         json_number(band.first), json_number(band.last), json_number(band.power),
                         correlation(band.largest));
  }
  std::string findings;
  for (const Finding& finding : found.findings) {
    findings += (findings.empty() ? "" : ", ") + json_object({{"kind", finding.kind}, {"text", finding.text}});
  }
  return fmt::format(
      "{{\"bank\": {}, \"members\": {}, \"compared\": {}, \"pairs\": {}, \"unshifted\": {}, \"shifted\": {}, "
      "\"bands\": [{}], "
      "\"distance\": {}, \"sound\": {}, \"findings\": [{}]}}",
      json_string(name), found.members, found.compared, found.pairs, correlation(found.unshifted),
      correlation(found.shifted), bands, json_number(found.distance), found.is_sound(), findings);
}

}  // namespace noiseloom
