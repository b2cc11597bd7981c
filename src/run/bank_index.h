// DIR/index.csv and DIR/index.json of a bank.
#pragma once

#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "noiseloom/files/run_lock.h"
#include "noiseloom/run/bank.h"

namespace noiseloom {

struct IndexRow {
  std::string state = "open";  // not begun; "begun": something is saved; "done"
  double relative_error = std::numeric_limits<double>::quiet_NaN();
  double seconds = 0;
  std::string checksum = {};  // of /samples
  std::string config = {};
  std::vector<std::string> values = {};
};

using BankIndex = std::map<std::string, IndexRow>;  // by the member's name

std::string index_path(const std::string& folder);
std::string member_path(const std::string& folder, const std::string& name);

// The lock of the index. Others hold theirs for milliseconds; one of a node that died is waited for.
std::unique_ptr<RunLock> lock_index(const std::string& path);

// What the index says; empty where there is none. Throws UserError where it is none of a bank that varies these keys.
BankIndex read_index(const Bank& bank, const std::string& folder);

// Whether that row says that this very member is done.
bool is_done(const BankIndex& index, const BankMember& member);

// Puts `row` into the index as it stands now, under a lock, as others may do the same at this moment. Without a name:
// just writes it. False where it says already that the member is done. Throws EnvironmentError.
bool update_index(const Bank& bank, const std::string& folder, const std::string& name, const IndexRow& row);

// What the finished run file of a member says of it. Throws as open_to_look_at.
IndexRow row_of(const BankMember& member, const std::string& folder);

}  // namespace noiseloom
