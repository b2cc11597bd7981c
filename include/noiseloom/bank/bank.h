// Many textures from one config: a base, and lists of what differs from one member to the next.
//
// Each member is a run file of its own, DIR/NAME.h5, made by generate() and so whole or not there. Whoever works on a
// bank (groups of ranks, processes on one machine, jobs on others) shares nothing but the folder: each takes the next
// member that is neither done nor held by the lock of its run file. DIR/index.csv and DIR/index.json say what is done
// (files/bank_index.h): a member after its run file, so that what they say is done is done whenever they are read.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/dist/communicator.h"
#include "noiseloom/dist/watchdog.h"
#include "noiseloom/files/pack.h"
#include "noiseloom/files/run_lock.h"

namespace noiseloom {

struct BankMember {
  std::string name;                    // of its run file, without folder and ending
  std::vector<std::string> overrides;  // of the base: "texture.seed=2"
  std::vector<std::string> values;     // as TOML, one for each of Bank::keys
  std::string config;                  // a digest of its whole config
};

struct Bank {
  std::string base;               // the config that members differ from
  std::vector<std::string> keys;  // that vary
  std::vector<BankMember> members;
};

// Reads a bank file. `overrides` are settings of the base, for all members. Throws UserError with the faults of the
// file and of all members' configs, as load_config does.
Bank load_bank(const std::string& path, const std::vector<std::string>& overrides);
// The reference of all settings of such a file.
std::string describe_bank_settings();

struct BankRequest {
  std::string folder;
  int ranks_per_member = 1;
  int threads = 1;  // of each rank
  double time_limit_s = 0;
  double checkpoint_every_s = 600;
  WatchSettings watch;
};

// Tells others that a command works on a folder, for as long as it lives. When it ends, the locks of commands on other
// machines that were not heard of all that time are removed.
class AtWork {
 public:
  // `watched`: the outputs whose locks were left.
  AtWork(std::unique_ptr<RunLock> lock, const std::vector<std::string>& watched);
  ~AtWork();
  AtWork(const AtWork&) = delete;
  AtWork& operator=(const AtWork&) = delete;

 private:
  std::unique_ptr<RunLock> lock_;
  std::list<LockWatch> left_;
};

// Makes the folder ready before anybody works on it. Throws UserError where the folder holds a bank and neither
// `resume` nor `overwrite` is set, or one of other settings, or where a command makes another bank in it: its index and
// its saves would be taken for this one's. With `overwrite` the members that it holds are removed; UserError, and
// nothing is removed, where another command works on them.
std::unique_ptr<AtWork> prepare_bank(const Bank& bank, const std::string& folder, bool resume, bool overwrite);

// Writes the index anew, with all members in order.
void write_index(const Bank& bank, const std::string& folder);

// Why a member was not made: the user's fault, or that of the surroundings. Begins with the member's name.
struct BankFault {
  bool is_users = false;
  std::string words;
};

struct BankResult {
  bool stopped = false;           // by a signal or the time limit: there is more to do
  bool gave_up = false;           // on a rank whose group failed at several members in a row
  std::int64_t made = 0;          // by the caller's ranks
  std::vector<BankFault> faults;  // of all ranks
};

// Works until no member is left to take: what others hold is tried again, until they have made none for some seconds. A
// member that fails is left out. `say` is told of every member that is done, on the rank that leads its group; its
// arguments are label and text, as in the summary of generate(). `warn` is told at once of what fails. Throws
// SharedUserError and SharedEnvironmentError, where the folder or its index cannot be used, on every rank; for anything
// else that is thrown the caller must abort all. *Collective*
using SayMember = std::function<void(const std::vector<std::pair<std::string, std::string>>&)>;
using Warn = std::function<void(const std::string&)>;
BankResult work_on_bank(const Bank& bank, const BankRequest& request, const Communicator& communicator,
                        const SayMember& say, const Warn& warn);

// Before anything is made or removed: throws UserError where `path` is a file of the bank itself, or is there and
// `overwrite` is not set, or is something else than a pack.
void check_pack(const Bank& bank, const std::string& folder, const std::string& path, bool overwrite);

// All members, which must be done, as one HDF5 file (files/pack.h). Throws as pack_run_files does.
void pack_bank(const Bank& bank, const std::string& folder, const std::string& path, PackKind kind);

// How many members the folder's index says are done, and how many there are.
std::pair<std::int64_t, std::int64_t> count_done(const Bank& bank, const std::string& folder);

}  // namespace noiseloom
