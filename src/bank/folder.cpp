// The folder of a bank: before its members are made, and when they are.
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <list>
#include <random>
#include <set>
#include <span>
#include <thread>

#include "bank/index.h"
#include "noiseloom/bank/bank.h"
#include "noiseloom/core/console.h"
#include "noiseloom/core/error.h"
#include "noiseloom/files/digest.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/output_files.h"
#include "noiseloom/files/pack.h"
#include "noiseloom/files/run_lock.h"

namespace noiseloom {
namespace fs = std::filesystem;
namespace {

// With all of them under lock at once, or with nothing removed. Only members that have a lock file may be held; a bank
// may have more members than a process may have locks.
void remove_members(const Bank& bank, const std::string& folder) {
  FileOps& ops = posix_file_ops();
  const auto say = [](const std::string& line) { print_error("noiseloom bank: " + line + "\n"); };
  std::vector<Fault> faults;
  std::list<RunLock> locks;
  const auto collecting = [&faults](const auto& body) {
    try {
      body();
    } catch (const UserError& error) {
      faults.insert(faults.end(), error.faults().begin(), error.faults().end());
    }
  };
  for (const BankMember& member : bank.members) {
    const std::string path = member_path(folder, member.name);
    for (const std::string& file : {path, previous_generation(path)}) {
      collecting([&] { refuse_foreign_output(file); });
    }
    if (fs::exists(path + ".lock")) collecting([&] { locks.emplace_back(path, say); });
  }
  throw_if_any(std::move(faults));
  const std::unique_ptr<RunLock> index = lock_index(folder);
  for (const BankMember& member : bank.members) {
    const std::string path = member_path(folder, member.name);
    for (const std::string& file : {path, previous_generation(path)}) {
      if (ops.exists(file)) ops.remove(file);
    }
  }
  if (ops.exists(index_path(folder))) ops.remove(index_path(folder));
}

// Removes the lock of an output whose holder is known to be dead. False where no lock is left.
bool is_left(const std::string& output) {
  LockWatch(output).remove_if_dead();
  return posix_file_ops().exists(output + ".lock");
}

// The commands that are at work on a folder each hold the lock of a file of this name, which is never there.
constexpr const char* at_work = ".at-work-";

// How the names begin of those that make this very bank.
std::string at_work_on(const Bank& bank) {
  std::string text;
  for (const std::string& key : bank.keys) text += key + '\n';
  for (const BankMember& member : bank.members) text += fmt::format("{} {}\n", member.name, member.config);
  return fmt::format("{}{}-", at_work, to_hex(digest_of(std::as_bytes(std::span<const char>(text)))));
}

std::vector<std::string> others_at_work(const std::string& folder, const std::string& own) {
  std::vector<std::string> others;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path path = entry->path();
    const std::string held = (path.parent_path() / path.stem()).string();
    if (path.extension() == ".lock" && path.filename().string().starts_with(at_work) && held != own)
      others.push_back(held);
  }
  return others;
}

// Throws OutputHeld where a command lives that is at work. One that looks for the same at this moment is none: it is on
// this machine and holds the lock for an instant, whereas one elsewhere has been waited for within RunLock.
void refuse_if_held(const std::string& other) {
  constexpr int tries = 5;
  constexpr std::chrono::milliseconds pause{100};
  constexpr std::chrono::seconds long_wait{1};
  for (int k = 1;; ++k) {
    const auto begun = std::chrono::steady_clock::now();
    try {
      const RunLock was_left(other, [](const std::string& line) { print_error("noiseloom bank: " + line + "\n"); });
      return;
    } catch (const OutputHeld&) {
      if (k == tries || std::chrono::steady_clock::now() - begun > long_wait) throw;
    }
    std::this_thread::sleep_for(pause);
  }
}

// Throws UserError where another command is at work, between two members of which it holds none of their locks: with
// `on_any` on any bank, else on another than this one.
void refuse_others_at_work(const Bank& bank, const std::string& folder, const std::string& own, bool on_any) {
  const std::string alike = at_work_on(bank);
  std::vector<Fault> faults;
  for (const std::string& other : others_at_work(folder, own)) {
    const bool is_alike = fs::path(other).filename().string().starts_with(alike);
    if ((is_alike && !on_any) || !is_left(other)) continue;
    try {
      refuse_if_held(other);
    } catch (const OutputHeld& error) {
      for (const Fault& fault : error.faults()) {
        faults.push_back({folder, is_alike ? fault.text
                                           : "another bank is being made in this folder; choose another one for this "
                                             "bank, or wait: " +
                                                 fault.text});
      }
    }
  }
  throw_if_any(std::move(faults));
}

}  // namespace

AtWork::AtWork(std::unique_ptr<RunLock> lock, const std::vector<std::string>& watched) : lock_(std::move(lock)) {
  for (const std::string& output : watched) left_.emplace_back(output).is_held();
}

AtWork::~AtWork() {
  for (LockWatch& watch : left_) {
    try {
      watch.remove_if_dead();
    } catch (const EnvironmentError&) {  // it stays
    }
  }
}

std::unique_ptr<AtWork> prepare_bank(const Bank& bank, const std::string& folder, bool resume, bool overwrite) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error)) {
    throw UserError(folder, "is not a folder; choose another output");
  }
  if (fs::exists(index_path(folder), error) && !resume && !overwrite) {
    throw UserError(folder, "holds a bank; go on with it with --resume, or replace it with --overwrite");
  }
  fs::create_directories(folder, error);
  if (error) throw EnvironmentError(fmt::format("{}: cannot create the folder: {}", folder, error.message()));
  const std::string own =
      (fs::path(folder) / fmt::format("{}{:08x}", at_work_on(bank), std::random_device()())).string();
  auto lock = std::make_unique<RunLock>(own);
  refuse_others_at_work(bank, folder, own, overwrite);
  if (overwrite) remove_members(bank, folder);
  const BankIndex index = read_index(bank, folder);
  std::vector<Fault> faults;
  for (const BankMember& member : bank.members) {
    const IndexRow* const known = index.find(member.name);
    if (known == nullptr || known->state == "open" || known->config == member.config) continue;
    faults.push_back({index_path(folder), fmt::format("{} was made from another config; choose another folder, or "
                                                      "--overwrite",
                                                      member.name)});
  }
  throw_if_any(std::move(faults));
  write_index(bank, folder);
  // A worker that was killed when its member was done, but not yet let go of, leaves a lock that nobody asks for again.
  std::vector<std::string> left;
  for (const std::string& other : others_at_work(folder, own)) {
    if (is_left(other)) left.push_back(other);
  }
  for (std::size_t i = 0; i < bank.members.size(); ++i) {
    if (std::string path = member_path(folder, bank.members[i].name); index.is_done(i) && is_left(path)) {
      left.push_back(std::move(path));
    }
  }
  return std::make_unique<AtWork>(std::move(lock), left);
}

void check_pack(const Bank& bank, const std::string& folder, const std::string& path, bool overwrite) {
  std::error_code unknown;
  const auto place = [&](const std::string& file) {
    return fs::weakly_canonical(fs::absolute(file, unknown), unknown);
  };
  std::set<fs::path> own = {place(index_path(folder)), place((fs::path(folder) / "index.json").string())};
  for (const BankMember& member : bank.members) own.insert(place(member_path(folder, member.name)));
  if (own.contains(place(path))) {
    throw UserError(path, "is a file of the bank itself; choose another file for --pack-into");
  }
  if (!fs::is_directory(parent_directory(path), unknown) && place(parent_directory(path)) != place(folder)) {
    throw UserError(parent_directory(path), "there is no such folder to write into (--pack-into)");
  }
  if (!fs::exists(fs::symlink_status(path, unknown))) return;
  if (!overwrite) throw UserError(path, "exists; remove it first, or choose another file for --pack-into");
  if (!fs::is_regular_file(path, unknown) || !looks_like_pack(path)) {
    throw UserError(path, "is not a file that --pack-into made, and is not replaced; choose another one");
  }
}

void pack_bank(const Bank& bank, const std::string& folder, const std::string& path, PackKind kind) {
  std::vector<PackMember> members;
  for (const BankMember& member : bank.members) {
    members.push_back({member.name, member_path(folder, member.name), member.values});
  }
  OutputFiles files(posix_file_ops(), true);
  pack_run_files(files.add(path), members, bank.keys, kind);
  files.commit();
}

}  // namespace noiseloom
