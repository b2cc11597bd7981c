#include "image/facts/provenance.h"

#include <fmt/format.h>

#include <charconv>

#include "noiseloom/config/inputs.h"
#include "noiseloom/image/naming.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

Facts facts_of(const RunFileContent& content, const RunConfig& config) {
  const ProblemSpec& problem = config.problem;
  Facts facts = {{"samples", describe_samples(problem.samples)},
                 {"seed", std::to_string(problem.seed)},
                 {"filter", describe_filter(problem.extents, problem.filter)}};
  for (const auto& [column, values] : content.history)
    if (column == "relative_error" && !values.empty())
      facts.emplace_back("relative_error", fmt::format("{}", values.back()));
  if (const auto found = content.checksums.find("/samples"); found != content.checksums.end())
    facts.emplace_back("checksum", found->second);
  facts.emplace_back("config", content.config);
  return facts;
}

Facts reading_facts(const ContainerJob& job) {
  std::string layout = to_string(job.layout);
  if (job.layout == ExportLayout::atlas)
    layout = fmt::format("atlas:{}x{}", job.columns, (job.num_slices + job.columns - 1) / job.columns);
  return {{"layout", layout},
          {"slices", fmt::format("{}:{}", job.first_slice.value(), job.slices().past_last().value())},
          {"range", job.range ? fmt::format("{}:{}", shortest_number(job.range->lo), shortest_number(job.range->hi))
                              : std::string("values")}};
}

namespace {

std::string fact(const Facts& facts, const std::string& key) {
  for (const auto& [name, value] : facts)
    if (name == key) return value;
  return "";
}

// "A:B"
std::optional<std::pair<std::int64_t, std::int64_t>> slices_in(const std::string& text) {
  std::int64_t begin = 0;
  std::int64_t end = 0;
  const char* const last = text.data() + text.size();
  const auto [colon, error] = std::from_chars(text.data(), last, begin);
  if (error != std::errc{} || colon == last || *colon != ':') return std::nullopt;
  const auto [stop, end_error] = std::from_chars(colon + 1, last, end);
  if (end_error != std::errc{} || stop != last || begin < 0 || end <= begin) return std::nullopt;
  return std::pair(begin, end);
}

}  // namespace

std::optional<OwnFacts> own_facts(const Facts& facts, const std::string& name,
                                  const std::vector<std::string>& overrides) {
  const std::string config = fact(facts, "config");
  const std::string range = fact(facts, "range");
  const std::string layout = fact(facts, "layout");
  const auto slices = slices_in(fact(facts, "slices"));
  if (config.empty() || range.empty() || layout.empty() || !slices) return std::nullopt;
  OwnFacts own{
      parse_config(config, name + ": the config in it", parent_directory(name), overrides, MissingFiles::accepted),
      layout, std::nullopt};
  if (range != "values") own.range = parse_range(range);
  Extents& extents = own.config.problem.extents;
  const std::int64_t count = slices->second - slices->first;
  if (count == extents.num_slices() || layout == "slices") return own;
  if (extents.num_axes() != 3 || slices->second > extents.num_slices()) return std::nullopt;
  // Some of the slices: which of several axes they are cut from could not be said.
  own.config.problem.extents =
      Extents({extents.width(), extents.height(), count}, {extents.name(0), extents.name(1), extents.name(2)});
  return own;
}

std::string facts_line(const Facts& facts) {
  std::string line;
  for (const auto& [key, value] : facts)
    if (key != "config") line += fmt::format("{}{} {}", line.empty() ? "" : "; ", key, value);
  return line;
}

}  // namespace noiseloom
