#include "scenarios/code/runs/run_log.h"

#include <fmt/format.h>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr size_t kMaxTwins = 16, kShownTwins = 8;

const char* Name(SupportPhase support) {
  switch (support) {
    case SupportPhase::kDouble: return "double";
    case SupportPhase::kLeft: return "left";
    case SupportPhase::kRight: return "right";
  }
  GAITCAM_ASSERT(false);
  return "";
}

}  // namespace

TruthOptions RunLog::WantedTruth(int64_t frame) const {
  return {.sharp = frame % twin_stride_ == 0, .depth = false, .blur = false};
}

void RunLog::Add(const SimulatedFrame& frame) {
  const FilmedTruth& truth = frame.truth;
  KeepTwin(frame);
  stamps_.push_back(truth.stamp_ns);
  truth_.push_back({truth.stamp_ns, truth.X_WC});
  entries_.push_back({truth, int(truth.subframes.size())});
}

void RunLog::KeepTwin(const SimulatedFrame& frame) {
  if (int64_t(frames()) % twin_stride_ != 0 || frame.truth.sharp.empty()) return;
  twins_.push_back({frame.truth.stamp_ns, frame.observation.image.pixels.clone(), frame.truth.sharp.clone(),
                    frame.truth.blur_median_px, frame.truth.blur_max_px});
  if (twins_.size() <= kMaxTwins) return;
  std::vector<ReportTwin> half;
  for (size_t i = 0; i < twins_.size(); i += 2) half.push_back(std::move(twins_[i]));
  twins_ = std::move(half);
  twin_stride_ *= 2;
}

std::vector<ReportTwin> RunLog::Twins() const {
  if (twins_.size() <= kShownTwins) return twins_;
  std::vector<ReportTwin> shown;
  for (size_t i = 0; i < kShownTwins; ++i) shown.push_back(twins_[i * (twins_.size() - 1) / (kShownTwins - 1)]);
  return shown;
}

std::vector<ReportFrame> RunLog::ReportFrames(const Estimate& estimate) const {
  GAITCAM_ASSERT(estimate.frames.size() == entries_.size());
  std::vector<ReportFrame> frames;
  for (size_t i = 0; i < entries_.size(); ++i) {
    ReportFrame frame{entries_[i].truth};
    frame.status = estimate.frames[i].status;
    frame.live = estimate.live.empty() ? frame.status : estimate.live[i].status;
    frame.restarted = estimate.frames[i].restarted;
    frame.features = estimate.frames[i].features;
    frame.inliers = estimate.frames[i].inliers;
    frames.push_back(frame);
  }
  return frames;
}

std::string RunLog::ToCsv(const Estimate& estimate) const {
  std::string csv =
      "stamp_ns,status,live_status,restarted,features,inliers,blur_median_px,blur_p90_px,blur_max_px,subframes,step,"
      "phase,support,"
      "left_contact,right_contact\n";
  const std::vector<ReportFrame> frames = ReportFrames(estimate);
  for (size_t i = 0; i < frames.size(); ++i) {
    const ReportFrame& f = frames[i];
    const GaitState gait = f.gait.value_or(GaitState());
    csv += fmt::format("{},{},{},{:d},{},{},{:.3f},{:.3f},{:.3f},{},{},{:.3f},{},{:d},{:d}\n", f.stamp_ns,
                       ToString(f.status), ToString(f.live), f.restarted, f.features, f.inliers, f.blur_median_px,
                       f.blur_p90_px, f.blur_max_px, entries_[i].subframes, gait.step, gait.phase, Name(gait.support),
                       f.left_contact, f.right_contact);
  }
  return csv;
}

}  // namespace gaitcam
