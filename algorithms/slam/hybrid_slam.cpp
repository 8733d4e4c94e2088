#include "algorithms/slam/hybrid_slam.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "algorithms/estimation/pose_graph_solver.h"
#include "algorithms/estimation/semi_consensus.h"
#include "algorithms/slam/map_merger.h"

namespace gaitcam {

HybridSlamOptions::HybridSlamOptions() : robust(RobustViewOptions::By(Robustness::kIcgm)) {
  robust.icgm.direction = IcgmDirection::kDouble;
}

HybridSlam::HybridSlam(const Calibration& calibration, const HybridSlamOptions& options, uint64_t seed)
    : calibration_(calibration),
      options_(options),
      seed_(seed),
      loop_links_(options.links),
      random_(seed, "hybrid_slam"),
      sight_(calibration, options.sight, "hybrid_slam"),
      robust_(options.robust, seed),
      body_(calibration.odometry, calibration.imu),
      search_(options.search) {
  CheckFields(options, "hybrid_slam.");
  loop_links_.filter.filter = options.loop_filter;
  loop_links_.min_inliers = options.loop_inliers;
}

FrameEstimate HybridSlam::Track(const Observation& observation) {
  body_.Add(observation.odometry, observation.imu);
  const int64_t stamp_ns = observation.stamp_ns;
  const cv::Mat& image = observation.image.pixels;
  const MetricModel seen = sight_.See(observation);
  Frame frame;
  frame.answer.stamp_ns = stamp_ns;
  frame.answer.features = seen.features.size();
  const std::vector<RobustView> ready = robust_.Add(stamp_ns, {image.size(), seen.features});
  const auto settle = [&] {
    for (const RobustView& view : ready) Settle(view);
  };
  settle();  // the frame before, where it waited for this one
  frame.stand = Locate(seen, frame.answer);
  ++frames_since_model_;
  const bool first = graph_.nodes.empty() && int(seen.p_C.size()) >= options_.links.min_inliers;
  if (first || BecomesModel(frame.stand)) {
    frame.stand = AddNode(stamp_ns, frame.stand);
    waiting_.push_back({stamp_ns, observation.depth->pixels.clone()});
    settle();  // itself, where it waits for none
  }
  if (frame.stand) {
    last_stands_ = frames_.size();
    const int model = LastVisibleModel();
    body_.Forget(model < 0 ? 0 : std::min(stamp_ns, graph_.nodes[size_t(model)].stamp_ns));
    ++graph_.candidates;
  }
  last_seen_ = seen;
  frames_.push_back(std::move(frame));
  return AnswerOf(frames_.back());
}

// ---------------------------------------------------------------------------------------------------------------------
// A frame against the models.

std::optional<HybridSlam::Stand> HybridSlam::Locate(const MetricModel& seen, FrameEstimate& answer) {
  if (graph_.nodes.empty()) return std::nullopt;
  std::optional<Stand> stand;
  if (const int model = LastVisibleModel(); model >= 0) stand = LinkWith(model, seen);
  if (stand) stand = WithWheels(*stand, answer.stamp_ns);
  const bool lost = !last_stands_ || *last_stands_ + 1 != frames_.size();
  if (!stand && !lost) stand = ChainWithFrameBefore(seen);
  if (stand && stand->chained) stand = WithWheels(*stand, answer.stamp_ns);
  if (!stand) stand = DeadReckon(answer.stamp_ns);
  if (!stand && lost) stand = Relocalise(seen);
  if (stand) std::tie(answer.inliers, answer.matches) = std::pair(stand->inliers, stand->matches);
  return stand;
}

/// The last one with enough features to be linked with, or -1.
int HybridSlam::LastVisibleModel() const {
  int model = int(models_.size()) - 1;
  while (model >= 0 && int(models_[size_t(model)].p_C.size()) < options_.links.min_inliers) --model;
  return model;
}

/// R_x of M_x and a model before it.
std::optional<HybridSlam::Stand> HybridSlam::LinkWith(int model, const MetricModel& seen) {
  const auto link = LinkModels(models_[size_t(model)], seen, options_.links, random_);
  if (!link) return std::nullopt;
  return Stand{model, link->X_FT, link->covariance, false, false, link->inliers, link->matches};
}

std::optional<HybridSlam::Stand> HybridSlam::ChainWithFrameBefore(const MetricModel& seen) {
  const auto link = LinkModels(last_seen_, seen, options_.links, random_);
  if (!link) return std::nullopt;
  std::optional<Stand> stand = From(frames_.back(), link->X_FT, link->covariance);
  stand->chained = true;
  stand->inliers = link->inliers;
  stand->matches = link->matches;
  return stand;
}

/// "When failed, ... we update relative pose which calculated from tires' odometry to R."
std::optional<HybridSlam::Stand> HybridSlam::DeadReckon(int64_t stamp_ns) const {
  if (!last_stands_) return std::nullopt;
  const Frame& last = frames_[*last_stands_];
  const std::optional<RelativePose> moved = body_.Between(last.answer.stamp_ns, stamp_ns);
  if (!moved) return std::nullopt;
  std::optional<Stand> stand = From(last, moved->X_FT, moved->covariance);
  stand->dead_reckoned = true;
  stand->chained = false;
  return stand;
}

/// The same stand as both have it; nothing if the wheels contradict what was seen.
std::optional<HybridSlam::Stand> HybridSlam::WithWheels(const Stand& seen, int64_t stamp_ns) const {
  constexpr double kChi2 = 22.46;  // 99.9 % of six degrees of freedom
  const auto moved = body_.Between(graph_.nodes[size_t(seen.model)].stamp_ns, stamp_ns);
  if (!moved || !options_.wheels_always) return seen;
  if (InnovationChi2(moved->X_FT, moved->covariance, seen.X_MC, seen.covariance) > kChi2) return std::nullopt;
  if (seen.chained) return seen;  // they count in the frame before
  Stand both = seen;
  both.X_MC = MahalanobisMean({{seen.X_MC, seen.covariance}, {moved->X_FT, moved->covariance}});
  both.covariance = (seen.covariance.inverse() + moved->covariance.inverse()).inverse();
  return both;
}

/// By the models that score best, wherever they are.
std::optional<HybridSlam::Stand> HybridSlam::Relocalise(const MetricModel& seen) {
  std::optional<Stand> best;
  for (const std::vector<int>& pass : search_.BestOfEachPass(seen.features.descriptors, search_.size())) {
    for (const int model : pass) {
      const std::optional<Stand> stand = LinkWith(model, seen);
      if (stand && (!best || stand->inliers > best->inliers)) best = stand;
    }
  }
  return best;
}

/// A stand by way of a frame whose own is known.
std::optional<HybridSlam::Stand> HybridSlam::From(const Frame& frame, const Pose& X_FT,
                                                  const Matrix6d& covariance) const {
  Stand stand = *frame.stand;
  stand.X_MC = stand.X_MC * X_FT;
  stand.covariance = CovarianceOfProduct(X_FT, stand.covariance, covariance);
  stand.inliers = stand.matches = 0;
  return stand;
}

// ---------------------------------------------------------------------------------------------------------------------
// Models.

bool HybridSlam::BecomesModel(const std::optional<Stand>& stand) const {
  if (!stand) return false;
  if (stand->chained && waiting_.empty()) return true;  // the last model is out of sight
  if (frames_since_model_ < options_.interval) return false;
  const Pose X_LC = graph_.nodes.back().X_WC.Inverse() * graph_.nodes[size_t(stand->model)].X_WC * stand->X_MC;
  return X_LC.translation.norm() >= options_.model_m ||
         RotationAngle(Eigen::Quaterniond::Identity(), X_LC.rotation) >= kRadPerDeg * options_.model_deg;
}

/// Eq. 6.1: L_n = L_(n - phi) + R_n. @returns how the frame stands to its own node.
HybridSlam::Stand HybridSlam::AddNode(int64_t stamp_ns, const std::optional<Stand>& stand) {
  const int node = int(graph_.nodes.size());
  frames_since_model_ = 0;
  graph_.nodes.push_back({stamp_ns, {}, Matrix6d::Zero()});
  Stand own{node, {}, Matrix6d::Zero(), false, false, 0, 0};
  if (!stand) return own;
  const GraphNode& from = graph_.nodes[size_t(stand->model)];
  graph_.nodes.back().X_WC = from.X_WC * stand->X_MC;
  graph_.nodes.back().covariance = CovarianceOfProduct(stand->X_MC, from.covariance, stand->covariance);
  graph_.links.push_back({stand->model, node, stand->X_MC, stand->covariance, false, 1, stand->dead_reckoned});
  own.inliers = stand->inliers;
  return own;
}

/// The robust features of a view are known: it may be linked with, if it is one of a model.
void HybridSlam::Settle(const RobustView& view) {
  if (waiting_.empty() || waiting_.front().stamp_ns != view.stamp_ns) return;
  models_.push_back(MakeMetricModel(view.features, waiting_.front().depth, calibration_, options_.sight.models));
  waiting_.pop_front();
  const int model = int(models_.size()) - 1;
  search_.Add(models_.back().features.descriptors);
  std::vector<GraphLink> loops = FindLoops(model);
  if (options_.correction == LoopCorrection::kGraph && !loops.empty()) DropImplausible(loops);
  graph_.links.insert(graph_.links.end(), loops.begin(), loops.end());
  if (options_.correction == LoopCorrection::kGraph) {
    LinkFartherBack(model);
    CorrectByGraph(model);
  } else if (!loops.empty()) {
    CorrectBySemiConsensus(model, loops);
  }
}

/// Only where both links agree: who walks by in front of both views is no measurement.
void HybridSlam::LinkFartherBack(int model) {
  constexpr double kChi2 = 22.46;  // 99.9 % of six degrees of freedom
  Pose X_FT;
  Matrix6d covariance = Matrix6d::Zero();
  for (int from = model - 1; from >= 0 && from >= model - 1 - options_.links_back; --from) {
    const auto along = std::find_if(graph_.links.rbegin(), graph_.links.rend(), [&](const GraphLink& link) {
      return !link.loop && link.from == from && link.to == from + 1;
    });
    if (along == graph_.links.rend()) return;
    covariance = CovarianceOfProduct(X_FT, along->covariance, covariance);
    X_FT = along->X_FT * X_FT;
    if (from == model - 1) continue;
    const auto link = LinkModels(models_[size_t(from)], models_[size_t(model)], options_.links, random_);
    if (!link || InnovationChi2(X_FT, covariance, link->X_FT, link->covariance) > kChi2) continue;
    graph_.links.push_back({from, model, link->X_FT, link->covariance, false, 1, false});
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Loops.

std::vector<GraphLink> HybridSlam::FindLoops(int model) {
  std::vector<GraphLink> loops;
  for (const std::vector<int>& pass : search_.BestOfEachPass(models_[size_t(model)].features.descriptors)) {
    if (const auto loop = BestLinkWithPass(model, pass)) loops.push_back(*loop);
  }
  return loops;
}

/// Posters hang in many places. Without these the graph is solved in a fraction of the time.
void HybridSlam::DropImplausible(std::vector<GraphLink>& loops) const {
  const PoseGraphCovariances covariances(graph_);
  std::erase_if(loops, [&](const GraphLink& loop) {
    const Pose X_FT = graph_.nodes[size_t(loop.from)].X_WC.Inverse() * graph_.nodes[size_t(loop.to)].X_WC;
    const Matrix6d expected = covariances.Between(loop.from, loop.to);
    return InnovationChi2(X_FT, expected, loop.X_FT, loop.covariance) > options_.loop_gate;
  });
}

/// beta_i: "by comparing the 3 output RANSAC modeling results", that of the most inliers.
std::optional<GraphLink> HybridSlam::BestLinkWithPass(int model, const std::vector<int>& pass) {
  std::optional<GraphLink> best;
  int inliers = 0;
  for (const int earlier : pass) {
    const auto link = LinkModels(models_[size_t(earlier)], models_[size_t(model)], loop_links_, random_);
    if (!link || link->inliers <= inliers) continue;
    inliers = link->inliers;
    best = GraphLink{earlier, model, link->X_FT, link->covariance, true, 1, false};
  }
  return best;
}

void HybridSlam::CorrectByGraph(int model) {
  SolvePoseGraph(graph_);
  const PoseGraphCovariances covariances(graph_);
  for (size_t node = size_t(model); node < graph_.nodes.size(); ++node)
    graph_.nodes[node].covariance = covariances.Of(int(node));
}

void HybridSlam::CorrectBySemiConsensus(int model, const std::vector<GraphLink>& loops) {
  std::vector<LikelyPose> closed;  // L_loop_i = L_li + beta_i
  for (const GraphLink& loop : loops)
    closed.push_back({graph_.nodes[size_t(loop.from)].X_WC * loop.X_FT, loop.covariance});
  std::vector<Pose> chain;  // L_a ... L_b
  for (int node = last_corrected_; node <= model; ++node) chain.push_back(graph_.nodes[size_t(node)].X_WC);
  const Pose before = chain.back();
  ReachSemiConsensus(chain, MahalanobisMean(closed), options_.alpha);
  for (size_t k = 0; k < chain.size(); ++k) graph_.nodes[size_t(last_corrected_) + k].X_WC = chain[k];
  const Pose moved = chain.back() * before.Inverse();
  for (size_t node = size_t(model) + 1; node < graph_.nodes.size(); ++node)
    graph_.nodes[node].X_WC = moved * graph_.nodes[node].X_WC;
  last_corrected_ = model;
}

// ---------------------------------------------------------------------------------------------------------------------
// Answers.

/// A pose that the wheels alone gave is none of the camera's, unless a loop has confirmed it since.
bool HybridSlam::IsSeen(const Frame& frame) const {
  if (frame.answer.inliers > 0) return true;
  const int node = frame.stand->model;
  if (graph_.nodes[size_t(node)].stamp_ns != frame.answer.stamp_ns) return false;
  constexpr double kBelieved = 0.5;
  return node == 0 || std::any_of(graph_.links.begin(), graph_.links.end(), [&](const GraphLink& link) {
           return link.loop && link.to == node && link.trust > kBelieved;
         });
}

FrameEstimate HybridSlam::AnswerOf(const Frame& frame) const {
  FrameEstimate answer = frame.answer;
  if (!frame.stand) {
    if (!last_stands_) return answer;
    const FrameEstimate last = AnswerOf(frames_[*last_stands_]);
    answer.status = TrackingStatus::kLost;
    answer.predicted = last.pose ? last.pose : last.predicted;
    return answer;
  }
  const GraphNode& node = graph_.nodes[size_t(frame.stand->model)];
  const Pose X_WC = node.X_WC * frame.stand->X_MC;
  if (!IsSeen(frame)) {
    answer.status = TrackingStatus::kLost;
    answer.predicted = X_WC;
    return answer;
  }
  answer.status = TrackingStatus::kTracking;
  answer.pose = X_WC;
  if (options_.correction == LoopCorrection::kGraph)
    answer.covariance = CovarianceOfProduct(frame.stand->X_MC, node.covariance, frame.stand->covariance);
  return answer;
}

std::vector<FrameEstimate> HybridSlam::Finish() {
  for (const RobustView& view : robust_.Finish()) Settle(view);
  if (options_.correction == LoopCorrection::kGraph && graph_.nodes.size() > 1) {
    const PoseGraphCovariances covariances(graph_);
    for (size_t node = 0; node < graph_.nodes.size(); ++node) graph_.nodes[node].covariance = covariances.Of(int(node));
  }
  std::vector<FrameEstimate> answers;
  for (const Frame& frame : frames_) {
    answers.push_back(frame.stand ? AnswerOf(frame) : frame.answer);
    if (!frame.stand)
      answers.back().status = graph_.nodes.empty() ? TrackingStatus::kInitializing : TrackingStatus::kLost;
  }
  return answers;
}

void HybridSlam::CheckFits(const RouteMap& earlier) const {
  ModelsOf(earlier, calibration_, options_.sight.feature, options_.sight.models);
}

RouteMap HybridSlam::LearnedAfter(const RouteMap& earlier) const {
  MapMergeOptions options;
  options.search = options_.search;
  options.links = loop_links_;
  options.models = options_.sight.models;
  const RouteMap own = Learned();
  return MergeRouteMaps(earlier, own, calibration_, options, seed_).value_or(own);
}

RouteMap HybridSlam::Learned() const {
  RouteMap map;
  map.camera = calibration_.camera;
  map.feature = options_.sight.feature;
  map.X_BC = calibration_.odometry.X_BC;
  map.graph = graph_;
  for (const MetricModel& model : models_) map.views.push_back(ToMappedView(model));
  map.views.resize(graph_.nodes.size());
  return map;
}

}  // namespace gaitcam
