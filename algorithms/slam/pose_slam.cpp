#include "algorithms/slam/pose_slam.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/se3.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

/// Where the odometry lost track between two keyframes: what it assumes is known to this.
constexpr double kLostSigma_m = 0.5, kLostSigma_rad = 0.3;
/// What a link is uncertain by at least, so that it has an inverse: 0.1 mm and 0.001 deg.
constexpr double kLeastSigma_m = 1e-4, kLeastSigma_rad = 1.7e-5;

Matrix6d Isotropic(double sigma_m, double sigma_rad) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(sigma_m), Eigen::Vector3d::Constant(sigma_rad);
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace

PoseSlam::PoseSlam(const Calibration& calibration, const PoseSlamOptions& options, uint64_t seed)
    : options_(options),
      odometry_(calibration, options.odometry, seed),
      finder_(options.loops, calibration.lens, seed),
      random_(seed, "pose_slam") {
  CheckFields(options, "pose_slam.");
}

FrameEstimate PoseSlam::Track(const Observation& observation) {
  const FrameEstimate answer = odometry_.Track(observation);
  const int keyframe = int(odometry_.map().keyframes().size()) - 1;
  if (const StereoView* view = odometry_.keyframe_view()) {
    AddKeyframe(*view, observation.stamp_ns, answer.restarted);
  }
  frame_keyframes_.push_back(answer.pose || answer.predicted ? keyframe : -1);
  return Corrected(answer, frame_keyframes_.back());
}

// ---------------------------------------------------------------------------------------------------------------------
// Nodes.

void PoseSlam::AddKeyframe(const StereoView& view, int64_t stamp_ns, bool restarted) {
  const int keyframe = int(odometry_.map().keyframes().size()) - 1;
  begins_.push_back(restarted);
  ++graph_.candidates;
  if (keyframes_.size() > 1 && IsRedundant(keyframes_.size() - 1)) RemoveNode(keyframes_.size() - 1);
  keyframes_.push_back(keyframe);
  GraphNode node{stamp_ns, {}, Matrix6d::Zero()};
  node.X_WC = keyframes_.size() == 1 ? odometry_.map().keyframes().back()
                                     : graph_.nodes.back().X_WC * OdometryLink(keyframes_.size() - 1).X_FT;
  graph_.nodes.push_back(node);
  finder_.Keep(keyframe, view, odometry_.map().rig());
  Solve();
  CloseLoops(view);
}

/// Another node stands nearly as it does, and no loop needs it.
bool PoseSlam::IsRedundant(size_t node) const {
  const int keyframe = keyframes_[node];
  for (const Loop& loop : loops_) {
    if (loop.from == keyframe || loop.to == keyframe) return false;
  }
  const Pose& X_WC = graph_.nodes[node].X_WC;
  for (size_t other = 0; other < graph_.nodes.size(); ++other) {
    const Pose& X_WO = graph_.nodes[other].X_WC;
    if (other != node && (X_WO.translation - X_WC.translation).norm() < options_.node_m &&
        RotationAngle(X_WO.rotation, X_WC.rotation) < kRadPerDeg * options_.node_deg)
      return true;
  }
  return false;
}

/// The motion past it is the odometry's, from the node before to the one after.
void PoseSlam::RemoveNode(size_t node) {
  finder_.Drop(keyframes_[node]);
  keyframes_.erase(keyframes_.begin() + long(node));
  graph_.nodes.erase(graph_.nodes.begin() + long(node));
}

/// From the node before to this one, as the odometry has its keyframes now: those in its window still move.
GraphLink PoseSlam::OdometryLink(size_t node) const {
  const int from = keyframes_[node - 1], to = keyframes_[node];
  const StereoMap& map = odometry_.map();
  const Pose X_FT = map.keyframes()[size_t(from)].Inverse() * map.keyframes()[size_t(to)];
  const bool lost = std::find(begins_.begin() + from + 1, begins_.begin() + to + 1, true) != begins_.begin() + to + 1;
  const Matrix6d least = lost ? Isotropic(kLostSigma_m, kLostSigma_rad) : Isotropic(kLeastSigma_m, kLeastSigma_rad);
  return {int(node) - 1, int(node), X_FT, map.GrownBetween(from, to) + least, false, 1};
}

/// The last node at or before a keyframe.
int PoseSlam::NodeOf(int keyframe) const {
  const auto after = std::upper_bound(keyframes_.begin(), keyframes_.end(), keyframe);
  return int(after - keyframes_.begin()) - 1;
}

// ---------------------------------------------------------------------------------------------------------------------
// Links.

/// What the lenses have wrong is the same in all links: it has no part in how they are weighed, and is followed beside.
void PoseSlam::Solve() {
  graph_.links.clear();
  std::vector<CommonErrors> lens_errors;
  for (size_t node = 1; node < keyframes_.size(); ++node) {
    graph_.links.push_back(OdometryLink(node));
    lens_errors.push_back(odometry_.map().LensErrorsBetween(keyframes_[node - 1], keyframes_[node]));
  }
  for (const Loop& loop : loops_) {
    graph_.links.push_back({NodeOf(loop.from), NodeOf(loop.to), loop.motion.X_FT, loop.motion.covariance, true, 1});
    lens_errors.push_back(loop.motion.lens_errors);
  }
  SolvePoseGraph(graph_);
  const PoseGraphCovariances covariances(graph_);
  graph_.nodes.back().covariance = covariances.Of(int(graph_.nodes.size()) - 1);
  lens_errors_ = covariances.InCommon(lens_errors, LensErrors::ColsAtCompileTime);
}

/// Nodes that the newest one's camera may see the same as, those first that look most alike. What the odometry's window
/// still holds is no loop.
std::vector<PoseSlam::Candidate> PoseSlam::Candidates() const {
  const int newest = int(keyframes_.size()) - 1;
  const PoseGraphCovariances covariances(graph_);
  const std::map<int, double> likeness = finder_.LikeLast();
  constexpr double kSigmas = 2, kFarAway = 10;
  std::vector<Candidate> candidates;
  for (int node = 0; node < newest && keyframes_[size_t(node)] < odometry_.map().WindowBegin(); ++node) {
    Candidate candidate{node,
                        likeness.at(keyframes_[size_t(node)]),
                        graph_.nodes[size_t(node)].X_WC.Inverse() * graph_.nodes[size_t(newest)].X_WC,
                        {}};
    const double apart_m = candidate.X_FT.translation.norm();
    const double apart_rad = RotationAngle(Eigen::Quaterniond::Identity(), candidate.X_FT.rotation);
    if (apart_m > kFarAway * options_.near_m) continue;
    const LensErrors common = odometry_.map().LensErrorsBetween(keyframes_[size_t(node)], keyframes_.back());
    candidate.covariance = covariances.Between(node, newest) + common * common.transpose();
    const double sigma_m = LargestSigma(candidate.covariance.topLeftCorner<3, 3>());
    const double sigma_rad = LargestSigma(candidate.covariance.bottomRightCorner<3, 3>());
    if (apart_m > options_.near_m + kSigmas * sigma_m) continue;
    if (apart_rad > kRadPerDeg * options_.near_deg + kSigmas * sigma_rad) continue;
    candidates.push_back(candidate);
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.likeness > b.likeness; });
  if (candidates.size() > size_t(options_.loop_candidates)) candidates.resize(size_t(options_.loop_candidates));
  return candidates;
}

/// One loop at most per keyframe: the first that is found, is likely and tells enough.
void PoseSlam::CloseLoops(const StereoView& view) {
  for (const Candidate& candidate : Candidates()) {
    const int from = keyframes_[size_t(candidate.node)];
    auto motion = finder_.Match(from, view, odometry_.map().rig(), candidate.X_FT);
    if (!motion) continue;
    motion->covariance = LoopCovariance(from, keyframes_.back(), *motion);
    if (InnovationChi2(candidate.X_FT, candidate.covariance, motion->X_FT, motion->covariance) > options_.loop_gate)
      continue;
    if (InformationGain(candidate.covariance, motion->covariance) < options_.loop_gain) continue;
    Loop loop{from, keyframes_.back(), *motion};
    if (random_.Uniform() < options_.false_loops) Plant(loop.motion);
    loops_.push_back(loop);
    Solve();
    return;
  }
}

/// Its own images' errors hang together as a keyframe's do; and what it links are the keyframes as the odometry has
/// them, each of which is wrong by what its images made of it there.
Matrix6d PoseSlam::LoopCovariance(int from, int to, const LoopMotion& motion) const {
  const StereoMap& map = odometry_.map();
  return 0.5 * (map.PointsPerError(from) + map.PointsPerError(to)) * motion.covariance +
         CarryCovariance(map.OwnCovariance(from), motion.X_FT) + map.OwnCovariance(to);
}

/// A false loop as a place that looks alike makes one: some way and turn off, as sure of itself as a true one.
void PoseSlam::Plant(LoopMotion& motion) {
  constexpr double kOff_m = 0.5, kOff_rad = 0.3;
  Vector6d off;
  for (int i = 0; i < 6; ++i) off[i] = random_.Normal(0, i < 3 ? kOff_m : kOff_rad);
  motion.X_FT = Plus(motion.X_FT, off);
}

// ---------------------------------------------------------------------------------------------------------------------
// Frames.

/// Stands to its node as the odometry has it. Its error is the node's instead of that which the odometry had there.
FrameEstimate PoseSlam::Corrected(const FrameEstimate& odometry, int keyframe) const {
  FrameEstimate answer = odometry;
  if (keyframe < 0) return answer;
  const GraphNode& node = graph_.nodes[size_t(NodeOf(keyframe))];
  const int node_keyframe = keyframes_[size_t(NodeOf(keyframe))];
  const StereoMap& map = odometry_.map();
  const Pose& X_VN = map.keyframes()[size_t(node_keyframe)];  // V: the odometry's world
  const Pose X_WV = node.X_WC * X_VN.Inverse();
  if (answer.predicted) answer.predicted = X_WV * *answer.predicted;
  if (!answer.pose) return answer;
  const Pose X_NC = X_VN.Inverse() * *answer.pose;
  answer.pose = X_WV * *answer.pose;
  if (!answer.own_covariance) return answer;
  *answer.covariance +=
      CarryCovariance(node.covariance, X_NC) - CarryCovariance(map.SharedCovariance(node_keyframe), X_NC);
  CorrectLensErrors(size_t(NodeOf(keyframe)), X_NC, answer);
  return answer;
}

/// The node's by the graph in place of those that the odometry had there.
void PoseSlam::CorrectLensErrors(size_t node, const Pose& X_NC, FrameEstimate& answer) const {
  if (answer.common_errors.cols() == 0) return;
  const LensErrors by_odometry = odometry_.map().LensErrorsBetween(0, keyframes_[node]);
  *answer.covariance -= answer.common_errors * answer.common_errors.transpose();
  answer.common_errors += Adjoint(X_NC.Inverse()) * (lens_errors_[node] - by_odometry);
  *answer.covariance += answer.common_errors * answer.common_errors.transpose();
}

std::vector<FrameEstimate> PoseSlam::Finish() {
  std::vector<FrameEstimate> frames = odometry_.Finish();
  GAITCAM_ASSERT(frames.size() == frame_keyframes_.size());
  if (keyframes_.empty()) return frames;
  Solve();
  const PoseGraphCovariances covariances(graph_);
  for (size_t n = 0; n < graph_.nodes.size(); ++n) graph_.nodes[n].covariance = covariances.Of(int(n));
  for (size_t i = 0; i < frames.size(); ++i) frames[i] = Corrected(frames[i], frame_keyframes_[i]);
  return frames;
}

}  // namespace gaitcam
