/// A SLAM system on a thread of its own, fed through a bounded queue.

#pragma once

#include <exception>
#include <memory>
#include <optional>
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
  /// The system may ask something of the body: then frames go by Ask().
  bool acts() const { return answers_.has_value(); }
  /// Hands over one frame and waits for what the system asks of the body. @pre acts().
  BodyRequest Ask(Observation observation);
  /// Waits for the last frame. @returns everything the system said, its final word included.
  Estimate Finish();

 private:
  void Run();
  void Join();

  std::unique_ptr<System> system_;
  BoundedQueue<Observation> queue_{8};  // some megabytes, whatever the length of the run
  std::optional<BoundedQueue<BodyRequest>> answers_;
  Estimate estimate_;
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace gaitcam
