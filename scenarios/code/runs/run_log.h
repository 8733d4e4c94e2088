/// What a run leaves behind frame by frame: true poses, blur, gait, and a few pictures. Grows by some 700 bytes
/// a frame.

#pragma once

#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/trajectory.h"
#include "results/reports/report.h"
#include "sim/simulation.h"

namespace gaitcam {

class RunLog {
 public:
  /// What the n-th frame's truth must hold, from 0: pictures cost time and are kept of few frames. Frames up to seven
  /// before it need not have been added yet.
  TruthOptions WantedTruth(int64_t frame) const;
  void Add(const SimulatedFrame& frame);

  const Trajectory& truth() const { return truth_; }
  const std::vector<int64_t>& stamps() const { return stamps_; }
  size_t frames() const { return stamps_.size(); }

  /// Per frame, what the report plots: truth joined with what the system said.
  std::vector<ReportFrame> ReportFrames(const Estimate& estimate) const;
  /// At most eight blurred and sharp twins, evenly over the run.
  std::vector<ReportTwin> Twins() const;
  /// frames.csv: one line per frame with a header that names units.
  std::string ToCsv(const Estimate& estimate) const;

 private:
  struct Entry {
    FrameTruth truth;
    int subframes = 0;
  };

  void KeepTwin(const SimulatedFrame& frame);

  Trajectory truth_;
  std::vector<int64_t> stamps_;
  std::vector<Entry> entries_;
  std::vector<ReportTwin> twins_;  ///< At most sixteen: when full, every second one goes and the stride doubles.
  int64_t twin_stride_ = 8;
};

}  // namespace gaitcam
