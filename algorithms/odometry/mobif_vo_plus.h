/// Monocular visual odometry for a camera that shakes: keyframes, points that live over many views as inverse depths,
/// and windowed bundle adjustment over blur-robust features.
///
/// What it adds to the thesis's seven steps (section 5.4; two_view_vo.h): a frame is placed by all points that
/// the last keyframes saw, not by the frame before it; a feature constrains rotation from the moment it is first seen,
/// its depth unknown, so that turning on the spot and standing still need no special case; the depths' uncertainty
/// weighs every pose; and bundle adjustment over the last keyframes keeps scale from drifting.
///
/// The world frame W is the first frame's camera frame; its unit is the median depth when the map began.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/odometry/landmark_localizer.h"

namespace gaitcam {

struct MobifVoPlusOptions {
  using DescribedTag = void;

  std::string feature = "mobif";       ///< Detector by name (algorithms/features/features.h).
  int max_features = 800;              ///< Strongest features kept per frame.
  double sensitivity = 4;              ///< The detector's threshold is divided by this.
  double ratio = 0.8;                  ///< Nearest over second nearest descriptor distance.
  LandmarkLocalizerOptions landmarks;  ///< How a frame is placed by them. Its fields are fields of these options.
  int max_lost_frames = 30;            ///< After so many frames without a pose the map is given up and begun anew.

  double start_parallax_deg = 1.0;   ///< Median angle between the rays of the two frames that start a map ...
  double start_direction_deg = 0.5;  ///< ... and the largest standard deviation of their baseline's direction.
  int min_start_points = 40;         ///< Points that a new map needs.

  double keyframe_parallax_deg = 2.0;  ///< Median angle at the points that makes a frame a keyframe ...
  double keyframe_turn_deg = 12.0;     ///< ... or a turn by so much ...
  double keyframe_overlap = 0.6;       ///< ... or fewer points than this part of the last keyframe's.
  int max_wait_frames = 10;            ///< A due keyframe waits at most so long for a frame that sees well.
  int window = 12;                     ///< Keyframes refined together.
  int memory = 20;                     ///< Keyframes after which a point that was not seen again is forgotten.
  int adjust_iterations = 20;          ///< Most steps of one bundle adjustment.
  bool use_floor = true;               ///< Keep the scale by the camera's height over the floor, where it is seen.
  bool use_imu = false;                ///< Predict each frame's turn by the gyroscope.
};

template <class Visitor>
void VisitFields(Visitor& visit, MobifVoPlusOptions& o) {
  visit("feature", o.feature, AnyText(), "detector by name");
  visit("max_features", o.max_features, Between(50, 100000), "strongest features kept per frame");
  visit("sensitivity", o.sensitivity, Between(0.01, 1000.0), "the detector's threshold is divided by this");
  visit("ratio", o.ratio, Between(0.1, 1.0), "ratio test: nearest over second nearest distance");
  VisitFields(visit, o.landmarks);
  visit("max_lost_frames", o.max_lost_frames, Between(0, 1000000), "frames without a pose until a new start");
  visit("start_parallax_deg", o.start_parallax_deg, Between(0.01, 45.0), "median angle that starts a map");
  visit("start_direction_deg", o.start_direction_deg, Between(0.001, 180.0),
        "largest standard deviation of the first baseline's direction");
  visit("min_start_points", o.min_start_points, Between(8, 100000), "points that a new map needs");
  visit("keyframe_parallax_deg", o.keyframe_parallax_deg, Between(0.1, 90.0), "median angle that makes a keyframe");
  visit("keyframe_turn_deg", o.keyframe_turn_deg, Between(0.1, 180.0), "turn that makes a keyframe");
  visit("keyframe_overlap", o.keyframe_overlap, Between(0.0, 1.0), "part of points shared that makes a keyframe");
  visit("max_wait_frames", o.max_wait_frames, Between(0, 1000), "how long a due keyframe waits for a good frame");
  visit("window", o.window, Between(2, 1000), "keyframes refined together");
  visit("memory", o.memory, Between(1, 100000), "keyframes until an unseen point is forgotten");
  visit("adjust_iterations", o.adjust_iterations, Between(1, 1000), "most steps of a bundle adjustment");
  visit("use_floor", o.use_floor, Nested(), "keep the scale by the camera's height over the floor");
  visit("use_imu", o.use_imu, Nested(), "predict each frame's turn by the gyroscope");
}

class MobifVoPlus {
 public:
  /// @throws BadOption if the camera or an option is out of range; BadInput for an unknown detector.
  MobifVoPlus(const Calibration& calibration, const MobifVoPlusOptions& options, uint64_t seed);
  ~MobifVoPlus();

  /// Answers one frame. An image without texture, or unlike all before it, is an answer without a pose, never an error.
  /// `restarted` marks the frame that begins a new map: it starts at the last known pose and with the last known median
  /// depth as its unit, which is a guess. It marks, too, a frame that many points place farther from the last one than
  /// `usual_speed` makes believable.
  /// @throws BadInput if the image's size is not the camera's.
  FrameEstimate Track(const Observation& observation);

  /// The final word on every frame: where later keyframes have refined earlier ones, the frames about them move along.
  /// Frames before the first map are placed by it.
  std::vector<FrameEstimate> Finish();

 private:
  class Tracker;
  std::unique_ptr<Tracker> tracker_;
};

}  // namespace gaitcam
