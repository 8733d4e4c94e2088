#include "scenarios/code/experiments/rendered_stereo.h"

#include <array>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/features/features.h"
#include "algorithms/features/matching.h"
#include "models/code/robots/robot.h"
#include "models/code/scenes/scene.h"
#include "scenarios/code/files/folders.h"
#include "sim/camera/egl_context.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/light.h"
#include "sim/camera/renderer.h"
#include "sim/world/world.h"

namespace gaitcam {
namespace {

constexpr int kMinInliers = 12;
constexpr int kFeatures = 1500;
constexpr double kMatched_px = 0.7;  // what RANSAC takes for a match's standard deviation

/// Sharp pictures of a room, with a sensor's noise.
class Room {
 public:
  explicit Room(const std::string& scene)
      : world_(ReadRobot("khr1hv", ModelsFolder()), ReadScene(scene, ModelsFolder()), {}, {}, 0),
        renderer_(world_.model(), {}, world_.pictures()),
        sensor_(Shutter(), true) {}

  cv::Mat Film(const Pose& X_WC, const CameraModel& camera, const RandomStream& noise) {
    constexpr int kFiner = 3;
    const cv::Mat bgr = renderer_.Picture(*world_.data(), X_WC, camera, kFiner);
    cv::Mat table(1, 256, CV_32FC1), light;
    for (int i = 0; i < 256; ++i) table.at<float>(i) = float(SrgbToLinear(i / 255.0));
    cv::LUT(bgr, table, light);
    return sensor_.Develop(light, noise);
  }

 private:
  static ExposureOptions Shutter() {
    ExposureOptions exposure;
    exposure.exposure_ms = 10;
    return exposure;
  }

  EglContext gl_;
  World world_;
  Renderer renderer_;
  ImageSensor sensor_;
};

/// One index into the features of each of the four images: left and right of A, left and right of B.
using FourIndices = std::array<int, 4>;

/// Matches that close a circle: left A, right A, right B, left B, and back.
std::vector<FourIndices> MatchFour(const std::array<Features, 4>& images) {
  const auto match = [&](int a, int b) {
    std::map<int, int> pairs;
    for (const Match& m : MatchDescriptors(images[size_t(a)].descriptors, images[size_t(b)].descriptors, {}))
      pairs[m.a] = m.b;
    return pairs;
  };
  const auto left_right_A = match(0, 1), right_A_B = match(1, 3), right_left_B = match(3, 2), left_B_A = match(2, 0);
  std::vector<FourIndices> circles;
  for (const auto& [left_A, right_A] : left_right_A) {
    const auto right_B = right_A_B.find(right_A);
    if (right_B == right_A_B.end()) continue;
    const auto left_B = right_left_B.find(right_B->second);
    if (left_B == right_left_B.end()) continue;
    const auto back = left_B_A.find(left_B->second);
    if (back != left_B_A.end() && back->second == left_A)
      circles.push_back({left_A, right_A, left_B->second, right_B->second});
  }
  return circles;
}

StereoSighting SightingOf(const cv::KeyPoint& left, const cv::KeyPoint& right) {
  StereoSighting sighting;
  sighting.left = {left.pt.x, left.pt.y};
  sighting.right = {right.pt.x, right.pt.y};
  const double scale_left = left.size / 2, scale_right = right.size / 2;  // OpenCV's size is twice SIFT's scale, px
  sighting.covariance_left = scale_left * scale_left * Eigen::Matrix2d::Identity();
  sighting.covariance_right = scale_right * scale_right * Eigen::Matrix2d::Identity();
  return sighting;
}

/// Those of the sightings that RANSAC takes for one motion.
SceneSightings Inliers(const SceneSightings& all, RandomStream& random) {
  const auto with_sigma = [](StereoSighting sighting) {
    sighting.covariance_left = sighting.covariance_right = kMatched_px * kMatched_px * Eigen::Matrix2d::Identity();
    return sighting;
  };
  constexpr double kMeets = 9;  // three standard deviations from the epipolar line
  std::vector<PointMatch> matches;
  std::vector<int> of_match;
  for (int k = 0; k < all.size(); ++k) {
    const StereoPoint a = ReconstructPoint(all.rig, with_sigma(all.A[size_t(k)]));
    const StereoPoint b = ReconstructPoint(all.rig, with_sigma(all.B[size_t(k)]));
    if (!a.ok() || !b.ok() || a.squared_error > kMeets || b.squared_error > kMeets) continue;
    matches.push_back({a.p_L, b.p_L, a.covariance, b.covariance});
    of_match.push_back(k);
  }
  SceneSightings inliers{all.rig, all.X_AB, {}, {}};
  for (const int i : EstimateRigidMotion(matches, {}, random).inliers) {
    inliers.A.push_back(all.A[size_t(of_match[size_t(i)])]);
    inliers.B.push_back(all.B[size_t(of_match[size_t(i)])]);
  }
  return inliers;
}

/// Somewhere in the room's free ring, looking about level in any direction.
Pose DrawPlace(RandomStream& random) {
  const double around = random.Uniform(0, 2 * std::numbers::pi), radius_m = random.Uniform(1.9, 2.4);
  const Pose X_WB(RotZ(random.Uniform(0, 2 * std::numbers::pi)),
                  {radius_m * std::cos(around), radius_m * std::sin(around), random.Uniform(0.4, 1.0)});
  Eigen::Matrix3d R_BC;  // x right, y down, z forward
  R_BC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return X_WB * Pose(R_BC, {0, 0, 0});
}

RenderedStep RenderStep(Room& room, const StereoRig& rig, uint64_t seed, int attempt) {
  RandomStream random(seed, "rendered_step." + std::to_string(attempt));
  const Pose X_WA = DrawPlace(random);
  const auto normal3 = [&] { return Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()); };
  const Pose X_AB(ExpSo3(0.02 * normal3()), 0.04 * normal3());
  std::array<Features, 4> features;
  const auto sift = MakeFeature2d("sift");
  for (int k = 0; k < 4; ++k) {
    const Pose X_WL = k < 2 ? X_WA : X_WA * X_AB;
    const bool right = k % 2 == 1;
    const RandomStream noise(seed, "rendered_step.noise." + std::to_string(4 * attempt + k));
    features[size_t(k)] = DetectFeatures(
        *sift, room.Film(right ? X_WL * rig.X_LR : X_WL, right ? rig.right : rig.left, noise), kFeatures);
  }
  SceneSightings all{rig, X_AB, {}, {}};
  for (const FourIndices& i : MatchFour(features)) {
    const auto keypoint = [&](int image) { return features[size_t(image)].keypoints[size_t(i[size_t(image)])]; };
    all.A.push_back(SightingOf(keypoint(0), keypoint(1)));
    all.B.push_back(SightingOf(keypoint(2), keypoint(3)));
  }
  return {Inliers(all, random), all.size()};
}

}  // namespace

std::vector<RenderedStep> RenderSteps(const std::string& scene, const StereoRig& rig, int steps, int max_points,
                                      uint64_t seed) {
  Room room(scene);
  std::vector<RenderedStep> result;
  const int max_attempts = 20 * steps;
  for (int attempt = 0; int(result.size()) < steps; ++attempt) {
    if (attempt == max_attempts)
      throw TooLittleData("scene " + scene + ": views with " + std::to_string(kMinInliers) + " matches are too rare");
    RenderedStep step = RenderStep(room, rig, seed, attempt);
    if (step.sightings.size() < kMinInliers) continue;
    // Every so many, so that near and far are kept as they come.
    SceneSightings& s = step.sightings;
    const int stride = (s.size() + max_points - 1) / max_points;
    SceneSightings kept{s.rig, s.X_AB, {}, {}};
    for (int k = 0; k < s.size(); k += stride) {
      kept.A.push_back(s.A[size_t(k)]);
      kept.B.push_back(s.B[size_t(k)]);
    }
    s = kept;
    result.push_back(step);
  }
  return result;
}

}  // namespace gaitcam
