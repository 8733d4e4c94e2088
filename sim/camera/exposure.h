/// Motion blur by integrating the light that reaches the sensor while the shutter is open.
///
/// The shutter interval decides three things at once: which instants are rendered, how bright the image is, and how
/// noisy. Light is added in linear units; the sRGB decoding happens once per sub-frame, the camera's response once per
/// frame.

#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/frame_truth.h"
#include "algorithms/core/image.h"
#include "algorithms/core/random.h"
#include "sim/camera/blur_field.h"
#include "sim/camera/exposure_options.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/key_picture.h"
#include "sim/camera/lens.h"
#include "sim/camera/light.h"
#include "sim/camera/renderer.h"
#include "sim/camera/shutter.h"
#include "sim/world/world.h"

namespace gaitcam {

/// One exposed frame and everything that is true of it.
struct ExposedFrame {
  Image image;        ///< CV_8UC3 (BGR) or CV_8UC1 (grey), row 0 at the top, stamped at mid-exposure.
  FilmedTruth truth;  ///< Its stamp, camera, blur, sub-frames and pictures; not what belongs to the robot.
};

/// Which expensive parts of the truth to compute. Poses, sub-frames and path lengths are always there; the image does
/// not depend on this.
struct TruthOptions {
  using DescribedTag = void;
  bool sharp = true;
  bool depth = true;
  bool blur = true;
};

template <class Visitor>
void VisitFields(Visitor& visit, TruthOptions& o) {
  visit("sharp", o.sharp, Nested(),
        "the sharp twin of every frame; rendered plainly it costs camera.antialias + 1 renders");
  visit("depth", o.depth, Nested(), "depth at mid-exposure");
  visit("blur", o.blur, Nested(), "blur vectors at every pixel");
}

/// How a camera turns what it sees into an image.
struct FilmOptions {
  ExposureOptions exposure;
  int antialias =
      4;  ///< Samples of a pixel of a frame or a sharp twin at least, unless exposure.fixed_subframes is set.
  bool grey = false;         ///< Monochrome sensor.
  double softness_px = 0.5;  ///< Standard deviation of the lens's point spread.
  double light_level = 1;    ///< Of the scene (Scene::light).
};

/// What one exposure gathered, before it is developed. It owns all that developing needs.
struct LatentFrame {
  LatentFrame(const TruthOptions& wanted, RandomStream noise) : wanted(wanted), noise(noise) {}

  TruthOptions wanted;
  RandomStream noise;
  ExposedFrame frame;                       ///< Stamp, poses and sub-frames; pictures and blur are still missing.
  cv::Mat light;                            ///< CV_32FC3, where all sub-frames were rendered; else empty, and:
  std::vector<KeySlot> slots;               ///< which sub-frames each key picture serves,
  std::vector<KeyPicture> keys;             ///< these pictures but the middle one, in the order of their slots,
  std::vector<std::vector<float>> weights;  ///< and what each sub-frame weighs, by rows.
  std::vector<SceneInstant> instants;       ///< Of the sub-frames.
  std::vector<Eigen::Vector2d> shifts_px;   ///< Of the sub-frames' samples.
  SceneInstant middle;                      ///< Mid-exposure,
  std::optional<KeyPicture> middle_key;     ///< its key picture, unless none was made,
  double shape_cost = 0;                    ///< Of people in view, beside a picture's pixels (ShapeCost),
  cv::Mat depth, bodies;                    ///< what the camera then sees; no bodies where only the world is in view,
  cv::Mat sharp;                            ///< and the light of its sharp twin, if it was rendered.
  double luminance = 0;                     ///< Mean of the light, linear, 1 is display white at light level 1.
  std::optional<Amplification> amplification;                     ///< Of this frame; absent: by the options.
  std::optional<SeenPoints> points;                               ///< Points seen then,
  std::vector<SceneInstant> path;                                 ///< what they move by, from opening to close,
  std::vector<std::pair<SceneInstant, SceneInstant>> open_close;  ///< and opening and close of each band of rows.
};

/// One camera of a model that films through a shutter.
///
/// When a frame is exposed, physics has already run to the shutter's close, and its record gives every configuration
/// during the exposure. The sub-frames are therefore chosen with the motion known: the depth at mid-exposure gives the
/// visible points, and the fastest of these at each time divides the exposure into slots. Each sub-frame looks with
/// another sub-pixel offset, of mean zero, so that the sum is anti-aliased.
///
/// Plainly integrated, every sub-frame is rendered. Sheared, a few key pictures are, the first of them at mid-exposure,
/// and the sub-frames are computed from the nearest (key_picture.h). There are so many that none has to serve a
/// sub-frame from which any point has moved further than KeyCamera::reach_px, and that the error at depth edges stays
/// within bounds (occlusion.h). Where that many would cost more than to render plainly, that is done.
class ExposingCamera {
 public:
  /// @throws BadInput if the model has no such camera; BadOption.
  ExposingCamera(const mjModel* model, const std::string& camera_name, const CameraModel& camera,
                 const FilmOptions& options);

  /// Renders what one frame needs.
  /// @param stamp_ns mid-exposure; `record` covers the shutter's whole time (WholeShutter).
  /// @param noise the frame's own stream.
  LatentFrame Film(Renderer& renderer, const MotionRecord& record, int64_t stamp_ns, const TruthOptions& truth,
                   RandomStream noise);
  /// Makes the image and its truth. May run on another thread while Film() renders later frames.
  ExposedFrame Develop(LatentFrame latent) const;
  /// Both in one.
  ExposedFrame Expose(Renderer& renderer, const MotionRecord& record, int64_t stamp_ns, const TruthOptions& truth,
                      RandomStream noise) {
    return Develop(Film(renderer, record, stamp_ns, truth, noise));
  }

  /// True depth at one instant as a camera like this one sees it from X_CD beside it: CV_32FC1, m, 0 where nothing is.
  cv::Mat DepthFrom(Renderer& renderer, const MotionRecord& record, int64_t stamp_ns, const Pose& X_CD);

  /// Of the frames that are filmed from now on.
  void SetExposure(double exposure_ms) { options_.exposure.exposure_ms = exposure_ms; }
  const ImageSensor& sensor() const { return sensor_; }
  const Lens& lens() const { return *lens_; }

 private:
  SceneInstant At(const MotionRecord& record, int64_t stamp_ns);
  SceneInstant AtWithoutPeople(const MotionRecord& record, int64_t stamp_ns);
  void PosePeople(const MotionRecord& record, std::span<const int> seen, std::span<SceneInstant> instants) const;
  std::vector<SceneInstant> LookAround(const MotionRecord& record, const ShutterInterval& shutter);
  double ShapeCost(Renderer& renderer, const Pose& X_WC) const;
  std::optional<int> KeyDetail(const std::vector<SceneInstant>& looks, double shape_cost) const;

  cv::Mat Sharp(Renderer& renderer, const Pose& X_WC);
  cv::Mat Sharp(const KeyPicture& key) const;
  double LensVariance() const { return options_.softness_px * options_.softness_px; }
  cv::Mat SoftenSheared(const cv::Mat& light) const;
  void SeeMiddle(Renderer& renderer, const MotionRecord& record, const std::vector<SceneInstant>& looks,
                 LatentFrame& latent);
  int CountKeys(const LatentFrame& latent, const std::vector<SceneInstant>& looks, const ShutterPlan& plan,
                const MotionProfile& motion) const;

  void Collect(Renderer& renderer, const Eigen::Vector2d& shift_px, std::span<const float> row_weights,
               LightAccumulator& light);
  cv::Mat Integrate(Renderer& renderer, const MotionRecord& record, const ShutterPlan& plan, int64_t stamp_ns);
  void SeeKeys(Renderer& renderer, const MotionRecord& record, const ShutterPlan& plan, int keys, LatentFrame& latent);
  void TracePaths(const MotionRecord& record, std::span<const int> seen, LatentFrame& latent);

  cv::Mat Shear(LatentFrame& latent) const;
  void DescribeBlur(const LatentFrame& latent, FilmedTruth& truth) const;

  const mjModel* model_;
  int camera_id_;
  std::unique_ptr<const Lens> lens_;
  KeyCamera keys_;
  FilmOptions options_;
  ImageSensor sensor_;
  MjDataPtr data_;  ///< Scratch: the configuration being looked at.
  cv::Mat buffer_;  ///< The picture last read.
};

}  // namespace gaitcam
