#include "noiseloom/core/parallel.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "noiseloom/core/error.h"

namespace noiseloom {

// Tells the processor that this thread waits for another.
static void pause() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

struct ThreadPool::Impl {
  std::vector<std::thread> threads;
  std::chrono::microseconds patience{0};  // with another thread, before this one sleeps
  std::mutex mutex;
  std::condition_variable wake;
  std::condition_variable done;
  std::atomic<std::uint64_t> generation{0};  // written under the mutex, like `busy`
  std::atomic<std::size_t> busy{0};
  bool quit = false;
  const std::function<void(std::int64_t, int)>* body = nullptr;
  std::int64_t count = 0;
  std::atomic<std::int64_t> next{0};
  std::exception_ptr failure;

  void work(int worker) {
    for (;;) {
      const std::int64_t index = next.fetch_add(1, std::memory_order_relaxed);
      if (index >= count) return;
      try {
        (*body)(index, worker);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next.store(count, std::memory_order_relaxed);
      }
    }
  }

  // To be woken takes longer than many a body: what follows soon is waited for awake. By the clock, as other programs
  // may be on the processor between two looks.
  template <class Ready>
  void look_for(const Ready& ready) const {
    if (patience.count() == 0) return;
    const auto end = std::chrono::steady_clock::now() + patience;
    constexpr int looks = 64;  // about a microsecond, before others may have the processor, which takes as long
    while (!ready() && std::chrono::steady_clock::now() < end) {
      for (int i = 0; i < looks && !ready(); ++i) pause();
      if (!ready()) std::this_thread::yield();
    }
  }

  void join() {
    {
      const std::lock_guard lock(mutex);
      quit = true;
    }
    wake.notify_all();
    for (std::thread& thread : threads) thread.join();
  }

  void run_worker(int worker) {
    std::uint64_t seen = 0;
    for (;;) {
      look_for([&] { return generation.load(std::memory_order_relaxed) != seen; });
      {
        std::unique_lock lock(mutex);
        wake.wait(lock, [&] { return quit || generation != seen; });
        if (quit) return;
        seen = generation;
      }
      work(worker);
      const std::lock_guard lock(mutex);
      if (--busy == 0) done.notify_one();
    }
  }
};

ThreadPool::ThreadPool(int num_threads) : impl_(std::make_unique<Impl>()) {
  constexpr std::chrono::microseconds usual_patience{100};
  NOISELOOM_CHECK_LE(1, num_threads);
  if (num_threads <= num_available_processors()) impl_->patience = usual_patience;
  try {
    for (int worker = 1; worker < num_threads; ++worker) {
      impl_->threads.emplace_back([impl = impl_.get(), worker] { impl->run_worker(worker); });
    }
  } catch (const std::system_error& error) {
    impl_->join();
    throw EnvironmentError("cannot start " + std::to_string(num_threads) + " threads: " + error.what());
  }
}

ThreadPool::~ThreadPool() { impl_->join(); }

int ThreadPool::num_threads() const { return static_cast<int>(impl_->threads.size()) + 1; }

void ThreadPool::for_each(std::int64_t count, const std::function<void(std::int64_t, int)>& body) {
  impl_->body = &body;
  impl_->count = count;
  impl_->failure = nullptr;
  impl_->next.store(0, std::memory_order_relaxed);
  const bool shared = count > 1 && !impl_->threads.empty();
  if (shared) {
    const std::lock_guard lock(impl_->mutex);
    impl_->busy = impl_->threads.size();
    ++impl_->generation;
  }
  if (shared) impl_->wake.notify_all();
  impl_->work(0);
  if (shared) {
    impl_->look_for([&] { return impl_->busy.load(std::memory_order_relaxed) == 0; });
    std::unique_lock lock(impl_->mutex);
    impl_->done.wait(lock, [&] { return impl_->busy == 0; });
  }
  if (impl_->failure) std::rethrow_exception(impl_->failure);
}

int num_available_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) != 0) return 1;
  return std::max(1, CPU_COUNT(&set));
}

}  // namespace noiseloom
