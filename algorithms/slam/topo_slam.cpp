#include "algorithms/slam/topo_slam.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gaitcam {
namespace {

Eigen::Vector3d StandingUp(const Calibration& calibration) {
  if (calibration.standing) return calibration.standing->up_C;
  throw BadInput("topo_slam: the calibration does not say how the camera stands (standing: height, up)");
}

TopoSlamOptions Checked(const TopoSlamOptions& options) {
  CheckFields(options, "topo_slam.");
  return options;
}

PlaceMap::Options MapOptions(const Calibration& calibration, const TopoSlamOptions& options) {
  PlaceMap::Options map{options.wavelet, std::nullopt, options.sector_slack_deg};
  if (calibration.imu.rate_hz > 0 && options.heading_window_deg < 180)
    map.heading_tolerance_deg = options.heading_window_deg;
  return map;
}

}  // namespace

TopoSlam::TopoSlam(const Calibration& calibration, const TopoSlamOptions& options)
    : options_(Checked(options)),
      layout_(LayoutFor(calibration.camera, StandingUp(calibration), options.width_px, options.height_px)),
      projection_(calibration.camera, StandingUp(calibration), layout_),
      heading_(calibration.imu, StandingUp(calibration)),
      scan_(projection_, layout_, {options.panorama, options.rest_after_scan_s, options.scan_patience_s}),
      steady_(options.steady, options.test_every_s),
      places_(projection_, layout_, MapOptions(calibration, options)),
      gate_({options.place_steps, options.step_error}),
      filter_(options.loop) {}

FrameEstimate TopoSlam::Track(const Observation& observation) {
  FrameEstimate estimate;
  estimate.stamp_ns = observation.stamp_ns;
  heading_.Add(observation.imu);
  if (observation.scan) {
    heading_.Stand(observation.imu);
  } else if (heading_.has_gyroscope() && scan_.state() != ScanController::State::kScanning) {
    gate_.Walk(observation.joints, heading_.heading_rad());
  }
  if (const auto scan = scan_.Add(observation, heading_.heading_rad())) EndScan(*scan);
  if (scan_.state() != ScanController::State::kWalking) {
    steady_.Reset();
  } else if (const auto view = steady_.Add(observation, heading_.up_C(), heading_.heading_rad())) {
    Test(*view, estimate);
  }
  return estimate;
}

void TopoSlam::Finish() {
  if (const auto scan = scan_.Finish()) EndScan(*scan);
}

// ---------------------------------------------------------------------------------------------------------------------
// A panorama decides.

void TopoSlam::EndScan(const ScanController::Scan& scan) {
  heading_.LearnBias();
  const std::optional<KnownPlace> known = Recognise(scan);
  if (!known) {
    AddNode(scan);
    return;
  }
  CloseLoop(known->node, scan.began_ns);
  // A step aside of a known place: compared with the node's own panorama, views would ask for another scan at once.
  const double ahead_rad = places_.ahead_rad(known->node) + known->bearing_rad;
  places_.SetSurroundings(scan.panorama.image, ahead_rad);
  heading_.Turn(std::remainder(ahead_rad - scan.ahead_rad, 2 * std::numbers::pi));
}

/// The node that a panorama shows, rather another one than the last. It says as much as all of its views, so what was
/// believed before does not count beside it.
std::optional<TopoSlam::KnownPlace> TopoSlam::Recognise(const ScanController::Scan& scan) {
  if (places_.size() == 0) return std::nullopt;
  const PanoramaSectors sectors = places_.Sectors(scan.panorama.image);
  const std::vector<PanoramaMatch> matches = places_.MatchNodes(sectors, scan.ahead_rad);
  std::vector<double> similarity;
  for (const PanoramaMatch& match : matches) similarity.push_back(match.similarity);
  LoopFilterOptions panoramic = options_.loop;
  panoramic.threshold = options_.same_place;
  panoramic.sharpness *= double(sectors.views.size());
  const LoopFilter::Belief belief = LoopFilter(panoramic).Update(similarity, LeftOut(), graph_.links);
  const bool still_there = belief.best < 0 && similarity[size_t(places_.last())] > options_.same_place;
  const int node = still_there ? places_.last() : belief.best;
  const double bearing_rad = node < 0 ? 0 : places_.BearingOf(matches[size_t(node)]);
  Record(belief, scan.began_ns, std::remainder(bearing_rad, 2 * std::numbers::pi), scan.panorama.image);
  if (node < 0) return std::nullopt;
  return KnownPlace{node, bearing_rad};
}

void TopoSlam::AddNode(const ScanController::Scan& scan) {
  const int before = places_.last();
  places_.AddNode(scan.panorama.image, scan.ahead_rad);
  gate_.AddNode();
  PlaceNode node;
  node.stamp_ns = scan.began_ns;
  node.bytes = places_.bytes_per_node();
  node.panorama = scan.panorama.image;
  graph_.nodes.push_back(node);
  stitches_.push_back(scan.panorama);
  stitches_.back().image.release();
  if (before >= 0) graph_.links.push_back({before, places_.last(), false, scan.began_ns});
  Forget();
}

/// Step 4 of 4.5, each time another place is recognised, also along a link that exists.
void TopoSlam::CloseLoop(int node, int64_t stamp_ns) {
  if (node != places_.last()) graph_.links.push_back({places_.last(), node, true, stamp_ns});
  places_.Visit(node);
  gate_.Visit(node);
  Forget();
}

// ---------------------------------------------------------------------------------------------------------------------
// A view asks.

void TopoSlam::Test(const SteadyView& candidate, FrameEstimate& estimate) {
  const cv::Mat view = options_.level_views ? projection_.ProjectView(candidate.image, candidate.up_C)
                                            : projection_.ProjectView(candidate.image);
  const WaveletView signature = places_.Encode(view);
  const std::optional<double> heading = heading_.stale() ? std::nullopt : std::optional<double>(candidate.heading_rad);
  const WaveletMatch here = places_.MatchSurroundings(signature, heading);
  const WaveletSignature& first = signature.shifts.front();
  estimate.features = first.columns() * first.bits_per_column();
  estimate.inliers = int(std::lround((1 - here.disagreement) * estimate.features));

  const std::vector<WaveletMatch> matches = places_.MatchNodes(signature, candidate.heading_rad);
  const std::vector<bool> left_out = LeftOut();
  std::vector<double> similarity;
  double max_similarity = 0;
  for (size_t node = 0; node < matches.size(); ++node) {
    similarity.push_back(matches[node].similarity);
    if (!left_out[node]) max_similarity = std::max(max_similarity, similarity[node]);
  }
  const bool at_last = here.similarity >= options_.loop.threshold;  // step 2 of 4.5: still at the last node
  // Away from where the panorama was scanned bearings err, now to one side, now to the other.
  if (at_last && !heading_.bias_is_known())
    heading_.Observe(places_.surroundings_ahead_rad() + places_.BearingOf(here), candidate.heading_rad);
  if (at_last && max_similarity < options_.clearer * here.similarity) {
    Forget();
    return;
  }
  const LoopFilter::Belief belief = filter_.Update(similarity, left_out, graph_.links);
  const double bearing_rad = belief.best < 0 ? 0 : places_.BearingOf(matches[size_t(belief.best)]);
  Record(belief, candidate.stamp_ns, bearing_rad, view);
  if (!at_last || belief.best >= 0) Decide(belief.best, candidate.stamp_ns);
}

void TopoSlam::Decide(int best, int64_t stamp_ns) {
  streak_ = {best, best == streak_.answer ? streak_.length + 1 : 1};
  if (streak_.length < options_.persist) return;
  streak_ = {};
  if (best < 0 || options_.look_around) {
    scan_.Ask();
  } else {
    CloseLoop(best, stamp_ns);
  }
}

void TopoSlam::Record(const LoopFilter::Belief& belief, int64_t stamp_ns, double bearing_rad, const cv::Mat& view) {
  graph_.tests.push_back({stamp_ns, belief.likelihood, belief.posterior, belief.best, bearing_rad, view});
}

/// Nodes where the robot cannot be: the last one, which no longer fits, and those out of reach.
std::vector<bool> TopoSlam::LeftOut() const {
  std::vector<bool> left_out;
  for (int node = 0; node < places_.size(); ++node) left_out.push_back(node == places_.last() || !gate_.InReach(node));
  return left_out;
}

void TopoSlam::Forget() {
  filter_.Reset();
  streak_ = {};
}

std::string TopoSlam::Failure() const {
  if (!graph_.nodes.empty() && !scan_.failed()) return {};
  return "topo_slam: " + scan_.MissingText();
}

}  // namespace gaitcam
