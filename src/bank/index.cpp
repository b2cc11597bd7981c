#include "bank/index.h"

#include "noiseloom/files/generations.h"

namespace noiseloom {

BankIndex read_index(const Bank& bank, const std::string& folder) {
  std::vector<BankIndex::Member> members;
  for (const BankMember& member : bank.members) members.push_back({member.name, member.config, member.values});
  return {folder, bank.keys, std::move(members)};
}

IndexRow row_of(const BankMember& member, const std::string& folder) {
  const RunFileReader reader = open_to_look_at(member_path(folder, member.name));
  const RunFileContent& content = reader.content();
  IndexRow row{.state = "done", .config = member.config, .values = member.values};
  if (const auto found = content.state.find("relative_error"); found != content.state.end()) {
    if (const auto* value = std::get_if<double>(&found->second)) row.relative_error = *value;
  }
  if (const auto found = content.provenance.find("seconds_total"); found != content.provenance.end()) {
    if (const auto* value = std::get_if<double>(&found->second)) row.seconds = *value;
  }
  if (const auto found = content.checksums.find("/samples"); found != content.checksums.end()) {
    row.checksum = found->second;
  }
  return row;
}

std::pair<std::int64_t, std::int64_t> count_done(const Bank& bank, const std::string& folder) {
  return {read_index(bank, folder).num_done(), static_cast<std::int64_t>(bank.members.size())};
}

void write_index(const Bank& bank, const std::string& folder) { read_index(bank, folder).write(); }

}  // namespace noiseloom
