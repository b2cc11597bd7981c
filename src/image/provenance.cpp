#include "image/provenance.h"

#include <fmt/format.h>

#include "noiseloom/image/naming.h"

namespace noiseloom {

Facts facts_of(const RunFileContent& content, const RunConfig& config) {
  const ProblemSpec& problem = config.problem;
  Facts facts = {{"samples", problem.samples.space},
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

std::string facts_line(const Facts& facts) {
  std::string line;
  for (const auto& [key, value] : facts)
    if (key != "config") line += fmt::format("{}{} {}", line.empty() ? "" : "; ", key, value);
  return line;
}

}  // namespace noiseloom
