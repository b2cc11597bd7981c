// Output that appears whole or not at all: files are written under temporary names beside their targets and renamed
// when all of them are complete. Nothing is overwritten unless that was asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "noiseloom/files/file_ops.h"

namespace noiseloom {

// A file that is written from its start to its end, piece by piece.
class OutputStream {
 public:
  // Creates the file. Throws EnvironmentError, as the functions below do.
  OutputStream(FileOps& ops, const std::string& path) : ops_(ops), file_(ops.create(path)) {}
  // Closes the file, unless that was done; a failure is then not told, as another one is on its way.
  ~OutputStream();
  OutputStream(const OutputStream&) = delete;
  OutputStream& operator=(const OutputStream&) = delete;

  void append(std::span<const std::byte> bytes);
  void append(const std::string& text) { append(std::as_bytes(std::span(text.data(), text.size()))); }
  void close();

 private:
  FileOps& ops_;
  std::optional<int> file_;  // none: closed
  std::uint64_t size_ = 0;
};

class OutputFiles {
 public:
  OutputFiles(FileOps& ops, bool overwrite) : ops_(ops), overwrite_(overwrite) {}
  // Removes the temporary files, and the folders that add() created, unless committed.
  ~OutputFiles();
  OutputFiles(const OutputFiles&) = delete;
  OutputFiles& operator=(const OutputFiles&) = delete;

  // Throws UserError listing the targets that exist and may not be overwritten, and those that are folders.
  void check(const std::vector<std::string>& targets) const;
  // The temporary path to write `target` to; it has the target's folder (created if missing) and extension. Where the
  // target is a symbolic link, what it leads to is written and the link stays. Throws as check() does, UserError where
  // two targets lead to one file, and EnvironmentError when the folder cannot be made.
  std::string add(const std::string& target);
  // add(), and the file to write to.
  std::unique_ptr<OutputStream> open(const std::string& target);
  // add() and write the whole file.
  void write(const std::string& target, const std::string& text);
  // Those added so far.
  std::vector<std::string> targets() const;
  // Syncs and renames everything. Throws EnvironmentError.
  void commit();

 private:
  void sync(const std::string& path);

  FileOps& ops_;
  bool overwrite_;
  struct File {
    std::string temporary;
    std::string target;
    std::string place;  // what the target is, or leads to as a symbolic link
  };
  std::vector<File> files_;
  std::vector<std::string> new_folders_;  // outermost first
};

}  // namespace noiseloom
