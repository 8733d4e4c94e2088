#include "algorithms/io/writer_pool.h"

#include "algorithms/core/errors.h"

namespace gaitcam {

WriterPool::WriterPool(int threads) : queue_(size_t(threads > 0 ? threads * kWaitingPerThread : 1)) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Work(); });
}

WriterPool::~WriterPool() {
  stopped_ = true;
  Join();
}

void WriterPool::Do(std::function<void()> job) {
  ThrowIfFailed();
  if (threads_.empty()) {
    job();
  } else {
    const bool taken = queue_.Push(std::move(job));
    GAITCAM_ASSERT(taken);
  }
}

void WriterPool::Finish() {
  Join();
  ThrowIfFailed();
}

void WriterPool::Work() {
  while (const auto job = queue_.Pop()) {
    if (stopped_) continue;  // drained, so that nobody waits for room
    try {
      (*job)();
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
      stopped_ = true;
    }
  }
}

void WriterPool::Join() {
  queue_.Close();
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

void WriterPool::ThrowIfFailed() {
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
}

}  // namespace gaitcam
