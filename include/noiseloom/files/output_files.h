// Output that appears whole or not at all: files are written under temporary names beside their targets and renamed
// when all of them are complete. Nothing is overwritten unless that was asked for.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/files/file_ops.h"

namespace noiseloom {

class OutputFiles {
 public:
  OutputFiles(FileOps& ops, bool overwrite) : ops_(ops), overwrite_(overwrite) {}
  // Removes the temporary files, and the folders that add() created, unless committed.
  ~OutputFiles();
  OutputFiles(const OutputFiles&) = delete;
  OutputFiles& operator=(const OutputFiles&) = delete;

  // Throws UserError listing the targets that exist and may not be overwritten, and those that are folders.
  void check(const std::vector<std::string>& targets) const;
  // The temporary path to write `target` to; it has the target's folder (created if missing) and extension. Throws
  // as check() does, and EnvironmentError when the folder cannot be made.
  std::string add(const std::string& target);
  // add() and write the bytes.
  void write(const std::string& target, std::span<const std::byte> bytes);
  void write(const std::string& target, const std::string& text);
  // add() and write what `write` appends, piece by piece.
  using Append = std::function<void(std::span<const std::byte>)>;
  void write_pieces(const std::string& target, const std::function<void(const Append&)>& write);
  // Those added so far.
  std::vector<std::string> targets() const;
  // Syncs and renames everything. Throws EnvironmentError.
  void commit();

 private:
  FileOps& ops_;
  bool overwrite_;
  std::vector<std::pair<std::string, std::string>> files_;  // temporary, target
  std::vector<std::string> new_folders_;                    // outermost first
};

}  // namespace noiseloom
