/// Simultaneous localisation and mapping on a floor by a Rao-Blackwellised particle filter (thesis 6.5).
///
/// A particle is a trajectory: planar poses of all keyframes. Given the trajectory, the map of the floor is known: the
/// keyframes' images, rectified and placed along it. So particles store no maps. They share the rectified images
/// (floor_patch.h), and each looks up a position in the images that lie there along its own trajectory. Memory grows
/// with the length walked and with the particles' trajectories, not with particles times area.
///
/// Height and tilt of the camera are observed anew by every frame (floor_tracker.h); only x, y and yaw drift, and these
/// are what particles sample.
///
/// Proposal and weight. The tracked motion is a Gaussian N(m, Q) about each particle's last pose (Eq. 6.21). Where a
/// particle's map holds floor seen at least `loop_m` before, the pose is drawn from N(m, Q) times the likelihood of the
/// image given that map (floor_match.h), a Gaussian about its maximum (Gauss-Newton), and the weight is the integral of
/// that product: the optimal proposal, to that approximation. Elsewhere poses are drawn from N(m, Q) and weights stay.
///
/// The thesis's own way is there to be compared (FloorWeighting): poses from N(m, Q), weights by differences of grey
/// level, no registration with the map; the best particle's trajectory is the final one. Unlike there, only floor seen
/// at least `loop_m` before counts, and a submap after a loss is searched for as below.
///
/// After a loss the motion is little more than a guess; too few of the particles drawn from it would fall near the
/// truth. So none are drawn: the trajectory continues from the guess as a new submap, whose covariance relative to the
/// map is kept beside the particles. The submap is searched for in the map (floor_search.h); once found, it is moved
/// there as a whole. Drift beyond the reach of the particles' own matching is corrected by the same search.

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/core/enum_words.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/planar_pose.h"
#include "algorithms/core/random.h"
#include "algorithms/estimation/planar_graph.h"
#include "algorithms/planes/floor_match.h"

namespace gaitcam {

/// By what particles are weighed where they see known floor.
enum class FloorWeighting {
  kLikelihood,   ///< Drawn by the optimal proposal and weighed by its integral (above).
  kDifferences,  ///< Drawn from N(m, Q) alone; weight = sum of squared differences of grey level, as Eq. 6.22 stands:
                 ///< the more a particle disagrees with its map, the more often it is drawn.
  kReciprocal,   ///< The same with the reciprocal of their mean, as Eq. 6.22 must be meant.
};
constexpr auto WordsOf(FloorWeighting) {
  return std::array{EnumWord{FloorWeighting::kLikelihood, "likelihood"},
                    EnumWord{FloorWeighting::kDifferences, "differences"},
                    EnumWord{FloorWeighting::kReciprocal, "reciprocal"}};
}

struct FloorFilterOptions {
  using DescribedTag = void;

  int particles = 100;
  FloorWeighting weighting = FloorWeighting::kLikelihood;
  double cell_m = 0.005;         ///< Side of a map's cell.
  double range_heights = 2.8;    ///< Floor beyond this distance, in camera heights, is not mapped.
  double inflation = 1.5;        ///< Factor on the standard deviations of the tracked motion.
  double drift_ratio = 0.005;    ///< Added to them: position per length moved ...
  double drift_deg_per_m = 0.3;  ///< ... and heading per metre.
  double loop_m = 2.0;           ///< Path length after which floor seen again corrects the pose.
  int pictures = 4;              ///< Nearest earlier keyframes that a new one is compared with.
  int match_points = 400;        ///< Floor points compared with the map.
  FloorMatchOptions match;
  double min_correlation = 0.8;  ///< Of a match.
  double joint_m = 0.1;          ///< Position's standard deviation of a motion that starts a new submap.
  double search_sigma_m = 0.02;  ///< Position's standard deviation from which on known floor is searched for, where no
                                 ///< particle matches it.
  double search_cell_m = 0.025;  ///< Side of a cell in that search.
  int search_cells = 150;        ///< Cells that map and submap must have in common.
  double resample_ratio = 0.5;   ///< Effective part of the particles below which they are resampled.
};

template <class Visitor>
void VisitFields(Visitor& visit, FloorFilterOptions& o) {
  visit("particles", o.particles, Between(1, 100000), "hypotheses of the trajectory");
  visit(
      "weighting", o.weighting, EnumWords<FloorWeighting>(),
      "of particles: likelihood with an optimal proposal; squared differences as the thesis has it; their reciprocal");
  visit("cell_m", o.cell_m, Between(0.001, 0.1), "side of a map's cell");
  visit("range_heights", o.range_heights, Between(1.1, 100.0), "farthest floor mapped, in camera heights");
  visit("inflation", o.inflation, Between(0.0, 100.0), "of the tracked motion's standard deviation");
  visit("drift_ratio", o.drift_ratio, Between(0.0, 1.0), "standard deviation of position added per length moved");
  visit("drift_deg_per_m", o.drift_deg_per_m, Between(0.0, 90.0), "standard deviation of heading added per metre");
  visit("loop_m", o.loop_m, Between(0.1, 1e6), "path length after which floor seen again corrects the pose");
  visit("pictures", o.pictures, Between(1, 1000), "earlier keyframes that a new one is compared with");
  visit("match_points", o.match_points, Between(10, 100000), "floor points compared with the map");
  visit("match", o.match, Nested(), "likelihood of what is seen");
  visit("min_correlation", o.min_correlation, Between(0.0, 1.0), "of a match; less: none");
  visit("joint_m", o.joint_m, Between(0.001, 1e6),
        "standard deviation of a motion that starts a submap, which is searched for");
  visit("search_sigma_m", o.search_sigma_m, Between(0.001, 1e6),
        "standard deviation from which on known floor is searched for where no particle finds it");
  visit("search_cell_m", o.search_cell_m, Between(0.005, 1.0), "side of a cell when a submap is searched for");
  visit("search_cells", o.search_cells, Between(10, 1000000), "cells that map and submap must have in common");
  visit("resample_ratio", o.resample_ratio, Between(0.0, 1.0), "a smaller effective part is drawn anew");
}

/// A loop closure: a keyframe's pose relative to an earlier one, by floor that both show.
struct FloorLoop {
  int keyframe = 0, earlier = 0;                         ///< Indices of steps; of several earlier ones, the nearest.
  PlanarPose motion;                                     ///< From the earlier one to the keyframe.
  double correlation = 0;                                ///< Of their images.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of x, y (m), yaw (rad), in the keyframe's frame.
};

class FloorFilter {
 public:
  /// @throws BadOption.
  FloorFilter(const FloorFilterOptions& options, uint64_t seed);

  /// Adds a keyframe. The first call's motion starts at the world's origin.
  /// @param motion     of the frame below the camera since the last call
  /// @param covariance of x, y (m), yaw (rad), in the frame at the motion's end
  /// @param patch      what the keyframe shows of the floor; may be empty
  void Step(const PlanarPose& motion, const Eigen::Matrix3d& covariance, FloorPatch patch);

  /// Of the particle of largest weight: poses of the frames below the camera, one per step, and its loop closures.
  const std::vector<PlanarPose>& BestPath() const { return Best().path; }
  const std::vector<FloorLoop>& BestLoops() const { return Best().loops; }
  /// Pose-graph solution of all tracked motions and the best particle's loop closures: free of the particles' random
  /// draws. With weights by differences: BestPath().
  std::vector<PlanarPose> SmoothPath() const;
  /// Of the last pose: mean over the particles, and covariance about it.
  PlanarPose Mean() const;
  /// Of x, y (m) and yaw (rad), in W; that of submaps whose pose is not known is part of it.
  Eigen::Matrix3d Covariance() const;
  /// Of each pose of SmoothPath(), in its own frame, by that graph; it knows nothing of weights by differences.
  std::vector<Eigen::Matrix3d> SmoothCovariances(const std::vector<PlanarPose>& smooth) const;
  /// Of a motion over `moved_m` that the tracker knows to `tracked`: inflated, plus a lower bound of drift.
  Eigen::Matrix3d MotionCovariance(double moved_m, const Eigen::Matrix3d& tracked) const;
  /// The map along a trajectory of one pose per step.
  FloorPicture Map(const std::vector<PlanarPose>& path) const;

  double effective_particles() const { return effective_; }
  /// Submaps whose pose in the map has not been found.
  int detached_submaps() const;
  /// Particles whose last pose was corrected by a loop closure.
  int corrected() const { return corrected_; }
  /// Memory of images and trajectories.
  double map_bytes() const;

 private:
  struct Particle {
    std::vector<PlanarPose> path;  ///< One pose per step.
    std::vector<FloorLoop> loops;
    double log_weight = 0;
  };
  /// A particle's proposal distribution after a motion.
  struct Proposal {
    PlanarPose pose;
    Eigen::Matrix3d covariance;     ///< In the frame of `pose`.
    int points = 0;                 ///< Compared with earlier keyframes; 0: too few, and nothing below is set.
    double log_likelihood = 0;      ///< Per point, at its maximum.
    double log_prior = 0;           ///< With it, the logarithm of the product's integral.
    std::optional<FloorLoop> loop;  ///< Set if the images agree.
  };

  /// The trajectory after a loss.
  struct Submap {
    int first_step = 0;
    Eigen::Matrix3d covariance;  ///< Of the first step's pose, in its own frame.
    bool detached = true;        ///< Its pose in the map is not known.
  };
  /// Half-open.
  struct StepRange {
    int begin = 0, end = 0;
  };

  std::vector<PlanarEdge> Edges() const;
  StepRange MappedSteps() const;
  std::vector<KnownFloor> FindKnown(const Particle& particle, const PlanarPose& expected, const FloorPatch& patch,
                                    const StepRange& steps) const;
  bool Agrees(const FloorMatch& match) const;
  Proposal Propose(const Particle& particle, const PlanarPose& expected, const Eigen::Matrix3d& Q,
                   const FloorPatch& patch) const;
  void Move(Particle& particle, const Proposal& proposal);
  void Reweigh(const std::vector<Proposal>& proposals);
  void ReweighByDifferences(const StepRange& steps);
  void Resample();
  const Submap* DetachedSubmap() const;
  void Search();
  std::optional<FloorLoop> UnambiguousLoop(int begin, int map_end) const;
  std::vector<FloorLoop> VerifiedLoops(int begin, int map_end) const;
  std::optional<FloorLoop> Verify(const PlanarPose& expected, int keyframe, int map_end) const;
  void MoveOnto(int begin, const FloorLoop& loop);
  const Particle& Best() const;

  FloorFilterOptions options_;
  RandomStream random_;
  std::vector<Particle> particles_;
  std::vector<FloorPatch> patches_;    ///< One per step, as are ...
  std::vector<double> path_length_m_;  ///< ... the length of the trajectory up to it ...
  std::vector<PlanarEdge> motions_;    ///< ... and the tracked motion to it.
  std::vector<Submap> submaps_;
  double effective_ = 0;
  int corrected_ = 0;
};

}  // namespace gaitcam
