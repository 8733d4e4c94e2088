/// Pose SLAM: a delayed-state map of stereo keyframes and nothing else. Links between them are measured motions with
/// covariances: by odometry from each to the next, by loop closures to those seen long before.
///
/// Source: Valencia, chapter 2, for the links; V. Ila, J. M. Porta and J. Andrade-Cetto, "Information-based compact
/// Pose SLAM", IEEE T-RO 26, 2010, for what is kept: a pose only where no other stands nearly as the camera does, a
/// link only if it tells more than a number of nats.
///
/// Composed of
/// - StereoVo (algorithms/odometry): keyframes, and the motion between them with its covariance;
/// - StereoLoops: the motion between two keyframes that show the same;
/// - SolvePoseGraph, PoseGraphCovariances (algorithms/estimation): the poses, robust to false loops.
///
/// A loop is looked for where the graph's covariances allow that the camera sees what an earlier node saw, among those
/// nodes that look most alike by a bag of words, measured by matched points (geometry), and kept if it is as likely as
/// `loop_gate` says (Mahalanobis distance) and tells more than `loop_gain`. Frames stand to their nodes as the odometry
/// has them.
///
/// What the lenses' calibration has wrong is the same in all links. It does not weigh them; what it does to each node
/// follows from the graph's solution (InCommon), and stands beside the covariances as it does with StereoVo.
///
/// The world frame W is the first keyframe's left camera; metres.

#pragma once

#include <cstdint>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/pose_graph.h"
#include "algorithms/core/random.h"
#include "algorithms/estimation/pose_graph_solver.h"
#include "algorithms/odometry/stereo_vo.h"
#include "algorithms/slam/stereo_loops.h"

namespace gaitcam {

struct PoseSlamOptions {
  using DescribedTag = void;

  // The fields of these are fields of these options.
  StereoVoOptions odometry;
  StereoLoopOptions loops;

  double node_m = 0.25;     ///< A keyframe nearer than this to a node ...
  double node_deg = 20;     ///< ... and turned less against it adds no node, unless it closes a loop.
  double near_m = 0.6;      ///< Two cameras so near to each other ...
  double near_deg = 30;     ///< ... and turned so little against each other may see the same.
  int loop_candidates = 3;  ///< Nodes that a keyframe is matched with, those first that look most alike.
  double loop_gate = 50;    ///< Largest squared Mahalanobis length of what a loop says beside what is known.
  double loop_gain = 8;     ///< A loop that tells less, nats, is not kept.
  double false_loops = 0;   ///< For tests of robustness: such a part of the loops is replaced by false ones.
};

template <class Visitor>
void VisitFields(Visitor& visit, PoseSlamOptions& o) {
  VisitFields(visit, o.odometry);
  VisitFields(visit, o.loops);
  visit("node_m", o.node_m, Between(0, 100), "a keyframe nearer than this to a node adds none ...");
  visit("node_deg", o.node_deg, Between(0, 180), "... if it is turned less than this against it, and closes no loop");
  visit("near_m", o.near_m, Between(0, 100), "two cameras so near to each other may see the same ...");
  visit("near_deg", o.near_deg, Between(0, 180), "... if they are turned by less than this against each other");
  visit("loop_candidates", o.loop_candidates, Between(0, 1000), "nodes that a keyframe is matched with; 0: no loops");
  visit("loop_gate", o.loop_gate, Between(1, 1e9), "largest squared Mahalanobis length of a loop's innovation");
  visit("loop_gain", o.loop_gain, Between(0, 1000), "information that a loop must bring, nats");
  visit("false_loops", o.false_loops, Between(0, 1),
        "for tests of robustness: this part of the loops is replaced by false ones");
}

class PoseSlam {
 public:
  /// @throws as StereoVo does; BadOption if an option is out of range.
  PoseSlam(const Calibration& calibration, const PoseSlamOptions& options, uint64_t seed);

  /// Answers one frame as StereoVo does, moved to where the graph has its keyframe.
  FrameEstimate Track(const Observation& observation);
  /// The final estimate of every frame, by the graph as it is at the end.
  std::vector<FrameEstimate> Finish();
  /// Nodes and links. Covariances of the nodes are set.
  const PoseGraph& graph() const { return graph_; }

 private:
  struct Loop {
    int from = 0, to = 0;  ///< Keyframes.
    LoopMotion motion;
  };
  /// A node whose camera may have seen what the newest one sees.
  struct Candidate {
    int node = 0;
    double likeness = 0;  ///< By words that both show.
    Pose X_FT;
    Matrix6d covariance;
  };

  void AddKeyframe(const StereoView& view, int64_t stamp_ns, bool restarted);
  bool IsRedundant(size_t node) const;
  void RemoveNode(size_t node);
  GraphLink OdometryLink(size_t node) const;
  int NodeOf(int keyframe) const;
  std::vector<Candidate> Candidates() const;
  void CloseLoops(const StereoView& view);
  Matrix6d LoopCovariance(int from, int to, const LoopMotion& motion) const;
  void Plant(LoopMotion& motion);
  void Solve();
  FrameEstimate Corrected(const FrameEstimate& odometry, int keyframe) const;
  void CorrectLensErrors(size_t node, const Pose& X_NC, FrameEstimate& answer) const;

  PoseSlamOptions options_;
  StereoVo odometry_;
  StereoLoops finder_;
  RandomStream random_;
  std::vector<int> keyframes_;  ///< Of each node, its keyframe's number.
  std::vector<bool> begins_;    ///< Of each keyframe: a new map began, and what lies before is known only roughly.
  std::vector<Loop> loops_;
  PoseGraph graph_;
  std::vector<CommonErrors> lens_errors_;  ///< Of each node, beside its covariance.
  std::vector<int> frame_keyframes_;       ///< Of each frame, the keyframe it refers to; -1: none.
};

}  // namespace gaitcam
