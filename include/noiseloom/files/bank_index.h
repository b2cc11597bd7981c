// What is done of a bank, the textures of one folder: DIR/index.csv and DIR/index.json.
//
// A member that is done is a row that is appended to index.csv, under the index's lock and synced before it is told: so
// the rows say what is done at every moment and after any kill, and a bank costs as many rows as it has members. What a
// killed writer left of a row is cut off by the next one. When a command begins or ends, both files are written anew,
// with all members in the order of the bank, those that are not done as "open" or "begun"; rows of these go as soon as
// one of them is done, so that a member never has two. Of members of another bank in the same folder those rows are
// kept that are done. index.json is written besides as often as takes a twentieth of the time; after a kill it may lack
// what index.csv has, until the next command.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "noiseloom/core/stopwatch.h"
#include "noiseloom/files/run_lock.h"

namespace noiseloom {

struct IndexRow {
  std::string state = "open";  // not begun; "begun": something is saved; "done"
  double relative_error = std::numeric_limits<double>::quiet_NaN();
  double seconds = 0;
  std::string checksum = {};             // of /samples
  std::string config = {};               // a digest of the member's whole config
  std::vector<std::string> values = {};  // as TOML, of the settings that vary
};

std::string index_path(const std::string& folder);
std::string member_path(const std::string& folder, const std::string& name);

// The lock of the index. Others hold theirs for milliseconds; one of a node that died is waited for.
std::unique_ptr<RunLock> lock_index(const std::string& folder);

class BankIndex {
 public:
  struct Member {
    std::string name;
    std::string config;
    std::vector<std::string> values;
  };

  // Of a bank that varies the settings `keys`. Reads what stands in the folder: throws UserError where that is the
  // index of another bank.
  BankIndex(std::string folder, std::vector<std::string> keys, std::vector<Member> members);
  ~BankIndex();
  BankIndex(BankIndex&& other) noexcept;

  // Reads what was added since, by whomever.
  void refresh();
  // Null where the index says nothing of it.
  const IndexRow* find(const std::string& name) const;
  // Of the bank's members by their number, and how many of them.
  bool is_done(std::size_t member) const { return done_[member]; }
  std::int64_t num_done() const { return num_done_; }

  // Says that a member is done. False where the index says so already. Throws EnvironmentError.
  bool add(std::size_t member, const IndexRow& row);
  // Writes both files anew. A member without a run file is open, whatever was said of it. Throws EnvironmentError.
  void write();

 private:
  struct File;
  using Table = std::vector<std::pair<std::string, IndexRow>>;
  void forget();
  void put(const std::string& name, IndexRow row);
  void read_line(const std::string& line);
  void append(const std::string& line);
  Table table(bool with_open) const;
  void publish(const Table& rows, bool csv, bool json);

  std::string folder_;
  std::vector<std::string> keys_;
  std::vector<Member> members_;
  std::unordered_map<std::string, std::size_t> numbers_;  // of the members, by name
  std::unique_ptr<File> file_;                            // that `rows_` are of
  std::map<std::string, IndexRow> rows_;                  // of others' members too
  std::vector<bool> done_;
  std::int64_t num_done_ = 0;
  Stopwatch since_json_;
  double json_took_s_ = 0;
};

struct DoneMember {
  std::string name;
  std::string checksum;  // of /samples
  std::string settings;  // those that vary, but for the seed: "filter.groups[0].sigma = 0.7"
  std::string seed;      // "" where it does not vary
};
// The members that are done, in the order of the index. Throws UserError where the folder has no index.
std::vector<DoneMember> done_members(const std::string& folder);

}  // namespace noiseloom
