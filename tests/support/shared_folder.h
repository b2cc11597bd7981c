// A temporary folder that all ranks of a test know.
#pragma once

#include <memory>
#include <string>

#include "noiseloom/dist/communicator.h"
#include "support/sample_run_file.h"

namespace noiseloom {

// The folder of rank 0, known to all.
class SharedFolder {
 public:
  explicit SharedFolder(const Communicator& world) : world_(world) {
    if (world.is_root()) folder_ = std::make_unique<TemporaryFolder>();
    path_ = folder_ ? folder_->path() : "";
    world.broadcast(path_);
  }
  ~SharedFolder() { world_.barrier(); }
  SharedFolder(const SharedFolder&) = delete;
  SharedFolder& operator=(const SharedFolder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  const Communicator& world_;
  std::unique_ptr<TemporaryFolder> folder_;
  std::string path_;
};

}  // namespace noiseloom
