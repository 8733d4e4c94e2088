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
  /// @param acts whether the system commands the body (SystemInfo::acts): then frames go by Ask().
  explicit TrackingThread(std::unique_ptr<System> system, bool acts = false);
  ~TrackingThread();
  TrackingThread(const TrackingThread&) = delete;
  TrackingThread& operator=(const TrackingThread&) = delete;

  /// Hands over one frame; waits while the queue is full. @pre not acts().
  void Push(Observation observation);
  bool acts() const { return answers_.has_value(); }
  /// Hands over one frame and waits for what the body is asked to do. @pre acts().
  BodyCommand Ask(Observation observation);
  /// Waits for the last frame. @returns everything the system said, with what it corrected at its end.
  Estimate Finish();

 private:
  void Run();
  void Join();
  void HandOver(Observation observation);

  std::unique_ptr<System> system_;
  BoundedQueue<Observation> queue_{8};  // some megabytes, whatever the length of the run
  std::optional<BoundedQueue<BodyCommand>> answers_;
  Estimate estimate_;
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace gaitcam
