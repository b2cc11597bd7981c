// Threads inside a rank.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

namespace noiseloom {

// A fixed set of worker threads. Which worker runs which index is not determined, so bodies must not depend on it.
class ThreadPool {
 public:
  // Requires num_threads >= 1; one means "run in the calling thread".
  explicit ThreadPool(int num_threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int num_threads() const;
  // Calls body(index, worker) for every index in [0, count), worker in [0, num_threads). Returns when all are done; the
  // first exception of a body is rethrown here. Not reentrant.
  void for_each(std::int64_t count, const std::function<void(std::int64_t index, int worker)>& body);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Processors that this process may run on.
int num_available_processors();

}  // namespace noiseloom
