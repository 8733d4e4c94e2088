/// The head camera of a scenario: one or two lenses, a shutter, optionally depth; its calibration and its frames.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "sim/camera/auto_exposure.h"
#include "sim/camera/depth_camera.h"
#include "sim/camera/exposure.h"
#include "sim/camera/jpeg.h"
#include "sim/camera/renderer.h"
#include "sim/camera/renderer_choice.h"
#include "sim/world/world.h"

namespace gaitcam {

struct LensOptions {
  using DescribedTag = void;
  double k1 = 0, k2 = 0, k3 = 0;
  double p1 = 0, p2 = 0;
  double cx_offset_px = 0, cy_offset_px = 0;
  double softness_px = 0.5;
};

template <class Visitor>
void VisitFields(Visitor& visit, LensOptions& o) {
  visit("k1", o.k1, Between(-2, 2), "radial distortion (algorithms/core/camera.h)");
  visit("k2", o.k2, Between(-5, 5), "radial distortion");
  visit("k3", o.k3, Between(-10, 10), "radial distortion");
  visit("p1", o.p1, Between(-0.1, 0.1), "tangential distortion");
  visit("p2", o.p2, Between(-0.1, 0.1), "tangential distortion");
  visit("cx_offset_px", o.cx_offset_px, Between(-1000, 1000), "principal point, right of the image's middle");
  visit("cy_offset_px", o.cy_offset_px, Between(-1000, 1000), "principal point, below the image's middle");
  visit("softness_px", o.softness_px, Between(0, 5), "standard deviation of the lens's point spread");
}

struct StereoOptions {
  using DescribedTag = void;
  double baseline_m = 0;
  Eigen::Vector3d right_rotation_deg{0, 0, 0};
};

template <class Visitor>
void VisitFields(Visitor& visit, StereoOptions& o) {
  visit("baseline_m", o.baseline_m, Between(0, 1),
        "the right camera stands so far to the right of the left one; 0 is mono");
  visit("right_rotation_deg", o.right_rotation_deg, Nested(),
        "of the right camera about the left one's x, y, z, in this order");
}

/// `cmos`: as small robots carry them.
enum class CameraPreset { kPlain, kCmos };
constexpr auto WordsOf(CameraPreset) {
  return std::array{EnumWord{CameraPreset::kPlain, "plain"}, EnumWord{CameraPreset::kCmos, "cmos"}};
}
/// A resolved scenario does not show the plain one.
inline bool SaysNothing(CameraPreset preset) { return preset == CameraPreset::kPlain; }

struct CameraOptions {
  using DescribedTag = void;
  using Preset = CameraPreset;
  Preset preset = Preset::kPlain;
  int width_px = 320;
  int height_px = 240;
  double hfov_deg = 60;
  double rate_hz = 30;
  double pitch_deg = 12;
  bool grey = false;
  bool depth = false;
  DepthModel depth_model = DepthModel::kIdeal;
  std::optional<DepthMountOptions> depth_mount;
  int antialias = 4;
  bool shadows = false;
  ExposureOptions exposure;  ///< In a scenario file these keys stand directly under `camera`.
  LensOptions lens;
  StereoOptions stereo;
  std::optional<AutoExposureOptions> auto_exposure;
  std::optional<JpegOptions> jpeg;
  RendererChoice renderer;

  static CameraOptions Of(Preset preset);
  /// Whether exposure and gain follow the light.
  bool ExposesItself() const { return auto_exposure && auto_exposure->enabled; }
  double LongestExposure_ms() const { return ExposesItself() ? auto_exposure->max_ms : exposure.exposure_ms; }
  /// Also checks combinations of fields. @throws BadOption naming field and value.
  void Check() const;
};

template <class Visitor>
void VisitFields(Visitor& visit, CameraOptions& o) {
  visit("preset", o.preset, EnumWords<CameraPreset>(),
        "what the other keys start from: plain; or cmos: a rolling shutter of 20 ms, barrel distortion, auto exposure");
  visit("width_px", o.width_px, Between(16, 4096), "image width");
  visit("height_px", o.height_px, Between(16, 4096), "image height");
  visit("hfov_deg", o.hfov_deg, Between(5, 150), "horizontal field of view, edge to edge, before distortion");
  visit("rate_hz", o.rate_hz, Between(0.1, 1000), "frames per second");
  visit("pitch_deg", o.pitch_deg, Between(-90, 90), "tilt of the mount, positive looks down");
  visit("grey", o.grey, Nested(), "monochrome sensor");
  visit("depth", o.depth, Nested(), "depth beside the left image, at mid-exposure");
  visit("depth_model", o.depth_model, EnumWords<DepthModel>(),
        "errors of the depth: ideal has none; as a Kinect's structured_light; as a time_of_flight camera's");
  visit("depth_mount", o.depth_mount, Nested(),
        "the depth camera has a place, a time and an error of registration of its own; absent: the left camera's");
  visit("antialias", o.antialias, Between(1, 64), "at least so many samples, spread over its square, make a pixel");
  visit("shadows", o.shadows, Nested(), "cast shadows; several times slower in software");
  VisitFields(visit, o.exposure);
  visit("lens", o.lens, Nested(), "distortion and principal point");
  visit("stereo", o.stereo, Nested(), "second camera");
  visit("auto_exposure", o.auto_exposure, Nested(), "exposure and gain follow the light; absent: they are fixed");
  visit("jpeg", o.jpeg, Nested(), "images are compressed, and the system gets what is decoded; absent: they are not");
  visit(
      "renderer", o.renderer, Nested(),
      "who renders: auto (the first GPU, else software), gpu, software, or device:N as `gaitcam doctor` numbers them; "
      "the environment variable GAITCAM_EGL overrides it");
}

/// A map of keys that differ from those of its `preset`. @throws BadInput, BadOption.
void ReadOption(const OptionValue& node, CameraOptions& value);

/// What a rig films in one frame.
struct RigFrame {
  ExposedFrame left;                  ///< Or the only camera.
  std::optional<ExposedFrame> right;  ///< Stereo rigs only; of its truth, poses and sub-frames.
  std::optional<Image> depth;         ///< CV_32FC1, m, of the left camera at the stamp of its own, as measured.
};

/// The same before it is developed.
struct LatentRigFrame {
  LatentFrame left;
  std::optional<LatentFrame> right;
  std::optional<RandomStream> depth_noise;  ///< Of a depth camera.
  cv::Mat own_depth;                        ///< True, of a depth camera with a place of its own.
  double exposure_ms = 0;                   ///< Of this frame.
};

class CameraRig {
 public:
  /// @param light_level of the scene (Scene::light). @throws BadOption.
  CameraRig(const CameraOptions& options, uint64_t seed, double light_level = 1);

  /// The cameras' part of a calibration; the IMU is left at its default.
  Calibration MakeCalibration() const;
  /// The cameras to put on the robot: "camera.left", and "camera.right" for a stereo rig.
  std::vector<WorldCamera> WorldCameras() const;
  RendererOptions MakeRendererOptions() const;

  /// Middle of the exposure of frame 0, 1, 2, ...; frame 0 opens its shutter at time 0.
  int64_t FrameStamp(int64_t frame) const;
  /// The time that the motion record must cover to expose a frame of this stamp.
  /// With auto exposure, of the frame that is filmed next.
  ShutterInterval Shutter(int64_t stamp_ns) const;

  /// Renders what frame number `frame` needs, at FrameStamp(frame). Its noise depends on the seed and this number
  /// alone; auto exposure on what was filmed before.
  /// @param record covers Shutter(FrameStamp(frame)). @param truth what to make for the left camera.
  LatentRigFrame Film(Renderer& renderer, const MotionRecord& record, int64_t frame, const TruthOptions& truth);
  /// Makes the images. May run on another thread while Film() renders later frames.
  RigFrame Develop(LatentRigFrame latent) const;
  /// Both in one.
  RigFrame Expose(Renderer& renderer, const MotionRecord& record, int64_t frame, const TruthOptions& truth) {
    return Develop(Film(renderer, record, frame, truth));
  }

  /// Begins anew: other noise of the frames that follow, auto exposure as at first.
  void Reseed(uint64_t seed);
  const CameraOptions& options() const { return options_; }

 private:
  CameraModel MakeCamera() const;
  Pose X_LR() const;
  int64_t DepthStamp(int64_t stamp_ns) const;
  Image MeasuredDepth(const LatentRigFrame& latent, const ExposedFrame& left) const;

  CameraOptions options_;
  ExposureOptions exposure_;  ///< Of the next frame.
  std::optional<AutoExposure> auto_exposure_;
  uint64_t seed_;
  double light_level_;
  std::optional<DepthMount> depth_mount_;
  std::vector<ExposingCamera> cameras_;  ///< Made when the first frame names the model.
};

}  // namespace gaitcam
