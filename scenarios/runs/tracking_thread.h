/// A SLAM system on a thread of its own, fed through a bounded queue.

#pragma once

#include <exception>
#include <memory>
#include <thread>

#include "algorithms/core/bounded_queue.h"
#include "algorithms/slam/system.h"

namespace gaitcam {

/// The system sees the same observations in the same order, however fast the producer is. What it throws is thrown
/// again at the producer.
class TrackingThread {
 public:
  explicit TrackingThread(std::unique_ptr<System> system);
  ~TrackingThread();
  TrackingThread(const TrackingThread&) = delete;
  TrackingThread& operator=(const TrackingThread&) = delete;

  /// Hands over one frame; waits while the queue is full.
  void Push(Observation observation);
  /// Waits for the last frame. @returns everything the system said, its final word included.
  Estimate Finish();

 private:
  void Run();
  void Join();

  std::unique_ptr<System> system_;
  BoundedQueue<Observation> queue_{8};  // some megabytes, whatever the length of the run
  Estimate estimate_;
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace gaitcam
