/// Where a robot is on a floor that it maps as it goes: a Rao-Blackwellised particle filter (thesis 6.5).
///
/// A particle is a way: planar poses of all keyframes. Given the way, the floor's map is known: what the keyframes saw,
/// laid down along it. So particles store no maps. They share the keyframes' rectified pictures (floor_patch.h) and the
/// parts of their ways that they have in common, and look a place up in the pictures that lie there on their own way;
/// memory grows with the way walked and with what particles differ in, not with particles times area.
///
/// Height and tilt of the camera are observed afresh by every frame (floor_tracker.h); only x, y and yaw drift. They
/// are what particles differ in.
///
/// Proposal and weight. The tracked motion is a Gaussian N(m, Q) about each particle's last pose (Eq. 6.21). Where a
/// particle's map holds floor that it saw long ago, the pose is drawn from N(m, Q) times the likelihood of the
/// image given that map instead (floor_match.h), a Gaussian about its maximum (Gauss-Newton), and the weight is the
/// mass of that product: a filter that samples where its particles survive. Elsewhere N(m, Q) is drawn from and weights
/// stay.
///
/// After a loss the motion is little more than a guess. Too few particles would fall near the truth if they drew it, so
/// none is drawn: the way goes on from the guess as a piece of its own, hung on by a joint whose covariance is kept
/// beside the particles. What the piece has seen is searched for in the map (floor_search.h); once it is found, the
/// piece is moved there, whole, and the joint is closed. A way that has drifted farther than particles search is looked
/// for in the same manner when known floor is near.
///
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/planar_pose.h"
#include "algorithms/core/random.h"
#include "algorithms/estimation/planar_graph.h"
#include "algorithms/planes/floor_match.h"

namespace gaitcam {

struct FloorFilterOptions {
  using DescribedTag = void;

  int particles = 100;
  double cell_m = 0.005;         ///< Of the maps.
  double range_heights = 2.8;    ///< Floor farther from the camera is not mapped: its pixels are larger than cells.
  double inflation = 1.5;        ///< Standard deviations of the tracked motion are so many times what it says ...
  double drift_ratio = 0.005;    ///< ... and at least this part of the way ...
  double drift_deg_per_m = 0.3;  ///< ... and of the turn, so much per metre.
  double loop_m = 2.0;           ///< Floor seen so much way ago, or more, corrects the pose.
  int pictures = 4;              ///< Earlier keyframes that a new one is compared with: the nearest.
  int match_points = 400;        ///< Floor points compared with the map.
  FloorMatchOptions match;
  double min_correlation = 0.8;  ///< Of a match; less: it is another place.
  double joint_m = 0.1;          ///< A motion with a larger standard deviation is not drawn: it makes a joint.
  double search_sigma_m = 0.02;  ///< Known no better than this, known floor is searched for where no particle finds it.
  double search_cell_m = 0.025;  ///< Of the pictures in which a piece's place is searched for.
  int search_cells = 150;        ///< Fewer known in both say nothing.
  double resample_ratio = 0.5;   ///< A smaller effective part of the particles is drawn anew.
};

template <class Visitor>
void VisitFields(Visitor& visit, FloorFilterOptions& o) {
  visit("particles", o.particles, Between(1, 100000), "hypotheses of the way");
  visit("cell_m", o.cell_m, Between(0.001, 0.1), "side of a map's cell");
  visit("range_heights", o.range_heights, Between(1.1, 100.0), "farthest floor mapped, in camera heights");
  visit("inflation", o.inflation, Between(0.0, 100.0), "of the tracked motion's standard deviation");
  visit("drift_ratio", o.drift_ratio, Between(0.0, 1.0), "least standard deviation of position, of the way");
  visit("drift_deg_per_m", o.drift_deg_per_m, Between(0.0, 90.0), "least standard deviation of heading");
  visit("loop_m", o.loop_m, Between(0.1, 1e6), "way after which floor seen again corrects the pose");
  visit("pictures", o.pictures, Between(1, 1000), "earlier keyframes that a new one is compared with");
  visit("match_points", o.match_points, Between(10, 100000), "floor points compared with the map");
  visit("match", o.match, Nested(), "likelihood of what is seen");
  visit("min_correlation", o.min_correlation, Between(0.0, 1.0), "of a match; less: another place");
  visit("joint_m", o.joint_m, Between(0.001, 1e6), "a motion known worse is not drawn: its end is searched for");
  visit("search_sigma_m", o.search_sigma_m, Between(0.001, 1e6),
        "standard deviation from which on known floor is searched for where no particle finds it");
  visit("search_cell_m", o.search_cell_m, Between(0.005, 1.0), "of the pictures in which a piece is searched for");
  visit("search_cells", o.search_cells, Between(10, 1000000), "fewer known in both pictures say nothing");
  visit("resample_ratio", o.resample_ratio, Between(0.0, 1.0), "a smaller effective part is drawn anew");
}

/// One keyframe's place was found by floor seen before.
struct FloorLoop {
  int keyframe = 0, earlier = 0;                         ///< Indices of steps; of several earlier ones, the nearest.
  PlanarPose motion;                                     ///< From the earlier one to the keyframe.
  double correlation = 0;                                ///< Of what both saw.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of x, y (m), yaw (rad), in the keyframe's frame.
};

class FloorFilter {
 public:
  /// @throws BadOption.
  FloorFilter(const FloorFilterOptions& options, uint64_t seed);

  /// Moves all particles on, and keeps what is seen. The first call's motion leads from the world's origin.
  /// @param motion of the frame below the camera since the last call. @param covariance of x, y (m), yaw (rad), in the
  /// frame that the motion leads to.
  void Step(const PlanarPose& motion, const Eigen::Matrix3d& covariance, FloorPatch patch);

  /// Of the heaviest particle: poses of the frames below the camera, one per step, and its loops.
  const std::vector<PlanarPose>& BestPath() const { return Best().path; }
  const std::vector<FloorLoop>& BestLoops() const { return Best().loops; }
  /// The way that agrees best with all tracked motions and the heaviest particle's loops: the particles found out what
  /// belongs together; what their random draws have added on the way is taken out again.
  std::vector<PlanarPose> SmoothPath() const;
  /// Last pose, mean over the particles; and the covariance about it.
  PlanarPose Mean() const;
  Eigen::Matrix3d Covariance() const;
  /// What was seen, laid down along a way: one pose per step.
  FloorPicture Map(const std::vector<PlanarPose>& path) const;

  double effective_particles() const { return effective_; }
  /// Losses after which the way's place in the map has not been found again.
  int open_joints() const;
  /// Particles whose last pose was corrected by floor seen long ago.
  int corrected() const { return corrected_; }
  /// Memory of what the particles know: pictures and ways.
  double map_bytes() const;

 private:
  struct Particle {
    std::vector<PlanarPose> path;  ///< One pose per step.
    std::vector<FloorLoop> loops;
    double log_weight = 0;
  };
  /// Where a particle may be after a motion.
  struct Proposal {
    PlanarPose pose;
    Eigen::Matrix3d covariance;     ///< In the frame of `pose`.
    int points = 0;                 ///< Compared with floor seen long ago; 0: too few, and nothing below is set.
    double log_likelihood = 0;      ///< Per point, at its best.
    double log_prior = 0;           ///< With it, the logarithm of the product's mass.
    std::optional<FloorLoop> loop;  ///< Set if they agree.
  };

  /// Where the way broke off and went on from a guess.
  struct Joint {
    int step = 0;                ///< The first of the new piece.
    Eigen::Matrix3d covariance;  ///< Of its pose, in its own frame.
    bool open = true;
  };
  /// Steps in which floor is looked for: [begin, end).
  struct StepRange {
    int begin = 0, end = 0;
  };

  StepRange LongAgo() const;
  std::vector<KnownFloor> FindKnown(const Particle& particle, const PlanarPose& expected, const FloorPatch& patch,
                                    const StepRange& steps) const;
  bool Agrees(const FloorMatch& match) const;
  Proposal Propose(const Particle& particle, const PlanarPose& expected, const Eigen::Matrix3d& Q,
                   const FloorPatch& patch) const;
  void Move(Particle& particle, const Proposal& proposal);
  void Reweigh(const std::vector<Proposal>& proposals);
  void Resample();
  const Joint* OpenJoint() const;
  void Search();
  std::optional<FloorLoop> ClearFind(int begin, int map_end) const;
  std::vector<FloorLoop> VerifiedFinds(int begin, int map_end) const;
  std::optional<FloorLoop> Verify(const PlanarPose& expected, int keyframe, int map_end) const;
  void AttachPiece(int begin, const FloorLoop& loop);
  const Particle& Best() const;

  FloorFilterOptions options_;
  RandomStream random_;
  std::vector<Particle> particles_;
  std::vector<FloorPatch> patches_;  ///< One per step ...
  std::vector<double> way_m_;        ///< ... how long the way was there ...
  std::vector<PlanarEdge> motions_;  ///< ... and the motion that led there.
  std::vector<Joint> joints_;
  double effective_ = 0;
  int corrected_ = 0;
};

}  // namespace gaitcam
