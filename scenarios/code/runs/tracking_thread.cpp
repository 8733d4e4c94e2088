#include "scenarios/code/runs/tracking_thread.h"

#include <algorithm>
#include <chrono>
#include <map>

#include "algorithms/core/errors.h"
#include "scenarios/code/systems/foreign_words.h"

namespace gaitcam {

TrackingThread::TrackingThread(std::unique_ptr<System> system, bool acts) : system_(std::move(system)) {
  if (acts) answers_.emplace(1);
  thread_ = std::thread([this] { Run(); });
}

TrackingThread::~TrackingThread() { Join(); }

void TrackingThread::Run() {
  using Clock = std::chrono::steady_clock;
  try {
    while (const std::optional<Observation> observation = queue_.Pop()) {
      const Clock::time_point start = Clock::now();
      FrameEstimate frame = system_->Track(*observation);
      estimate_.track_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
      GAITCAM_ASSERT(frame.stamp_ns == observation->stamp_ns);
      GAITCAM_ASSERT(!frame.pose || (frame.pose->translation.allFinite() && frame.pose->rotation.coeffs().allFinite()));
      estimate_.frames.push_back(std::move(frame));
      if (answers_) answers_->Push(system_->Command());
    }
    const Clock::time_point finish = Clock::now();
    FinalEstimate last = system_->Finish();
    if (!last.saw_all_first) estimate_.live = estimate_.frames;
    std::map<int64_t, FrameEstimate> refined;
    for (FrameEstimate& frame : last.frames) refined[frame.stamp_ns] = std::move(frame);
    for (FrameEstimate& frame : estimate_.frames) {
      if (const auto better = refined.find(frame.stamp_ns); better != refined.end()) frame = better->second;
    }
    const double share_ms = std::chrono::duration<double, std::milli>(Clock::now() - finish).count() /
                            double(std::max<size_t>(1, estimate_.track_ms.size()));
    for (double& ms : estimate_.track_ms) ms += share_ms;  // Finish() works on all frames
    estimate_.maps = std::move(last.maps);
    estimate_.failure = ForeignWords(last.failure);
    estimate_.keyframes_only = last.keyframes_only;
    for (const std::string& remark : last.remarks) estimate_.remarks.push_back(ForeignWords(remark));
  } catch (...) {
    failure_ = std::current_exception();
    queue_.Close();
    if (answers_) answers_->Close();
  }
}

void TrackingThread::Push(Observation observation) {
  GAITCAM_ASSERT(!acts());  // answers that nobody takes would block the system
  HandOver(std::move(observation));
}

void TrackingThread::HandOver(Observation observation) {
  if (queue_.Push(std::move(observation))) return;
  Join();
  if (failure_) std::rethrow_exception(failure_);
}

BodyCommand TrackingThread::Ask(Observation observation) {
  GAITCAM_ASSERT(acts());
  HandOver(std::move(observation));
  const std::optional<BodyCommand> answer = answers_->Pop();
  if (answer) return *answer;
  Join();
  std::rethrow_exception(failure_);  // nothing else leaves a frame without an answer
}

Estimate TrackingThread::Finish() {
  Join();
  if (failure_) std::rethrow_exception(failure_);
  return std::move(estimate_);
}

void TrackingThread::Join() {
  queue_.Close();
  if (thread_.joinable()) thread_.join();
}

}  // namespace gaitcam
