/// Which frames of a walk are sharp. Each step shakes the camera, and of the frames that it takes some are blurred less
/// than the others: these make the better keyframes.

#pragma once

#include <deque>
#include <opencv2/core.hpp>

namespace gaitcam {

class SharpFrames {
 public:
  /// @param alike part of a frame's blur by which another's must be smaller for that one to count as sharper
  explicit SharpFrames(double alike) : alike_(alike) {}

  /// The next frame. @param blur any measure that grows with it
  /// @returns whether it is among the sharper third of the last twelve, which is about a step at 30 frames/s.
  bool Add(double blur);

 private:
  double alike_;
  std::deque<double> blurs_;
};

/// Fine detail that an image has, in grey values: the standard deviation of its Laplacian at a scale of 1 px. It falls
/// as the image is blurred, and otherwise depends on what is in view: for the comparison of successive frames.
/// @param image 8 bits, grey or BGR
double FineDetail(const cv::Mat& image);

}  // namespace gaitcam
