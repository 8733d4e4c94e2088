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
      knows_heading_(calibration.imu.rate_hz > 0) {
  CheckFields(options, "topo_slam.");
  // Says at once what every view would.
  encoder_.OfView(cv::Mat::zeros(layout_.height_px, projection_.width_px(), CV_8UC1));
}

FrameEstimate TopoSlam::Track(const Observation& observation) {
  FrameEstimate estimate;
  estimate.stamp_ns = observation.stamp_ns;
  up_.Add(observation.imu);
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
  Panorama panorama = builder_->Finish();
  const int known = KnownPlace(panorama.image);
  if (known < 0) {
    AddNode(std::move(panorama));
  } else {
    CloseLoop(known, scan_began_ns_);
  }
  heading_is_old_ = true;
  builder_.reset();
  wants_scan_ = false;
  wanted_ns_ = -1;
}

/// The node that a panorama shows, turned as it may be, or -1.
int TopoSlam::KnownPlace(const cv::Mat& panorama) const {
  if (map_.size() == 0) return -1;
  // As a view that sees all around; some of it twice, as sub-shifts drop the first pixels.
  cv::Mat round;
  cv::hconcat(panorama, panorama.colRange(0, std::min(panorama.cols, options_.wavelet.square_px())), round);
  const std::vector<WaveletMatch> matches = map_.Query(encoder_.OfView(round));
  const auto best = std::max_element(matches.begin(), matches.end(), [](const WaveletMatch& a, const WaveletMatch& b) {
    return a.similarity < b.similarity;
  });
  return best->similarity > options_.same_place ? int(best - matches.begin()) : -1;
}

void TopoSlam::AddNode(Panorama panorama) {
  map_.Add(encoder_.OfPanorama(panorama.image));
  PlaceNode node;
  node.stamp_ns = scan_began_ns_;
  node.bytes = map_.bytes_per_place();
  node.panorama = panorama.image;
  graph_.nodes.push_back(node);
  node_heading_rad_.push_back(ahead_rad_);
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

WaveletMatch TopoSlam::Compare(const WaveletView& view, int node, double heading_rad) const {
  if (!knows_heading_ || options_.heading_window_deg >= 180) return map_.Query(view, size_t(node));
  const double middle = layout_.ColumnOf(heading_rad - node_heading_rad_[size_t(node)]);
  const double tolerance_rad = options_.heading_window_deg * std::numbers::pi / 180;
  return map_.Query(view, size_t(node),
                    WaveletWindow{middle - 0.5 * (view.width_px - 1), tolerance_rad * layout_.px_per_rad()});
}

double TopoSlam::BearingOf(const WaveletMatch& match) const {
  const double middle = match.left_px + 0.5 * (projection_.width_px() - 1);
  return std::remainder(layout_.AzimuthOf(middle), 2 * std::numbers::pi);
}

/// By what the last place shows. Away from where it was scanned bearings err, now to one side, now to the other.
void TopoSlam::SetHeading(double bearing_rad, double turned_rad) {
  constexpr double kGain = 0.2;
  const double seen = node_heading_rad_[size_t(last_)] + bearing_rad;
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
  const WaveletMatch here = heading_is_old_ ? map_.Query(signature, size_t(last_)) : Compare(signature, last_, heading);
  const WaveletSignature& first = signature.shifts.front();
  estimate.features = first.columns() * first.bits_per_column();
  estimate.inliers = int(std::lround((1 - here.disagreement) * estimate.features));
  for (int node = 0; node < int(map_.size()); ++node) {
    matches.push_back(Compare(signature, node, heading));
    similarity.push_back(matches.back().similarity);
  }
  const bool at_last = here.similarity >= options_.loop.threshold;  // step 2 of 4.5: still at the last node
  if (at_last) SetHeading(BearingOf(here), candidate.heading_rad);
  if (at_last && *std::max_element(similarity.begin(), similarity.end()) < options_.clearer * here.similarity) {
    Forget();
    return;
  }
  const LoopFilter::Belief belief = filter_.Update(similarity, last_, graph_.links);
  PlaceTest test;
  test.stamp_ns = candidate.stamp_ns;
  test.likelihood = belief.likelihood;
  test.posterior = belief.posterior;
  test.matched = belief.best;
  if (belief.best >= 0) test.bearing_rad = BearingOf(matches[size_t(belief.best)]);
  test.view = view;
  graph_.tests.push_back(std::move(test));
  if (!at_last || belief.best >= 0) Decide(belief.best, candidate.stamp_ns);
}

void TopoSlam::Decide(int best, int64_t stamp_ns) {
  streak_ = best == streak_best_ ? streak_ + 1 : 1;
  streak_best_ = best;
  if (streak_ < options_.persist) return;
  streak_ = 0;
  streak_best_ = -2;
  if (best < 0) {
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
