#include "thread_pool.hpp"

#include <pthread.h>

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace hgs {
namespace {

using Task = void (*)(void *, int);

class Pool {
 public:
  void run(int threads, Task task, void *context) {
    const std::unique_lock<std::mutex> turn(turn_, std::try_to_lock);
    if (!turn) {  // another caller has the threads: rather than wait for them, do the work here
      for (int thread = 0; thread < threads; ++thread) task(context, thread);
      return;
    }
    {
      const std::lock_guard<std::mutex> lock(state_);
      for (; started_ < threads - 1; ++started_) {
        std::thread(&Pool::work, this, started_ + 1, generation_).detach();
      }
      task_ = task;
      context_ = context;
      threads_ = threads;
      unfinished_ = threads - 1;
      error_ = nullptr;
      ++generation_;
    }
    wake_.notify_all();
    call(task, context, 0);
    std::unique_lock<std::mutex> lock(state_);
    done_.wait(lock, [&] { return unfinished_ == 0; });
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
  }

 private:
  void work(int thread, uint64_t seen) {
    std::unique_lock<std::mutex> lock(state_);
    for (;;) {
      wake_.wait(lock, [&] { return generation_ != seen; });
      seen = generation_;
      if (thread >= threads_) continue;
      const Task task = task_;
      void *const context = context_;
      lock.unlock();
      call(task, context, thread);
      lock.lock();
      if (--unfinished_ == 0) done_.notify_one();
    }
  }

  void call(Task task, void *context, int thread) {
    try {
      task(context, thread);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(state_);
      if (!error_) error_ = std::current_exception();
    }
  }

  std::mutex turn_;   // held by the caller whose loop is running
  std::mutex state_;  // guards everything below
  std::condition_variable wake_, done_;
  int started_ = 0;
  uint64_t generation_ = 0;
  Task task_ = nullptr;
  void *context_ = nullptr;
  int threads_ = 0;
  int unfinished_ = 0;
  std::exception_ptr error_;
};

std::atomic<Pool *> current_pool{nullptr};

// Pools are never destroyed: their threads wait on them until the process ends, and in a forked child, where those
// threads do not exist, their mutexes may be locked for ever.
Pool &pool() {
  static const int registered = pthread_atfork(nullptr, nullptr, [] { current_pool.store(nullptr); });
  static_cast<void>(registered);
  Pool *found = current_pool.load(std::memory_order_acquire);
  if (found == nullptr) {
    Pool *const fresh = new Pool;
    if (current_pool.compare_exchange_strong(found, fresh)) return *fresh;
    delete fresh;
  }
  return *found;
}

}  // namespace

void run_on_threads(int threads, void (*task)(void *context, int thread), void *context) {
  if (threads <= 1) {
    task(context, 0);
  } else {
    pool().run(threads, task, context);
  }
}

}  // namespace hgs
