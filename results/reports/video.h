/// The video of a run: the robot's camera beside a third-person view, as an MP4 that browsers play.

#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

namespace gaitcam {

struct VideoOptions {
  double frame_rate_hz = 30;  ///< > 0; of playing. Equal to the rate of Add it plays in real time.
  int height_px = 360;        ///< Of both views; widths follow from their shapes. Even, at least 64.
};

/// One picture of the film. Views are CV_8UC3 (BGR) or CV_8UC1.
struct VideoFrame {
  cv::Mat camera;          ///< The frame given to the SLAM system.
  cv::Mat bystander;       ///< Third-person view; empty: the camera's view stands alone.
  double time_s = 0;       ///< Since the run's begin.
  double exposure_ms = 0;  ///< 0: nothing is said of it.
  std::string status;      ///< A word or two, such as "tracking, 213 inliers"; ASCII.
  bool alarm = false;      ///< Status in a warning colour: lost, fallen.
};

/// Writes H.264 (yuv420p) under a temporary name beside `path`; the file takes its own name in Finish(). The same
/// frames give the same bytes.
///
/// Frames are encoded on a thread of the writer's own: their pixels must not be altered after they were added.
/// Without Finish() (an exception on the way) the temporary file is removed. All frames must have views of the same
/// size.
class VideoWriter {
 public:
  /// @throws BadInput for options out of range. Nothing is written yet.
  explicit VideoWriter(std::filesystem::path path, VideoOptions options = {});
  ~VideoWriter();
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) noexcept;

  /// @throws MissingResource if this machine's FFmpeg cannot encode H.264 or the file cannot be written.
  void Add(const VideoFrame& frame);
  /// Completes the file. Without any frame there is no file, and no error.
  void Finish();
  int frames() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Both views at one height side by side above a caption bar, even in width and height. CV_8UC3.
cv::Mat ComposeVideoFrame(const VideoFrame& frame, int height_px);

}  // namespace gaitcam
