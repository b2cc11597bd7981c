#include <fmt/format.h>

#include <cmath>

#include "noiseloom/core/json.h"
#include "noiseloom/measure/members.h"

namespace noiseloom {
namespace {

std::string left_out(const MembersVerification& found) {
  std::string text;
  const auto line = [&](auto count, const char* of, const char* what) {
    if (count > 0) text += fmt::format("left out: {} {}{}{}\n", count, of, count == 1 ? "" : "s", what);
  };
  line(found.members - found.read, "member", ", so that it takes bounded time");
  line(found.pairs_of_one_seed, "pair", " of one seed, which begin with the same random numbers");
  line(found.pairs_of_other_sizes, "pair", " of different sizes or channels");
  if (found.pairs > 0)
    line(found.read - found.alike, "member",
         " where distributions were compared, for want of another of the same settings");
  return text;
}

std::string conclusion(const MembersVerification& found) {
  if (found.pairs == 0) return "no two members were compared: nothing is known of correlation and distribution\n";
  if (!found.is_sound()) return "";
  if (found.alike == 0)
    return "the members that were compared are uncorrelated; of their distribution nothing is known\n";
  return "the members that were compared are uncorrelated and alike\n";
}

std::string correlations_text(const MembersVerification& found) {
  std::string text;
  const auto line = [&](const std::string& what, const LargestCorrelation& largest) {
    if (largest.where.empty()) return;
    text += fmt::format("{:<24} largest |r| {:.4f}, {:.1f} standard deviations, odds {:.2g}: {}\n", what,
                        std::abs(largest.value), largest.deviations, largest.odds, largest.where);
  };
  line("same place", found.unshifted);
  line("another place", found.shifted);
  for (const MembersVerification::Band& band : found.bands) {
    line(fmt::format("{:.3f} to {:.3f}, power {:.3g}", band.first, band.last, band.power), band.largest);
  }
  return text;
}

}  // namespace

std::string members_text(const MembersVerification& found, const std::string& name) {
  std::string text =
      fmt::format("{}: {} members, {} of them compared, {} pairs\n", name, found.members, found.compared, found.pairs);
  text += left_out(found) + correlations_text(found);
  if (found.alike > 0)
    text += fmt::format("values: {:.2f} of the distance that chance makes once in a million\n", found.distance);
  for (const Finding& finding : found.findings) text += fmt::format("FAULT {}\n", finding.text);
  return text + conclusion(found);
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
      "{{\"bank\": {}, \"members\": {}, \"read\": {}, \"compared\": {}, \"pairs\": {}, \"pairs_of_one_seed\": {}, "
      "\"pairs_of_other_sizes\": {}, \"alike\": {}, \"unshifted\": {}, \"shifted\": {}, \"bands\": [{}], "
      "\"distance\": {}, \"sound\": {}, \"findings\": [{}]}}",
      json_string(name), found.members, found.read, found.compared, found.pairs, found.pairs_of_one_seed,
      found.pairs_of_other_sizes, found.alike, correlation(found.unshifted), correlation(found.shifted), bands,
      json_number(found.distance), found.is_sound(), findings);
}

}  // namespace noiseloom
