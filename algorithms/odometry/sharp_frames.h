/// Which frames of a walk are sharp. Each step shakes the camera, and of the frames that it takes some are blurred less
/// than the others: these make the better keyframes.

#pragma once

#include <cstdint>
#include <deque>
#include <opencv2/core.hpp>
#include <optional>

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

/// Whether a walk blurs its images little. The share of detail that blur leaves is the median of 1.1 s of frames'
/// FineDetail over the most that one of them has, whatever they show: 0.8 on brisk walks with 2 to 3 px of blur, 0.6
/// with 7, 0.4 to 0.5 with 13 and more (KHR-1HV, 10 frames/s).
class ClearWalk {
 public:
  /// The next frame. @param detail FineDetail. @param has_map of landmarks: before, a camera may stand still
  /// @returns whether there has been a map for 1.1 s and the share rose above 0.74, and has not fallen below 0.62
  /// since.
  bool Add(int64_t stamp_ns, double detail, bool has_map);

 private:
  struct Frame {
    int64_t stamp_ns;
    double detail;
  };
  std::deque<Frame> frames_;             ///< With a map, of the last 1.1 s.
  std::optional<int64_t> map_since_ns_;  ///< Stamp of the first of them; nothing without a map.
  bool is_clear_ = false;
};

/// Fine detail that an image has, in grey values: the standard deviation of its Laplacian at a scale of 1 px. It falls
/// as the image is blurred, and otherwise depends on what is in view: for the comparison of successive frames.
/// @param image 8 bits, grey or BGR
double FineDetail(const cv::Mat& image);

}  // namespace gaitcam
