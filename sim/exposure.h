/// Motion blur by integrating what the camera sees while its shutter is open.
///
/// The shutter interval decides three things at once: which instants are rendered, how bright the image is, and how
/// noisy. Light is added in linear units; the sRGB decoding happens once per sub-frame, the camera's response once per
/// frame.

#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/image.h"
#include "algorithms/core/random.h"
#include "sim/blur_field.h"
#include "sim/exposure_options.h"
#include "sim/image_sensor.h"
#include "sim/lens.h"
#include "sim/light.h"
#include "sim/renderer.h"
#include "sim/shutter.h"
#include "sim/world.h"

namespace gaitcam {

/// One sub-frame: when, how much it counts, and where the camera was.
struct Subframe {
  int64_t stamp_ns = 0;
  double weight = 0;  ///< Sums to 1 over the frame (global shutter; per row for a rolling one).
  Pose X_WC;
};

/// What is true of a frame; never leaves the simulator's side.
struct ExposureTruth {
  Pose X_WC_open, X_WC, X_WC_close;  ///< At shutter open, middle and close (of the middle row).
  std::vector<Subframe> subframes;
  cv::Mat sharp;  ///< CV_8UC3: one instant at mid-exposure, same optics and response, no noise.
  cv::Mat depth;  ///< CV_32FC1, m along the optical axis at mid-exposure; 0 where nothing is.
  cv::Mat blur;   ///< CV_32FC2, px: how far the point seen here moved from open to close (net vector).
  double blur_median_px = 0, blur_p90_px = 0, blur_max_px = 0;  ///< Path lengths over the image.
};

/// One exposed frame and everything that is true of it.
struct ExposedFrame {
  Image image;  ///< CV_8UC3 (BGR) or CV_8UC1 (grey), row 0 at the top, stamped at mid-exposure.
  ExposureTruth truth;
};

/// Which costly pieces of truth to make. Poses, sub-frames and path lengths come always; the image is the same either
/// way.
struct TruthOptions {
  using DescribedTag = void;
  bool sharp = true;  ///< Costs as many renders as CameraOptions::antialias.
  bool depth = true;
  bool blur = true;  ///< Blur vectors at every pixel.
};

template <class Visitor>
void VisitFields(Visitor& visit, TruthOptions& o) {
  visit("sharp", o.sharp, Nested(), "the sharp twin of every frame");
  visit("depth", o.depth, Nested(), "depth at mid-exposure");
  visit("blur", o.blur, Nested(), "blur vectors at every pixel");
}

/// How a camera turns what it sees into an image.
struct FilmOptions {
  ExposureOptions exposure;
  int antialias = 4;  ///< Least number of renders in a frame or a sharp twin, unless exposure.fixed_subframes is set.
  bool grey = false;  ///< Monochrome sensor.
  double softness_px = 0.5;  ///< Standard deviation of the lens's point spread.
};

/// One camera of a model that films through a shutter.
///
/// When a frame is exposed, physics has already run to the shutter's close, and its record says exactly where
/// everything was at any instant of it. So the instants to render are chosen with the whole motion known: first the
/// picture at mid-exposure says what is seen and how far away it is, then the largest motion of any of these points
/// over time cuts the shutter's time into sub-frames. Each sub-frame looks a little beside the pixels' centres, another
/// way every time, with mean zero: the sum is anti-aliased for nothing.
class ExposingCamera {
 public:
  /// @throws BadInput if the model has no such camera; BadOption.
  ExposingCamera(const mjModel* model, const std::string& camera_name, const CameraModel& camera,
                 const FilmOptions& options);

  /// Films one frame.
  /// @param stamp_ns mid-exposure; `record` covers the shutter's whole time (WholeShutter).
  /// @param noise the frame's own stream.
  ExposedFrame Expose(Renderer& renderer, const MotionRecord& record, int64_t stamp_ns, const TruthOptions& truth,
                      RandomStream noise);

  const Lens& lens() const { return lens_; }

 private:
  struct Middle;

  SceneInstant At(const MotionRecord& record, int64_t stamp_ns);
  void Collect(Renderer& renderer, const Eigen::Vector2d& shift_px, std::span<const float> row_weights,
               LightAccumulator& light);
  cv::Mat Sharp(Renderer& renderer, const Pose& X_WC);
  Middle SeeMiddle(Renderer& renderer, const MotionRecord& record, int64_t stamp_ns, bool sharp);
  MotionProfile MeasureMotion(const MotionRecord& record, const ShutterInterval& shutter, const SeenPoints& points);
  cv::Mat Integrate(Renderer& renderer, const MotionRecord& record, const ShutterPlan& plan, ExposureTruth& truth,
                    std::vector<SceneInstant>& instants, int64_t stamp_ns);
  void DescribeBlur(const MotionRecord& record, int64_t stamp_ns, const Middle& middle,
                    const std::vector<SceneInstant>& instants, bool vectors, ExposureTruth& truth);

  const mjModel* model_;
  int camera_id_;
  Lens lens_;
  FilmOptions options_;
  ImageSensor sensor_;
  MjDataPtr data_;  ///< Scratch: the configuration being looked at.
  cv::Mat buffer_;  ///< The picture last read.
};

}  // namespace gaitcam
