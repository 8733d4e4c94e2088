#include "sim/camera/camera_rig.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/option_reader.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

const char* const kNames[] = {"camera.left", "camera.right"};

}  // namespace

void CameraOptions::Check() const {
  CheckFields(*this, "camera.");
  const double period_ms = 1000 / rate_hz;
  for (const auto& [name, value] :
       {std::pair("exposure_ms", exposure.exposure_ms), {"readout_ms", exposure.readout_ms}}) {
    if (value > period_ms) {
      throw BadOption(std::string("camera.") + name + ": " + internal::NumberText(value) +
                      " is not permitted; expected at most the frame period of " + internal::NumberText(period_ms) +
                      " ms (camera.rate_hz: " + internal::NumberText(rate_hz) + ")");
    }
  }
  if (ExposesItself()) {
    auto_exposure->Check();
    if (auto_exposure->max_ms > period_ms) {
      throw BadOption("camera.auto_exposure.max_ms: " + internal::NumberText(auto_exposure->max_ms) +
                      " is not permitted; expected at most the frame period of " + internal::NumberText(period_ms) +
                      " ms (camera.rate_hz: " + internal::NumberText(rate_hz) + ")");
    }
  }
  if (depth_model != DepthModel::kIdeal && !depth) {
    throw BadOption("camera.depth_model: " + std::string(ToWord(depth_model)) +
                    " has no depth camera to go with; expected camera.depth: true beside it");
  }
  if (depth_mount && !depth) {
    throw BadOption("camera.depth_mount: there is no depth camera to mount; expected camera.depth: true beside it");
  }
  if (depth_mount) CheckFields(*depth_mount, "camera.depth_mount.");
  if (jpeg) CheckFields(*jpeg, "camera.jpeg.");
  if (exposure.max_subframes < exposure.min_subframes) {
    throw BadOption("camera.max_subframes: " + std::to_string(exposure.max_subframes) +
                    " is not permitted; expected at least camera.min_subframes, " +
                    std::to_string(exposure.min_subframes));
  }
  if (!stereo.right_rotation_deg.allFinite())
    throw BadOption("camera.stereo.right_rotation_deg: expected finite numbers");
}

CameraOptions CameraOptions::Of(Preset preset) {
  CameraOptions o;
  o.preset = preset;
  if (preset == Preset::kPlain) return o;
  o.exposure.readout_ms = 20;
  o.lens.k1 = -0.15;  // 7 % at the corners of 60 degrees
  o.lens.k2 = 0.03;
  o.auto_exposure.emplace();
  return o;
}

void ReadOption(const OptionValue& node, CameraOptions& value) {
  if (node.IsMap() && node.Has("preset")) {
    ReadOption(node.Child("preset"), value.preset);
    value = CameraOptions::Of(value.preset);
  }
  ReadFields(node, value);
}

CameraRig::CameraRig(const CameraOptions& options, uint64_t seed, double light_level)
    : options_(options), seed_(seed), light_level_(light_level) {
  options.Check();
  if (options.depth_mount)
    depth_mount_ = DepthMount::Of(*options.depth_mount, RandomStream(seed, "camera.depth_mount"));
  Reseed(seed);
  const Lens lens(MakeCamera());  // says now what is wrong with a distortion
}

CameraModel CameraRig::MakeCamera() const {
  CameraModel camera = CameraModel::FromHorizontalFov(options_.width_px, options_.height_px, options_.hfov_deg);
  camera.cx += options_.lens.cx_offset_px;
  camera.cy += options_.lens.cy_offset_px;
  camera.k1 = options_.lens.k1;
  camera.k2 = options_.lens.k2;
  camera.k3 = options_.lens.k3;
  camera.p1 = options_.lens.p1;
  camera.p2 = options_.lens.p2;
  return camera;
}

Pose CameraRig::X_LR() const {
  const Eigen::Vector3d angles = kRadPerDeg * options_.stereo.right_rotation_deg;
  const Eigen::Matrix3d R = RotZ(angles.z()) * RotY(angles.y()) * RotX(angles.x());
  return {R, Eigen::Vector3d(options_.stereo.baseline_m, 0, 0)};
}

Calibration CameraRig::MakeCalibration() const {
  Calibration calibration;
  calibration.camera = MakeCamera();
  if (options_.stereo.baseline_m > 0) {
    calibration.right = MakeCamera();
    calibration.X_LR = X_LR();
  }
  calibration.has_depth = options_.depth;
  calibration.depth = DepthDataSheet(options_.depth_model);
  calibration.frame_rate_hz = options_.rate_hz;
  calibration.readout_ms = options_.exposure.readout_ms;
  return calibration;
}

std::vector<WorldCamera> CameraRig::WorldCameras() const {
  // Looking down turns z, forward, towards y, down: a negative angle about x, right.
  const Pose X_ML(RotX(-kRadPerDeg * options_.pitch_deg), Eigen::Vector3d::Zero());
  std::vector<WorldCamera> cameras = {{kNames[0], X_ML}};
  if (options_.stereo.baseline_m > 0) cameras.push_back({kNames[1], X_ML * X_LR()});
  return cameras;
}

RendererOptions CameraRig::MakeRendererOptions() const {
  RendererOptions options;
  options.shadows = options_.shadows;
  return options;
}

void CameraRig::Reseed(uint64_t seed) {
  seed_ = seed;
  exposure_ = options_.exposure;
  if (!options_.ExposesItself()) return;
  auto_exposure_.emplace(*options_.auto_exposure, exposure_.exposure_ms, exposure_.reference_exposure_ms);
  exposure_.exposure_ms = auto_exposure_->exposure_ms();
}

int64_t CameraRig::FrameStamp(int64_t frame) const {
  ExposureOptions longest = options_.exposure;
  longest.exposure_ms = options_.LongestExposure_ms();
  const int64_t first = -WholeShutter(longest, 0).open_ns;
  return first + int64_t(std::llround(double(frame) * 1e9 / options_.rate_hz));
}

int64_t CameraRig::DepthStamp(int64_t stamp_ns) const {
  return options_.depth_mount ? stamp_ns + int64_t(std::llround(1e6 * options_.depth_mount->late_ms)) : stamp_ns;
}

ShutterInterval CameraRig::Shutter(int64_t stamp_ns) const {
  const ShutterInterval light = WholeShutter(exposure_, stamp_ns);
  return {light.open_ns, std::max(light.close_ns, DepthStamp(stamp_ns))};
}

LatentRigFrame CameraRig::Film(Renderer& renderer, const MotionRecord& record, int64_t frame,
                               const TruthOptions& truth) {
  if (cameras_.empty()) {
    const FilmOptions film{options_.exposure, options_.antialias, options_.grey, options_.lens.softness_px,
                           light_level_};
    for (const WorldCamera& camera : WorldCameras()) {
      cameras_.emplace_back(renderer.model(), camera.name, MakeCamera(), film);
    }
  }
  for (ExposingCamera& camera : cameras_) camera.SetExposure(exposure_.exposure_ms);
  const int64_t stamp_ns = FrameStamp(frame);
  const auto noise = [&](size_t i) { return RandomStream(seed_, kNames[i] + ("." + std::to_string(frame))); };
  TruthOptions wanted = truth;
  wanted.depth |= options_.depth;
  LatentRigFrame latent{cameras_[0].Film(renderer, record, stamp_ns, wanted, noise(0)),
                        std::nullopt,
                        std::nullopt,
                        {},
                        exposure_.exposure_ms};
  if (depth_mount_)
    latent.own_depth = cameras_[0].DepthFrom(renderer, record, DepthStamp(stamp_ns), depth_mount_->X_LD);
  if (options_.depth) latent.depth_noise.emplace(seed_, "camera.depth." + std::to_string(frame));
  constexpr TruthOptions kPosesOnly{false, false, false};
  if (cameras_.size() > 1) latent.right = cameras_[1].Film(renderer, record, stamp_ns, kPosesOnly, noise(1));
  if (auto_exposure_) {
    const Amplification now = cameras_[0].sensor().AmplificationAt(exposure_.exposure_ms, auto_exposure_->gain());
    latent.left.amplification = now;
    if (latent.right) latent.right->amplification = now;
    auto_exposure_->Measure(light_level_ * latent.left.luminance);
    exposure_.exposure_ms = auto_exposure_->exposure_ms();
  }
  return latent;
}

Image CameraRig::MeasuredDepth(const LatentRigFrame& latent, const ExposedFrame& left) const {
  const cv::Mat& rays = cameras_[0].lens().rays();
  const cv::Mat& seen = depth_mount_ ? latent.own_depth : left.truth.depth;
  cv::Mat depth = MeasureDepth(options_.depth_model, seen, rays, left.image.pixels, *latent.depth_noise);
  if (depth_mount_) depth = RegisterDepth(depth, rays, cameras_[0].lens().camera(), depth_mount_->X_LD_believed);
  return {DepthStamp(left.image.stamp_ns), depth};
}

RigFrame CameraRig::Develop(LatentRigFrame latent) const {
  RigFrame result;
  result.left = cameras_[0].Develop(std::move(latent.left));
  if (options_.depth) result.depth = MeasuredDepth(latent, result.left);
  if (latent.right) result.right = cameras_[1].Develop(std::move(*latent.right));
  if (options_.jpeg) {
    result.left.image.pixels = ThroughJpeg(result.left.image.pixels, *options_.jpeg);
    if (result.right) result.right->image.pixels = ThroughJpeg(result.right->image.pixels, *options_.jpeg);
  }
  return result;
}

}  // namespace gaitcam
