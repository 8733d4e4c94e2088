/// Hybrid SLAM with a depth camera and wheels, among people: a map of metric models along the way, linked by what the
/// camera sees or, where it sees too little, by the wheels; corrected where an earlier pass is met again.
///
/// Source: Hua, section 6.1.1; equations are of that section.
///
/// 1. Features of a frame that stand still, by ICGM with its neighbours (RobustViews), and their coordinates in space
///    make a metric model (metric_model.h). Every frame is linked with the last model; the first frame after `interval`
///    others (the text's phi) that has moved becomes a model itself. So the route is a chain of models (Eq. 6.1).
/// 2. A frame that cannot be linked with the last model is linked with the frame before it, and is a model. If that
///    fails, the wheels say how the camera moved since the last frame whose pose is known. Without wheels the frame is
///    lost; frames after it are linked with the last model or with the models that score best among all.
/// 3. Where a new model meets an earlier pass (hybrid_loops.h), the best of three rigid motions is a loop closure.
/// 4. Loops correct the route either by the text's semi-consensus (Eqs. 6.2 to 6.4, semi_consensus.h), or as links of a
///    pose graph in which false loops lose their trust (ours). There a new model is also linked with those before the
///    last one, as far as these links agree with the route, and a loop that is far from what the graph expects is none.
///
/// Ours, too: where the camera measures, the wheels count as well (`wheels_always`), each by its covariance; a motion
/// that they contradict is not that of the floor, and no measurement.
///
/// What the text leaves open, and what is done: a frame is matched with all its features, models alone have robust
/// ones: what moves is in no model, so it matches nothing. Robust features of both directions need the next frame, so
/// that a model may be linked with from the frame after its own on; live answers need no later frame.
///
/// A frame that the wheels alone answer for is lost: their pose is handed over as a prediction, unless a loop has
/// confirmed it since.
///
/// The world frame W is the first frame's camera; metres.

#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/pose_graph.h"
#include "algorithms/core/random.h"
#include "algorithms/core/route_map.h"
#include "algorithms/odometry/body_track.h"
#include "algorithms/slam/hybrid_loops.h"
#include "algorithms/slam/metric_model.h"
#include "algorithms/slam/metric_sight.h"
#include "algorithms/slam/robust_views.h"

namespace gaitcam {

/// How loops correct the route.
enum class LoopCorrection {
  kGraph,          ///< Ours: a pose graph.
  kSemiConsensus,  ///< Hua's.
};
constexpr auto WordsOf(LoopCorrection) {
  return std::array{EnumWord{LoopCorrection::kGraph, "graph"},
                    EnumWord{LoopCorrection::kSemiConsensus, "semi_consensus"}};
}

struct HybridSlamOptions {
  using DescribedTag = void;

  // The fields of these are fields of these options.
  MetricSightOptions sight;
  RobustViewOptions robust;
  ModelLinkOptions links;
  PassSearchOptions search;

  bool wheels_always = true;
  int interval = 2;
  double model_m = 0.1;
  double model_deg = 5;
  int links_back = 2;
  MatchFilterKind loop_filter = MatchFilterKind::kConsensus;
  int loop_inliers = 15;
  LoopCorrection correction = LoopCorrection::kGraph;
  double loop_gate = 50;
  double alpha = 0.8;

  HybridSlamOptions();
};

template <class Visitor>
void VisitFields(Visitor& visit, HybridSlamOptions& o) {
  VisitFields(visit, o.sight);
  VisitFields(visit, o.robust);
  VisitFields(visit, o.links);
  VisitFields(visit, o.search);
  visit("wheels_always", o.wheels_always, Nested(),
        "wheels also count where the camera measures, each by its covariance, and must not contradict it");
  visit("interval", o.interval, Between(1, 10000), "frames from one model to the next, at least ...");
  visit("model_m", o.model_m, Between(0, 100), "... if the camera has moved by this ...");
  visit("model_deg", o.model_deg, Between(0, 180), "... or has turned by this");
  visit("links_back", o.links_back, Between(0, 100), "graph: models before the last one that a new one is linked with");
  visit("loop_filter", o.loop_filter, EnumWords<MatchFilterKind>(), "which matches vote for a loop");
  visit("loop_inliers", o.loop_inliers, Between(6, 100000), "points that must agree with a loop's motion");
  visit("correction", o.correction, EnumWords<LoopCorrection>(), "how loops correct the route");
  visit("loop_gate", o.loop_gate, Between(1, 1e9), "graph: largest squared Mahalanobis length of a loop's innovation");
  visit("alpha", o.alpha, Between(0, 1), "semi_consensus: part of a loop's difference that is corrected");
}

class HybridSlam {
 public:
  /// @throws BadInput if the camera has no depth or the feature is unknown; BadOption.
  HybridSlam(const Calibration& calibration, const HybridSlamOptions& options, uint64_t seed);

  /// @throws BadInput as MetricSight::See.
  FrameEstimate Track(const Observation& observation);
  /// The final estimate of every frame, as its model stands at the end.
  std::vector<FrameEstimate> Finish();
  /// All that it takes to find one's way again. After Finish().
  RouteMap Learned() const;
  /// @throws BadInput if a map cannot be gone on with (ModelsOf).
  void CheckFits(const RouteMap& earlier) const;
  /// The same in one map with what earlier sessions learned; alone where it met nothing of it. @throws BadInput as
  /// ModelsOf.
  RouteMap LearnedAfter(const RouteMap& earlier) const;
  /// A node for each model. Covariances of the nodes are set after Finish(), of correction `graph`.
  const PoseGraph& graph() const { return graph_; }

 private:
  /// How a frame stands to a model.
  struct Stand {
    int model = 0;  ///< Node of the graph.
    Pose X_MC;
    Matrix6d covariance = Matrix6d::Zero();
    bool dead_reckoned = false;
    bool chained = false;  ///< By way of the frame before, not by a link of its own with the model.
    int inliers = 0, matches = 0;
  };
  struct Frame {
    FrameEstimate answer;  ///< But for its pose.
    std::optional<Stand> stand;
  };
  /// A node whose robust features are not known before a later frame.
  struct WaitingModel {
    int64_t stamp_ns = 0;
    cv::Mat depth;
  };

  std::optional<Stand> Locate(const MetricModel& seen, FrameEstimate& answer);
  std::optional<Stand> WithWheels(const Stand& seen, int64_t stamp_ns) const;
  std::optional<Stand> LinkWith(int model, const MetricModel& seen);
  std::optional<Stand> ChainWithFrameBefore(const MetricModel& seen);
  std::optional<Stand> DeadReckon(int64_t stamp_ns) const;
  std::optional<Stand> Relocalise(const MetricModel& seen);
  std::optional<Stand> From(const Frame& frame, const Pose& X_FT, const Matrix6d& covariance) const;

  bool BecomesModel(const std::optional<Stand>& stand) const;
  Stand AddNode(int64_t stamp_ns, const std::optional<Stand>& stand);
  int LastVisibleModel() const;
  void Settle(const RobustView& view);
  void LinkFartherBack(int model);
  std::vector<GraphLink> FindLoops(int model);
  std::optional<GraphLink> BestLinkWithPass(int model, const std::vector<int>& pass);
  void DropImplausible(std::vector<GraphLink>& loops) const;
  void CorrectByGraph(int model);
  void CorrectBySemiConsensus(int model, const std::vector<GraphLink>& loops);
  bool IsSeen(const Frame& frame) const;
  FrameEstimate AnswerOf(const Frame& frame) const;

  Calibration calibration_;
  HybridSlamOptions options_;
  uint64_t seed_;
  ModelLinkOptions loop_links_;
  RandomStream random_;
  MetricSight sight_;
  RobustViews robust_;
  BodyTrack body_;
  PassSearch search_;
  PoseGraph graph_;
  std::vector<MetricModel> models_;   ///< Of the first nodes; the others wait.
  std::deque<WaitingModel> waiting_;  ///< Of the last nodes.
  int last_corrected_ = 0;            ///< Node; semi_consensus.
  int frames_since_model_ = 0;
  std::vector<Frame> frames_;
  MetricModel last_seen_;              ///< All features of the frame before.
  std::optional<size_t> last_stands_;  ///< The last frame whose pose is known.
};

}  // namespace gaitcam
