// The index of a bank, for those who work on it.
#pragma once

#include <string>

#include "noiseloom/bank/bank.h"
#include "noiseloom/files/bank_index.h"

namespace noiseloom {

// As it stands. Throws UserError where the folder holds another bank's.
BankIndex read_index(const Bank& bank, const std::string& folder);

// What the finished run file of a member says of it. Throws as open_to_look_at.
IndexRow row_of(const BankMember& member, const std::string& folder);

}  // namespace noiseloom
