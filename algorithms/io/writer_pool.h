/// Threads that encode and write files while their producer goes on. What they write does not depend on timing.

#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "algorithms/core/bounded_queue.h"

namespace gaitcam {

/// Carries out jobs on threads of its own. At most `kWaitingPerThread` jobs per thread wait; then Do() waits.
class WriterPool {
 public:
  static constexpr int kWaitingPerThread = 8;

  /// @param threads 0: every job is done in Do() itself.
  explicit WriterPool(int threads);
  /// Waits for the jobs that run; those that wait are dropped.
  ~WriterPool();
  WriterPool(const WriterPool&) = delete;
  WriterPool& operator=(const WriterPool&) = delete;

  /// @throws what an earlier job threw; then no further job is done.
  void Do(std::function<void()> job);
  /// Waits until all jobs are done; none may follow. @throws what a job threw.
  void Finish();

 private:
  void Work();
  void Join();
  void ThrowIfFailed();

  BoundedQueue<std::function<void()>> queue_;
  std::vector<std::thread> threads_;
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;
  std::exception_ptr failure_;  ///< The first; under mutex_.
};

}  // namespace gaitcam
