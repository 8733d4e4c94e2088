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
/// image given that map instead, a Gaussian about its maximum (Gauss-Newton), and the weight is the mass of that
/// product: a filter that samples where its particles survive. Elsewhere N(m, Q) is drawn from and weights stay.
///
/// Likelihood (instead of Eq. 6.22, a plain sum of differences). Each of n floor points that the map knows has a
/// residual r = seen - (gain map + offset), gain and offset fitted; a residual is Gaussian noise of sensor, cell and
/// blur with standard deviation `noise_grey`, or, at a part of the points, anything at all: log p = -1/2 sum rho(r /
/// noise_grey), rho(e) = c^2 log(1 + e^2/c^2). Neighbouring points err together: the sum counts for `independent` of
/// the points.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/planar_pose.h"
#include "algorithms/core/random.h"
#include "algorithms/estimation/planar_graph.h"
#include "algorithms/planes/floor_patch.h"

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
  int min_match_points = 80;     ///< Fewer in known floor say nothing.
  double match_sigma_m = 0.003;  ///< Least standard deviation of a match: pictures are rectified only so well.
  double match_sigma_deg = 0.2;
  double min_correlation = 0.8;  ///< Of a match; less: it is another place.
  double noise_grey = 8.0;
  double independent = 0.05;    ///< Part of the points that the likelihood counts.
  double resample_ratio = 0.5;  ///< A smaller effective part of the particles is drawn anew.
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
  visit("min_match_points", o.min_match_points, Between(4, 100000), "fewer in known floor say nothing");
  visit("match_sigma_m", o.match_sigma_m, Between(1e-5, 1.0), "least standard deviation of a match");
  visit("match_sigma_deg", o.match_sigma_deg, Between(1e-3, 90.0), "least standard deviation of a match");
  visit("min_correlation", o.min_correlation, Between(0.0, 1.0), "of a match; less: another place");
  visit("noise_grey", o.noise_grey, Between(0.1, 255.0), "standard deviation of a floor point's residual");
  visit("independent", o.independent, Between(1e-4, 1.0), "part of the points that the likelihood counts");
  visit("resample_ratio", o.resample_ratio, Between(0.0, 1.0), "a smaller effective part is drawn anew");
}

/// One keyframe's place was found by floor seen before.
struct FloorLoop {
  int keyframe = 0, earlier = 0;                         ///< Indices of steps; of several earlier ones, the nearest.
  PlanarPose motion;                                     ///< From the earlier one to the keyframe.
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
  /// An earlier picture and where it lies.
  struct Known {
    const FloorPatch* patch;
    PlanarPose pose;
    int step;
  };
  /// Where the pictures agree best, alone.
  struct Match {
    Eigen::Vector3d moved;       ///< x, y (m), yaw (rad) from the expected pose, in its frame ...
    Eigen::Matrix3d covariance;  ///< ... as are these.
    int points = 0;
    double mean_rho = 0, correlation = 0;
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

  std::vector<Known> FindKnown(const Particle& particle, const PlanarPose& expected, const FloorPatch& patch) const;
  std::optional<Match> MatchPictures(const std::vector<Known>& pictures, const PlanarPose& expected,
                                     const FloorPatch& patch) const;
  Proposal Propose(const Particle& particle, const PlanarPose& expected, const Eigen::Matrix3d& Q,
                   const FloorPatch& patch) const;
  void Move(Particle& particle, const Proposal& proposal);
  void Reweigh(const std::vector<Proposal>& proposals);
  void Resample();
  const Particle& Best() const;

  FloorFilterOptions options_;
  RandomStream random_;
  std::vector<Particle> particles_;
  std::vector<FloorPatch> patches_;  ///< One per step ...
  std::vector<double> way_m_;        ///< ... how long the way was there ...
  std::vector<PlanarEdge> motions_;  ///< ... and the motion that led there.
  double effective_ = 0;
  int corrected_ = 0;
};

}  // namespace gaitcam
