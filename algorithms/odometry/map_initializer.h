/// Initialisation of a monocular map from two frames: waits until the camera has moved far enough since a reference
/// frame for the direction of motion and the depths to be certain.
///
/// The reference is matched with each new frame; five-point hypotheses are judged by a robust estimator, the best is
/// decomposed by points in front (thesis 5.4, steps 2 to 5) and refined by least squares. Nothing is
/// initialised by a rotation alone, nor where another motion explains the matches about as well, as of a plane. Where
/// gravity says that the plane is the floor, its two motions can be told apart. A single frame's motion that a
/// gyroscope contradicts is not believed.

#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/random.h"
#include "algorithms/features/match_filter.h"
#include "algorithms/features/matching.h"
#include "algorithms/geometry/ransac.h"
#include "algorithms/geometry/two_view.h"
#include "algorithms/odometry/frame_view.h"
#include "algorithms/odometry/keyframe_map.h"

namespace gaitcam {

struct MapInitializerOptions {
  using DescribedTag = void;

  MatchingOptions matching;   ///< Its fields are fields of these options ...
  MatchFilterOptions filter;  ///< ... and so are those of this, which is of the matches of a first map alone.
  RobustEstimator estimator = RobustEstimator::kMlesac;
  double threshold_px = 2.0;  ///< Largest error of an inlier, px at the image centre.
  double ransac_confidence = 0.9999;
  int ransac_iterations = 300;       ///< Largest number of samples.
  int min_start_points = 40;         ///< Inliers, and points with a depth, that a new map needs.
  double start_parallax_deg = 0.5;   ///< Median angle between the rays; five times as much of a planar scene.
  double start_direction_deg = 0.5;  ///< Largest standard deviation of the baseline's direction ...
  int start_patience_frames = 30;    ///< ... twice that after so many frames, three times after twice as many.
  int max_start_misses = 5;          ///< Frames in a row that do not match the reference before it is replaced.
  double min_parallax_deg = 1.0;     ///< A point has a depth when its rays meet at this angle.

  MapInitializerOptions() { matching.search = NeighbourSearch::kBestBinFirst; }
};

template <class Visitor>
void VisitFields(Visitor& visit, MapInitializerOptions& o) {
  VisitFields(visit, o.matching);
  VisitFields(visit, o.filter);
  visit("estimator", o.estimator, EnumWords<RobustEstimator>(), "robust estimator of the first two-view geometry");
  visit("threshold_px", o.threshold_px, Between(0.01, 100.0), "largest error of an inlier of two views, px");
  visit("ransac_confidence", o.ransac_confidence, Between(0.5, 0.999999), "probability of a sample without outliers");
  visit("ransac_iterations", o.ransac_iterations, Between(1, 1000000), "largest number of samples");
  visit("min_start_points", o.min_start_points, Between(8, 100000), "points that a new map needs");
  visit("start_parallax_deg", o.start_parallax_deg, Between(0.01, 45.0), "median parallax that initialises a map");
  visit("start_direction_deg", o.start_direction_deg, Between(0.001, 180.0),
        "largest standard deviation of the first baseline's direction");
  visit("start_patience_frames", o.start_patience_frames, Between(1, 1000000),
        "frames after which twice that deviation is accepted");
  visit("max_start_misses", o.max_start_misses, Between(0, 1000000),
        "unmatched frames in a row until the reference is replaced");
  visit("min_parallax_deg", o.min_parallax_deg, Between(0.01, 45.0), "parallax that gives a point its first depth");
}

/// Two frames A and B and the points that both saw. Lengths are in units of the baseline.
struct InitialPair {
  FrameView reference;                        ///< Frame A; its X_WC is not set.
  Pose X_AB;                                  ///< |translation| = 1.
  std::vector<LandmarkMatch> matches;         ///< Feature of A (a landmark once A is a keyframe), feature of B.
  std::vector<std::optional<double>> depths;  ///< In A, one per match; nothing where the parallax is too small.
  double median_depth = 0;                    ///< Of those there are.
};

/// How a camera turned from A to B, as something else than its images says.
struct KnownTurn {
  Eigen::Quaterniond R_AB = Eigen::Quaterniond::Identity();
  double sigma_rad = 0;  ///< Standard deviation about each axis.
};

class MapInitializer {
 public:
  /// What became of a frame.
  enum class Result {
    kReference,    ///< It is the new reference, or there is none: earlier frames do not count any more.
    kWaiting,      ///< It does not suffice.
    kInitialized,  ///< It is frame B of `pair()`.
  };

  MapInitializer(const CameraModel& camera, const MapInitializerOptions& options)
      : camera_(camera), options_(options) {}

  /// @param up_C unit vector against gravity in the frame's camera, where it is known: the floor, which often fills the
  /// view, then leaves no doubt about the motion.
  /// @param turn since the reference, where it is known: a motion that contradicts it begins no map, unless those of
  /// five frames before did so, too.
  Result Add(const FrameView& view, const std::optional<Eigen::Vector3d>& up_C, const std::optional<KnownTurn>& turn,
             RandomStream& random);

  /// Of the last call, if that returned kInitialized.
  const InitialPair& pair() const { return pair_; }

  /// Of the last call: R_AB of a frame that matched the reference, as if the camera had only turned; the identity for
  /// the reference itself.
  const std::optional<Eigen::Quaterniond>& rotation() const { return rotation_; }

  /// Forgets the reference.
  void Reset();

 private:
  TwoView Reconstruct(const std::vector<PointPair>& pairs, RandomStream& random) const;
  bool IsCertain(const TwoView& two_view, const std::optional<KnownTurn>& turn);
  bool Contradicts(const Eigen::Quaterniond& R_AB, const KnownTurn& turn);
  Eigen::Quaterniond RotationAlone(const FrameView& view, const std::vector<Match>& matches,
                                   const TwoView& two_view) const;
  bool MakePair(const FrameView& view, const std::vector<Match>& matches, const TwoView& two_view);
  std::optional<double> Depth(const Pose& X_AB, const PointPair& pair) const;
  double threshold() const { return options_.threshold_px / camera_.fx; }

  CameraModel camera_;
  MapInitializerOptions options_;
  std::optional<FrameView> reference_;
  std::optional<Eigen::Vector3d> reference_up_;
  int frames_ = 0;        ///< Since Reset or since a map was initialised.
  int misses_ = 0;        ///< Of these the latest that did not match the reference.
  int contradicted_ = 0;  ///< Motions in a row that were certain but for the known turn.
  InitialPair pair_;
  std::optional<Eigen::Quaterniond> rotation_;
};

}  // namespace gaitcam
