/// Monocular visual odometry over keyframes: a map of inverse-depth landmarks, refined by bundle adjustment over the
/// latest keyframes, against which every frame is localised.
///
/// Composed of
/// - MapInitializer: the first two keyframes (thesis 5.4, steps 2 to 5);
/// - MeanVelocity: where the camera will be, but for its swaying;
/// - ShutterTurn: rolling-shutter correction, where a key point was at the frame's stamp;
/// - LandmarkLocalizer: a frame's pose from landmarks near a prediction, or anywhere (relocalisation);
/// - KeyframePolicy: which frame becomes a keyframe, of those that SharpFrames takes for sharp;
/// - KeyframeMap: landmarks, keyframes, windowed bundle adjustment;
/// - FloorPrior: depths of what lies on the floor, which keeps the scale;
/// - MetricScale: the map's unit in metres, by the camera's height over the floor;
/// - FrameRecords: the final estimate, in which frames move along with their keyframes;
/// - FusedRotations: rotations by image and gyroscope together, where that is asked for.
///
/// What it adds to the thesis's odometry (two_view_vo.h): a walking camera at 30 Hz moves by millimetres between
/// frames, which leaves the direction of motion to noise; landmarks that live over many keyframes have a baseline.
///
/// No loop closure, and no motion model but a camera that goes on about as it did. The world frame W is the reference
/// frame's of the first map. A later map begins where the one before was lost, turned since as the gyroscope says, if
/// it is read (shutter_by_imu, use_imu, blur_by_imu). The map's own unit is the median depth there. Where the
/// calibration says how high the camera stands, poses are handed over in metres nevertheless: each motion is multiplied
/// by what is known of the unit by then, so that a better estimate of it makes no jump.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/odometry/frame_view.h"
#include "algorithms/odometry/keyframe_policy.h"
#include "algorithms/odometry/landmark_localizer.h"
#include "algorithms/odometry/map_initializer.h"

namespace gaitcam {

/// When the saddle points of a detector that has them are features.
enum class SaddleTime {
  kClear,   ///< As further ones, while the walk hardly blurs its images (ClearWalk).
  kAlways,  ///< As blobs are, by their strength.
  kNever,
};
constexpr auto WordsOf(SaddleTime) {
  return std::array{EnumWord{SaddleTime::kClear, "clear"}, EnumWord{SaddleTime::kAlways, "always"},
                    EnumWord{SaddleTime::kNever, "never"}};
}

struct KeyframeVoOptions {
  using DescribedTag = void;

  std::string feature = "mobif";  ///< Detector by name (algorithms/features/features.h).
  /// Strongest features kept per frame; 0: 800 of 320 x 240 px and less, of larger images more in proportion to their
  /// area (results/studies/odometry_resolution: 800 of 640 x 480 px are too few).
  int max_features = 0;
  /// The detector's own threshold is divided by this. Blur and dim light take contrast; where there are more points
  /// than are kept, the strongest are taken in any case.
  double sensitivity = 100;

  // The fields of these are fields of these options.
  MapInitializerOptions initializer;
  LandmarkLocalizerOptions localizer;
  KeyframePolicyOptions policy;

  int window = 8;              ///< Keyframes refined together by bundle adjustment.
  int adjust_iterations = 10;  ///< Largest number of iterations of one bundle adjustment.
  int memory = 20;             ///< Keyframes after which a landmark that was not seen again is removed.
  bool use_floor = true;       ///< FloorPrior.
  /// Each frame's rotation by its image and the gyroscope together (FusedRotations), whose bias is learned; with it
  /// landmarks are searched for and the position is found. Without a gyroscope nothing changes.
  bool use_imu = false;
  /// Of MoBIF. At 10 frames/s a map is better with them where images are hardly blurred, and worse from 8 px of blur on
  /// (results/studies/saddle_points); at 30 frames/s kAlways is better than kClear up to 6 px, the most that was tried
  /// (results/studies/exposure). As further features they are kept beyond max_features, 44 % of it at most.
  SaddleTime saddles = SaddleTime::kClear;
  /// A detector that accounts for blur takes images with less as they are; 0: its own limit. BadOption where it has
  /// none.
  double min_blur_px = 0;
  /// Tell a detector that accounts for blur how the light moved during the exposure, by the gyroscope (InertialPsf): by
  /// rotation alone, its bias as learned. Frames whose exposure it did not measure whole are left to the detector's own
  /// estimate. Needs a gyroscope, a global shutter and such a detector (BadOption).
  bool blur_by_imu = false;
  /// Correct a rolling shutter by the gyroscope (ShutterTurn), where the shutter rolls and there is one. Frames that it
  /// did not measure stay as they are.
  /// Where this, use_imu or blur_by_imu reads a gyroscope, no map begins with a single frame's motion that contradicts
  /// it (MapInitializer).
  bool shutter_by_imu = true;
  bool metric = true;  ///< MetricScale, where the calibration says how high the camera stands.
  /// Frames before a map get predictions as if the camera only turned.
  bool rotation_before_map = false;
  int max_lost_frames = 15;  ///< Frames without a pose after which the map is given up and another initialised.

  /// The defaults with another detector.
  static KeyframeVoOptions WithFeature(const std::string& feature, double sensitivity);
};

template <class Visitor>
void VisitFields(Visitor& visit, KeyframeVoOptions& o) {
  visit("feature", o.feature, FeatureNames(), "detector and descriptor");
  visit("max_features", o.max_features, Between(0, 100000),
        "strongest features kept per frame; 0: 800 of 320 x 240 px, of larger images more, by their area");
  visit("sensitivity", o.sensitivity, Between(0.01, 1000.0),
        "the detector's threshold is divided by this; orb does better with 4");
  VisitFields(visit, o.initializer);
  VisitFields(visit, o.localizer);
  VisitFields(visit, o.policy);
  visit("window", o.window, Between(2, 1000), "keyframes refined together by bundle adjustment");
  visit("adjust_iterations", o.adjust_iterations, Between(1, 1000), "largest number of iterations of an adjustment");
  visit("memory", o.memory, Between(1, 100000), "keyframes until an unseen landmark is removed");
  visit("use_floor", o.use_floor, Nested(), "depths and scale by the camera's height over the floor");
  visit("use_imu", o.use_imu, Nested(), "rotations by image and gyroscope together");
  visit(
      "saddles", o.saddles, Nested(),
      "when MoBIF's saddle points are features: as further ones while images are hardly blurred, as blobs are, never");
  visit("min_blur_px", o.min_blur_px, AtLeast(0),
        "a detector that accounts for blur takes images with less as they are; 0: its own limit");
  visit("blur_by_imu", o.blur_by_imu, Nested(),
        "a detector that accounts for blur is told of it by the gyroscope; needs a global shutter");
  visit("shutter_by_imu", o.shutter_by_imu, Nested(), "correct a rolling shutter by the gyroscope, where there is one");
  visit("metric", o.metric, Nested(), "poses in metres by the height at which the camera stands, where that is known");
  visit("rotation_before_map", o.rotation_before_map, Nested(),
        "frames before a map get predictions that turn without moving");
  visit("max_lost_frames", o.max_lost_frames, Between(0, 1000000), "frames without a pose until a new map");
}

class KeyframeVo {
 public:
  /// @throws BadOption if the camera or an option is out of range.
  KeyframeVo(const Calibration& calibration, const KeyframeVoOptions& options, uint64_t seed);
  ~KeyframeVo();

  /// Answers one frame. An image without texture, or unlike all before it, is an answer without a pose, never an error:
  /// "initializing" while there is no map, "lost" where there is one, then with the last known pose as `predicted`.
  /// `restarted` marks the first pose in a new map: that map starts at the last known pose, with the last known median
  /// depth as its unit, which are assumptions. It marks, too, a pose beyond what `usual_speed` makes likely, accepted
  /// because many landmarks agree.
  /// @throws BadInput if the image's size is not the camera's.
  FrameEstimate Track(const Observation& observation);

  /// The final estimate of every frame, by the refined keyframes. Frames that waited for a map to be initialised have
  /// poses in it; the first of them then is the one marked `restarted`.
  std::vector<FrameEstimate> Finish() const;

 private:
  class Tracker;
  std::unique_ptr<Tracker> tracker_;
};

}  // namespace gaitcam
