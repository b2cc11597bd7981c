// Numbers that all ranks read and none changes, once a node instead of once a rank.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "noiseloom/core/shared_values.h"
#include "noiseloom/dist/communicator.h"

namespace noiseloom {

// A block of memory of each node: one rank of the node fills it, then all of them read it. Where a node's ranks cannot
// share memory (/dev/shm is full, or each of them sees one of its own), each rank fills a block of its own.
class NodeMemory {
 public:
  // Throws EnvironmentError on every rank where one of them has no memory left. *Collective*
  NodeMemory(const Communicator& communicator, std::size_t bytes);
  ~NodeMemory();
  NodeMemory(const NodeMemory&) = delete;
  NodeMemory& operator=(const NodeMemory&) = delete;

  // To be filled by this rank; empty where another rank of the node does that.
  std::span<std::byte> to_fill() const;
  // Ends the filling; the block lives as long as anyone holds the values. Ranks of one node must not differ in whether
  // they call it. *Collective*
  template <class T>
  SharedValues<T> filled() {
    const std::span<const std::byte> bytes = wait_until_filled();
    return {owner(), {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)}};
  }

 private:
  std::span<const std::byte> wait_until_filled() const;
  std::shared_ptr<const void> owner() const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace noiseloom
