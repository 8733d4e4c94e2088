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

}  // namespace

TopoSlam::TopoSlam(const Calibration& calibration, const TopoSlamOptions& options)
    : options_(options),
      up_(calibration.imu, StandingUp(calibration)),
      layout_(LayoutFor(calibration.camera, StandingUp(calibration), options.width_px, options.height_px)),
      projection_(calibration.camera, StandingUp(calibration), layout_),
      encoder_(options.height_px, options.wavelet),
      map_(options.wavelet),
      filter_(options.loop),
      imu_(calibration.imu) {
  CheckFields(options, "topo_slam.");
  // Says at once what every view would.
  encoder_.OfView(cv::Mat::zeros(layout_.height_px, projection_.width_px(), CV_8UC1));
}

FrameEstimate TopoSlam::Track(const Observation& observation) {
  FrameEstimate estimate;
  estimate.stamp_ns = observation.stamp_ns;
  up_.Add(observation.imu, imu_.X_CI.rotation * gyro_bias_.bias());
  if (HasGyroscope() && !observation.scan && !builder_) steps_.Add(observation.joints, heading_rad());
  if (wants_scan_ || observation.scan) {
    FollowScan(observation);
    return estimate;
  }
  if (Rests(observation)) return estimate;
  Collect(observation);
  if (tested_ns_ < 0) tested_ns_ = observation.stamp_ns;
  if (double(observation.stamp_ns - tested_ns_) * 1e-9 >= options_.test_every_s) {
    tested_ns_ = observation.stamp_ns;
    Test(*candidate_, estimate);
    candidate_.reset();
  }
  return estimate;
}

void TopoSlam::Finish() {
  if (builder_ && builder_->missing_deg() == 0) EndScan();
}

void TopoSlam::FollowScan(const Observation& observation) {
  candidate_.reset();
  tested_ns_ = -1;
  if (wanted_ns_ < 0) {
    wanted_ns_ = observation.stamp_ns;
    asked_heading_rad_ = heading_rad();
  }
  if (observation.scan) {
    gyro_bias_.Stand(observation.imu);
    standing_samples_ += observation.imu.size();
    if (!wants_scan_) {  // the rest of a scan that has shown all
      scanned_ns_ = observation.stamp_ns;
      return;
    }
    if (!builder_) {
      builder_.emplace(projection_, layout_, options_.panorama);
      ahead_rad_ = HeadingAtScan(observation.scan->pan_rad);
      scan_began_ns_ = observation.stamp_ns;
    }
    builder_->Add(observation.image.pixels, observation.scan->pan_rad + observation.scan->body_turn_rad);
  } else if (builder_ && builder_->missing_deg() == 0) {
    scanned_ns_ = observation.stamp_ns;
    EndScan();  // between two sweeps, while the body turns, half of it is missing still
  } else if (double(observation.stamp_ns - wanted_ns_) * 1e-9 > options_.scan_patience_s) {
    gave_up_ = true;
  }
}

/// Of the body, which has come to a halt since it was asked. A gyroscope in the head has turned with it by `pan_rad`,
/// to where a sweep begins, so far that the two cannot be mistaken for each other.
double TopoSlam::HeadingAtScan(double pan_rad) const {
  const double turned = heading_rad() - asked_heading_rad_;
  return std::abs(turned - pan_rad) < std::abs(turned) ? heading_rad() - pan_rad : heading_rad();
}

void TopoSlam::EndScan() {
  LearnBias();
  Panorama panorama = builder_->Finish();
  here_.reset();
  if (const std::optional<KnownPlace> known = Recognise(panorama.image)) {
    CloseLoop(known->node, scan_began_ns_);
    LookFrom(panorama.image, reckoned_[size_t(known->node)].ahead_rad + known->bearing_rad);
  } else {
    AddNode(std::move(panorama));
  }
  builder_.reset();
  wants_scan_ = false;
  wanted_ns_ = -1;
}

/// Also what the heading has drifted by since the scan began is taken back.
void TopoSlam::LearnBias() {
  const Eigen::Vector3d before = gyro_bias_.bias();
  gyro_bias_.Learn();
  const Eigen::Vector3d more_C = imu_.X_CI.rotation * (gyro_bias_.bias() - before);
  if (HasGyroscope()) heading_offset_rad_ -= more_C.dot(up_.up_C()) * double(standing_samples_) / imu_.rate_hz;
  standing_samples_ = 0;
  heading_is_old_ = !gyro_bias_.learned();
}

/// The node that a panorama shows, turned as it may be: rather another one than the last. It says as much as all of its
/// views, so that nothing that was believed before counts beside it.
std::optional<TopoSlam::KnownPlace> TopoSlam::Recognise(const cv::Mat& panorama) {
  if (map_.size() == 0) return std::nullopt;
  const PanoramaSectors sectors = SectorsOf(encoder_, panorama, projection_.width_px());
  std::vector<PanoramaMatch> matches;
  std::vector<double> similarity;
  for (size_t node = 0; node < map_.size(); ++node) {
    matches.push_back(MatchPanorama(map_, node, sectors, options_.sector_slack_deg, TurnTo(node)));
    similarity.push_back(matches.back().similarity);
  }
  LoopFilterOptions all_around = options_.loop;
  all_around.threshold = options_.same_place;
  all_around.sharpness *= double(sectors.views.size());
  const LoopFilter::Belief belief = LoopFilter(all_around).Update(similarity, LeftOut(), graph_.links);
  const bool still_there = belief.best < 0 && similarity[size_t(last_)] > options_.same_place;
  const int node = still_there ? last_ : belief.best;
  const double bearing_rad = node < 0 ? 0 : -matches[size_t(node)].turn_px / layout_.px_per_rad();
  Record(belief, scan_began_ns_, std::remainder(bearing_rad, 2 * std::numbers::pi), panorama);
  if (node < 0) return std::nullopt;
  return KnownPlace{node, bearing_rad};
}

/// How far to the right the panorama that was just made lies in a node's, as the gyroscope has it.
std::optional<WaveletWindow> TopoSlam::TurnTo(size_t node) const {
  if (!KnowsHeading()) return std::nullopt;
  const double left_rad = ahead_rad_ - reckoned_[node].ahead_rad;
  return WaveletWindow{-left_rad * layout_.px_per_rad(), HeadingTolerancePx()};
}

void TopoSlam::Record(const LoopFilter::Belief& belief, int64_t stamp_ns, double bearing_rad, const cv::Mat& view) {
  graph_.tests.push_back({stamp_ns, belief.likelihood, belief.posterior, belief.best, bearing_rad, view});
}

/// From now on views are compared with what was seen here, a step aside of a known place: else the robot would look
/// around again at once. @param ahead_rad heading of the panorama's middle.
void TopoSlam::LookFrom(const cv::Mat& panorama, double ahead_rad) {
  here_ = Here{WaveletMap(options_.wavelet), ahead_rad};
  here_->map.Add(encoder_.OfPanorama(panorama));
  heading_offset_rad_ += std::remainder(ahead_rad - ahead_rad_, 2 * std::numbers::pi);
}

void TopoSlam::AddNode(Panorama panorama) {
  map_.Add(encoder_.OfPanorama(panorama.image));
  PlaceNode node;
  node.stamp_ns = scan_began_ns_;
  node.bytes = map_.bytes_per_place();
  node.panorama = panorama.image;
  graph_.nodes.push_back(node);
  reckoned_.push_back({steps_.position(), steps_.steps(), ahead_rad_});
  panorama.image.release();
  stitches_.push_back(panorama);
  const int added = int(graph_.nodes.size()) - 1;
  if (last_ >= 0) graph_.links.push_back({last_, added, false, scan_began_ns_});
  last_ = added;
  Forget();
}

/// Each time it recognises another place (step 4 of 4.5), also along a way that it has gone before.
void TopoSlam::CloseLoop(int node, int64_t stamp_ns) {
  if (node != last_) graph_.links.push_back({last_, node, true, stamp_ns});
  last_ = node;
  here_.reset();
  steps_.SetPosition(reckoned_[size_t(node)].position);
  reckoned_[size_t(node)].visited = steps_.steps();
  Forget();
}

void TopoSlam::Forget() {
  filter_.Reset();
  streak_ = 0;
  streak_best_ = -2;
}

/// A scan ends with the head looking anywhere; it turns back before the robot walks on.
bool TopoSlam::Rests(const Observation& observation) {
  if (scanned_ns_ < 0) return false;
  if (double(observation.stamp_ns - scanned_ns_) * 1e-9 < options_.rest_after_scan_s) return true;
  const auto on_one_leg = std::count_if(observation.joints.begin(), observation.joints.end(),
                                        [](const JointSample& s) { return s.left_contact != s.right_contact; });
  if (!observation.joints.empty() && 2 * size_t(on_one_leg) < observation.joints.size()) return true;
  scanned_ns_ = -1;
  return false;
}

double TopoSlam::Unrest(const Observation& observation) const {
  if (options_.steady == "double_support" && !observation.joints.empty()) {
    // Half of the time spent on one leg since the frame before.
    const auto both = std::count_if(observation.joints.begin(), observation.joints.end(),
                                    [](const JointSample& s) { return s.left_contact && s.right_contact; });
    return 1 - double(both) / double(observation.joints.size());
  }
  if (options_.steady == "gyro") {
    // Fastest turn while the shutter was open, as far as it was sensed.
    double fastest = 0;
    const double open_ns = 0.5e6 * observation.exposure_ms + 1e7;
    for (const ImuSample& sample : observation.imu) {
      if (std::abs(double(sample.stamp_ns - observation.stamp_ns)) <= open_ns)
        fastest = std::max(fastest, sample.angular_rate.norm());
    }
    return fastest;
  }
  return 0;
}

void TopoSlam::Collect(const Observation& observation) {
  const double unrest = Unrest(observation);
  if (candidate_ && candidate_->unrest < unrest) return;  // the later of equals
  candidate_ = Candidate{observation.image.pixels.clone(), up_.up_C(), observation.stamp_ns, unrest, up_.heading_rad()};
}

/// Nodes that the robot cannot be at: the last one, which no longer fits, and those that it has not come to by its
/// steps.
std::vector<bool> TopoSlam::LeftOut() const {
  std::vector<bool> left_out(map_.size());
  for (size_t node = 0; node < map_.size(); ++node) {
    const Reckoned& there = reckoned_[node];
    const double reach = options_.place_steps + options_.step_error * (steps_.steps() - there.visited);
    left_out[node] = int(node) == last_ || (steps_.position() - there.position).norm() > reach;
  }
  return left_out;
}

double TopoSlam::HeadingTolerancePx() const {
  return options_.heading_window_deg * std::numbers::pi / 180 * layout_.px_per_rad();
}

/// @param ahead_rad heading of the middle of the place's panorama; @param heading_rad of the view's.
WaveletMatch TopoSlam::Compare(const WaveletView& view, const WaveletMap& map, int place, double ahead_rad,
                               double heading_rad) const {
  if (!KnowsHeading()) return map.Query(view, size_t(place));
  const double middle = layout_.ColumnOf(heading_rad - ahead_rad);
  return map.Query(view, size_t(place), WaveletWindow{middle - 0.5 * (view.width_px - 1), HeadingTolerancePx()});
}

/// With the place that was seen all around, or recognised, last.
WaveletMatch TopoSlam::CompareHere(const WaveletView& view, double heading_rad) const {
  const WaveletMap& map = here_ ? here_->map : map_;
  const int place = here_ ? 0 : last_;
  return heading_is_old_ ? map.Query(view, size_t(place)) : Compare(view, map, place, AheadHere(), heading_rad);
}

double TopoSlam::AheadHere() const { return here_ ? here_->ahead_rad : reckoned_[size_t(last_)].ahead_rad; }

double TopoSlam::BearingOf(const WaveletMatch& match) const {
  const double middle = match.left_px + 0.5 * (projection_.width_px() - 1);
  return std::remainder(layout_.AzimuthOf(middle), 2 * std::numbers::pi);
}

/// By what the last place shows, where the gyroscope's bias is not known. Away from where it was scanned bearings err,
/// now to one side, now to the other.
void TopoSlam::SetHeading(double bearing_rad, double turned_rad) {
  constexpr double kGain = 0.2;
  const double seen = AheadHere() + bearing_rad;
  const double error = std::remainder(seen - (turned_rad + heading_offset_rad_), 2 * std::numbers::pi);
  heading_offset_rad_ += (heading_is_old_ ? 1 : kGain) * error;
  heading_is_old_ = false;
}

void TopoSlam::Test(const Candidate& candidate, FrameEstimate& estimate) {
  const cv::Mat view = options_.level_views ? projection_.ProjectView(candidate.image, candidate.up_C)
                                            : projection_.ProjectView(candidate.image);
  const WaveletView signature = encoder_.OfView(view);
  const double heading = candidate.heading_rad + heading_offset_rad_;
  std::vector<WaveletMatch> matches;
  std::vector<double> similarity;
  const WaveletMatch here = CompareHere(signature, heading);
  const WaveletSignature& first = signature.shifts.front();
  estimate.features = first.columns() * first.bits_per_column();
  estimate.inliers = int(std::lround((1 - here.disagreement) * estimate.features));
  for (int node = 0; node < int(map_.size()); ++node) {
    matches.push_back(Compare(signature, map_, node, reckoned_[size_t(node)].ahead_rad, heading));
    similarity.push_back(matches.back().similarity);
  }
  const std::vector<bool> left_out = LeftOut();
  double most = 0;
  for (size_t node = 0; node < map_.size(); ++node) most = left_out[node] ? most : std::max(most, similarity[node]);
  const bool at_last = here.similarity >= options_.loop.threshold;  // step 2 of 4.5: still at the last node
  if (at_last && !gyro_bias_.learned()) SetHeading(BearingOf(here), candidate.heading_rad);
  if (at_last && most < options_.clearer * here.similarity) {
    Forget();
    return;
  }
  const LoopFilter::Belief belief = filter_.Update(similarity, left_out, graph_.links);
  Record(belief, candidate.stamp_ns, belief.best < 0 ? 0 : BearingOf(matches[size_t(belief.best)]), view);
  if (!at_last || belief.best >= 0) Decide(belief.best, candidate.stamp_ns);
}

void TopoSlam::Decide(int best, int64_t stamp_ns) {
  streak_ = best == streak_best_ ? streak_ + 1 : 1;
  streak_best_ = best;
  if (streak_ < options_.persist) return;
  streak_ = 0;
  streak_best_ = -2;
  if (best < 0 || options_.look_around) {
    wants_scan_ = true;
  } else {
    CloseLoop(best, stamp_ns);
  }
}

std::string TopoSlam::Failure() const {
  if (!graph_.nodes.empty() && !gave_up_) return {};
  if (builder_) {
    return "topo_slam: a scan left " + std::to_string(builder_->missing_deg()) + " of 360 deg unseen, after " +
           std::to_string(builder_->frames()) + " frames";
  }
  return "topo_slam: it asked for a scan and none came: it needs a robot that looks around as it is asked to, not a "
         "recorded walk";
}

}  // namespace gaitcam
