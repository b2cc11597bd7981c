#include "noiseloom/measure/verify.h"

#include <fmt/format.h>

#include <algorithm>

#include "measure/verify_parts.h"
#include "noiseloom/core/json.h"
#include "noiseloom/image/naming.h"
#include "noiseloom/measure/nets.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

using verify::Subject;

bool all_equal(const Texture& texture) {
  return std::all_of(texture.values.begin(), texture.values.end(),
                     [&](float v) { return v == texture.values.front(); });
}

bool has_time(const Extents& extents) { return extents.num_slice_axes() > 0 && extents.size(2) > 1; }

FilterSpec gauss_then_average() {
  GroupSpec gauss;
  gauss.axes = {0, 1};
  gauss.kernel.kind = KernelKind::gauss;
  gauss.kernel.sigma = 1;
  GroupSpec average;
  average.axes = {2};
  average.kernel.kind = KernelKind::ema;
  return {Combine::product, {gauss, average}};
}

// The filters of score, the usual product over x, y and the first slice axis, and the file's own.
std::vector<FilterSpec> filters_of(const Subject& subject) {
  const Extents& extents = subject.texture.extents;
  std::vector<FilterSpec> filters = standard_filters(extents);
  if (has_time(extents)) filters.push_back(gauss_then_average());
  if (subject.stored.config) filters.push_back(subject.stored.config->problem.filter);
  return filters;
}

void check_scores(const Subject& subject, const std::string& path, Verification& found, ThreadPool& pool) {
  const DistanceKind kind = distance_kind(subject.samples, subject.texture.channels);
  const double mean = mean_distance_of(subject.texture, kind, pool);
  for (const FilterSpec& filter : filters_of(subject)) {
    const std::string words = describe_filter(subject.texture.extents, filter);
    if (std::any_of(found.scores.begin(), found.scores.end(), [&](const FilterScore& s) { return s.filter == words; }))
      continue;
    found.scores.push_back({words, relative_error_of(subject.texture, kind, filter, mean, pool)});
  }
  const auto score_of = [&](const FilterSpec& filter) {
    const std::string words = describe_filter(subject.texture.extents, filter);
    return std::find_if(found.scores.begin(), found.scores.end(),
                        [&](const FilterScore& s) { return s.filter == words; })
        ->relative_error;
  };
  if (const FilterSpec joint = gauss_then_average(); has_time(subject.texture.extents))
    verify::check_time(subject, path, score_of({Combine::product, {joint.groups.front()}}), score_of(joint), found);
  constexpr double gains_nothing = 0.95;
  const bool white = std::all_of(found.scores.begin(), found.scores.end(),
                                 [](const FilterScore& s) { return s.relative_error > gains_nothing; });
  // R is that of a texture that goes around, and pixels near an end have other values than the rest by right: where the
  // file says that it ends, the spectra of its groups tell.
  const auto has_hole = [](const GroupQuality& group) { return group.low_frequency_power < 0.5; };
  for (int axis = 0; axis < subject.texture.extents.num_axes(); ++axis)
    if (verify::ends_along(subject, axis) &&
        std::any_of(found.quality.groups.begin(), found.quality.groups.end(), has_hole))
      return;
  // White noise of few pixels comes that low by chance.
  constexpr std::int64_t enough = 1024;
  if (white && subject.texture.extents.cells_per_slice() >= enough)
    found.findings.push_back(
        {"white", true,
         "no filter leaves less than 95 % of the error of white noise: the values lie as chance puts them"});
}

// Codes of 16 bits and floats alone: 8 bits hold no net of more than 256 points.
void check_nets(const Subject& subject, Verification& found) {
  const Texture& texture = subject.texture;
  constexpr double fine = 1.0 / 65536;
  const bool in_cube =
      !subject.samples.is_file() && (subject.samples.space == "uniform" || subject.samples.space == "sobol-owen" ||
                                     subject.samples.space.starts_with("vector"));
  if (!in_cube || texture.channels > 3 || subject.step > fine) return;
  int worst = 0;
  for (const SliceIndex s : texture.extents.slices()) {
    const std::optional<int> t = net_quality(interleaved_slice(texture, s), texture.channels);
    if (!t) return;
    worst = std::max(worst, *t);
  }
  found.net = worst;
  if (subject.samples.space == "sobol-owen" && texture.channels <= 2 && worst > 0)
    found.findings.push_back(
        {"nets", true,
         fmt::format("a slice is no net, but t = {}: an elementary interval holds more than its share", worst)});
}

std::string quoted_list(const Verification& v, bool faults) {
  std::string text;
  for (const Finding& f : v.findings)
    if (f.is_fault == faults)
      text += fmt::format("{}{{\"kind\": {}, \"text\": {}}}", text.empty() ? "" : ", ", json_string(f.kind),
                          json_string(f.text));
  return "[" + text + "]";
}

std::string range_text(std::int64_t least, std::int64_t most) {
  return least == most ? std::to_string(least) : fmt::format("{} to {}", least, most);
}

}  // namespace

bool Verification::is_sound() const {
  return std::none_of(findings.begin(), findings.end(), [](const Finding& f) { return f.is_fault; });
}

Verification verify_texture(const StoredTexture& stored, const std::string& path, bool is_given, ThreadPool& pool) {
  check_finite(stored.texture, path);
  Verification found;
  const Subject subject = verify::meaning_of(stored, is_given, found.why);
  found.samples = subject.samples;
  found.extents = subject.texture.extents;
  for (const std::size_t c : subject.channels)
    found.channels += (found.channels.empty() ? "" : ", ") + stored.channel_names[c];
  if (all_equal(subject.texture)) {
    found.findings.push_back({"constant", true, "all values are equal"});
    return found;
  }
  verify::check_values(subject, found);
  verify::check_slices(subject, found);
  verify::check_edges(subject, found);
  verify::check_spectra(subject, found);
  check_nets(subject, found);
  check_scores(subject, path, found, pool);
  return found;
}

std::string verification_text(const Verification& v, const StoredTexture& stored, const std::string& path) {
  std::string text = fmt::format("{}: {}, {}\n", path, stored.source, v.extents.to_string());
  text += fmt::format("taken for samples \"{}\" in {}: {}\n", describe_samples(v.samples), v.channels, v.why);
  for (const std::string& note : stored.notes) text += "note: " + note + "\n";
  text += "\n";
  if (v.is_sound()) text += "nothing wrong was found\n";
  for (const Finding& f : v.findings)
    if (f.is_fault) text += fmt::format("wrong ({}): {}\n", f.kind, f.text);
  for (const Finding& f : v.findings)
    if (!f.is_fault) text += f.text + "\n";
  for (const LevelCounts& c : v.levels)
    text += fmt::format("each of {} levels occurs {} times a slice, {} times in all\n", std::int64_t{1} << c.bits,
                        range_text(c.least_in_a_slice, c.most_in_a_slice), range_text(c.least_in_all, c.most_in_all));
  if (v.net) text += fmt::format("slices as nets: t = {}\n", *v.net);
  text += quality_text(v.quality);
  for (const FilterScore& score : v.scores) {
    const auto published = published_score(v.samples, score.filter);
    text += fmt::format("R = {:.4f}   {}{}\n", score.relative_error, score.filter,
                        published ? fmt::format("   (published textures reach {:.4f})", *published) : "");
  }
  return text;
}

std::string verification_json(const Verification& v, const StoredTexture& stored, const std::string& path) {
  std::string scores;
  for (const FilterScore& s : v.scores)
    scores += fmt::format("{}{}: {}", scores.empty() ? "" : ", ", json_string(s.filter), json_number(s.relative_error));
  std::string levels;
  for (const LevelCounts& c : v.levels)
    levels += fmt::format("{}{{\"bits\": {}, \"used\": {}, \"per_slice\": [{}, {}], \"in_all\": [{}, {}]}}",
                          levels.empty() ? "" : ", ", c.bits, c.levels_used, c.least_in_a_slice, c.most_in_a_slice,
                          c.least_in_all, c.most_in_all);
  return fmt::format(
      "{{\"file\": {}, \"sound\": {}, \"faults\": {}, \"remarks\": {}, \"taken_for\": {{\"samples\": {}, \"size\": {}, "
      "\"channels\": {}, \"source\": {}, \"why\": {}}}, \"levels\": [{}], \"net\": {}, {}, \"relative_errors\": "
      "{{{}}}}}",
      json_string(path), v.is_sound(), quoted_list(v, true), quoted_list(v, false),
      json_string(describe_samples(v.samples)), json_string(v.extents.to_string()), json_string(v.channels),
      json_string(stored.source), json_string(v.why), levels, v.net ? std::to_string(*v.net) : "null",
      quality_json(v.quality), scores);
}

}  // namespace noiseloom
