/// Topological SLAM with a camera that pans, after chapter 4 of the thesis: the robot walks and compares what it sees
/// with the place it saw all around last; where that no longer fits, or a known place fits clearly better, it asks a
/// Bayes filter over all places (loop_filter.h), stops, looks all around, and closes a loop or adds a node.
///
/// The system acts: it asks the body for a scan where it wants one, and at its first frame.
///
/// Beyond the thesis:
/// - Of the frames between two tests the steadiest is taken; it is laid onto the panorama's cylinder by gravity, as the
///   camera sways; and what is to happen must be so in `persist` tests in a row.
/// - A single view only raises the question. A panorama, which shows as much as eight of them, answers it
///   (panorama_match.h); the thesis closes loops by single views (`look_around: false`).
/// - Steps counted along the gyroscope's heading (step_reckoning.h) say where the robot cannot be: rooms that look the
///   same are told apart by nothing else. The bias is learned in each scan. Without joints or gyroscope any place may
///   be the one.

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/observation.h"
#include "algorithms/geometry/gyro_bias.h"
#include "algorithms/geometry/up_direction.h"
#include "algorithms/odometry/step_reckoning.h"
#include "algorithms/places/loop_filter.h"
#include "algorithms/places/panorama.h"
#include "algorithms/places/panorama_match.h"
#include "algorithms/places/wavelet_signature.h"

namespace gaitcam {

struct TopoSlamOptions {
  using DescribedTag = void;
  int width_px = 720;  ///< Of the panoramas; 1830 as the KHR-1HV's.
  int height_px = 160;
  WaveletOptions wavelet;
  PanoramaOptions panorama;
  LoopFilterOptions loop;
  bool look_around = true;       ///< A loop is closed by a panorama alone, never by a single view.
  double same_place = 1.65;      ///< Two panoramas more similar than this are of one place; loop.threshold is a view's.
  double sector_slack_deg = 15;  ///< So far a panorama's sectors may slide, see panorama_match.h.
  double place_steps = 20;       ///< A place is not where the robot is if it lies farther away, by counted steps, ...
  double step_error = 0.04;      ///< ... than this and such a share of the steps made since it was visited.
  double test_every_s = 0.3;     ///< Time between two tests.
  std::string steady = "gyro";   ///< Which frame of that time is tested.
  bool level_views = true;       ///< By gravity, as the IMU feels it; without one the standing camera's.
  /// A view lies so near to where the gyroscope says; 180: anywhere, as in the thesis.
  double heading_window_deg = 45;
  /// A known place that fits so many times better than the last one, which may fit still, is asked about; 1000: never,
  /// as in the thesis.
  double clearer = 1.2;
  int persist = 3;  ///< Tests in a row that must say the same.
  /// The head looks ahead again before tests go on: so long, and until a foot is lifted.
  double rest_after_scan_s = 2;
  double scan_patience_s = 120;  ///< A scan that takes longer than this failed.
};

template <class Visitor>
void VisitFields(Visitor& visit, TopoSlamOptions& o) {
  visit("width_px", o.width_px, Between(16, 100000), "of a panorama");
  visit("height_px", o.height_px, Between(8, 10000), "of a panorama");
  visit("wavelet", o.wavelet, Nested(), "the signature of a place");
  visit("panorama", o.panorama, Nested(), "how frames of a scan are stitched");
  visit("loop", o.loop, Nested(), "how known places are recognised");
  visit("look_around", o.look_around, Nested(), "a loop is closed by a panorama alone, never by a single view");
  visit("same_place", o.same_place, Between(1.0, 1000.0), "panoramas more similar than this are of one place");
  visit("sector_slack_deg", o.sector_slack_deg, Between(0.0, 90.0), "so far a sector of a panorama may slide");
  visit("place_steps", o.place_steps, Between(1.0, 1e6), "no place is recognised from farther away, in counted steps");
  visit("step_error", o.step_error, Between(0.0, 1000.0), "and this share of the steps made since it was visited");
  visit("test_every_s", o.test_every_s, Between(0.0, 1000.0), "time between two tests");
  visit("steady", o.steady, OneOf({"gyro", "double_support", "last"}), "which frame of that time is tested");
  visit("level_views", o.level_views, Nested(), "views are laid onto the cylinder by gravity");
  visit("heading_window_deg", o.heading_window_deg, Between(1.0, 180.0),
        "a view lies so near to the gyroscope's heading");
  visit("clearer", o.clearer, Between(1.0, 1000.0),
        "a place that fits so many times better than the last one is asked about though that fits still");
  visit("persist", o.persist, Between(1, 1000), "tests in a row that must say the same");
  visit("rest_after_scan_s", o.rest_after_scan_s, Between(0.0, 60.0), "after a scan, until the head looks ahead again");
  visit("scan_patience_s", o.scan_patience_s, Between(1.0, 1e5), "a scan that takes longer failed");
}

class TopoSlam {
 public:
  /// @throws BadOption; BadInput if the calibration does not say how the camera stands, or views are too narrow.
  TopoSlam(const Calibration& calibration, const TopoSlamOptions& options);
  TopoSlam(const TopoSlam&) = delete;
  TopoSlam& operator=(const TopoSlam&) = delete;

  /// A place has no pose: the estimate is empty, its status "initializing"; `features` is the number of bits compared
  /// in a test, `inliers` those that agree with the last place.
  FrameEstimate Track(const Observation& observation);
  /// After the last frame: a scan that had just ended counts still.
  void Finish();
  /// Whether a scan is asked for.
  bool wants_scan() const { return wants_scan_; }
  const PlaceGraph& graph() const { return graph_; }
  /// Why there is no map, or it is not complete; empty if it is.
  std::string Failure() const;

  /// Against straight ahead at the first frame, as it is believed, rad.
  double heading_rad() const { return up_.heading_rad() + heading_offset_rad_; }
  const PanoramaLayout& layout() const { return layout_; }
  /// What the stitch of each node was like; its image is empty.
  const std::vector<Panorama>& stitches() const { return stitches_; }

 private:
  struct Candidate {
    cv::Mat image;
    Eigen::Vector3d up_C;
    int64_t stamp_ns = 0;
    double unrest = 0;
    double heading_rad = 0;
  };

  struct KnownPlace {
    int node = 0;
    double bearing_rad = 0;  ///< Of straight ahead as the scan began, in the node's panorama.
  };
  struct Reckoned {
    Eigen::Vector2d position{0, 0};  ///< Steps.
    int visited = 0;                 ///< Steps made until the robot was there last.
    double ahead_rad = 0;            ///< Heading of the panorama's middle.
  };
  /// What was seen all around last, where that was a known place.
  struct Here {
    WaveletMap map;        ///< Of this one panorama.
    double ahead_rad = 0;  ///< Heading of its middle.
  };

  void FollowScan(const Observation& observation);
  double HeadingAtScan(double pan_rad) const;
  void LearnBias();
  std::optional<WaveletWindow> TurnTo(size_t node) const;
  bool HasGyroscope() const { return imu_.rate_hz > 0; }
  bool KnowsHeading() const { return HasGyroscope() && options_.heading_window_deg < 180; }
  double HeadingTolerancePx() const;
  void EndScan();
  std::optional<KnownPlace> Recognise(const cv::Mat& panorama);
  void Record(const LoopFilter::Belief& belief, int64_t stamp_ns, double bearing_rad, const cv::Mat& view);
  std::vector<bool> LeftOut() const;
  void LookFrom(const cv::Mat& panorama, double ahead_rad);
  void AddNode(Panorama panorama);
  void CloseLoop(int node, int64_t stamp_ns);
  bool Rests(const Observation& observation);
  void Collect(const Observation& observation);
  double Unrest(const Observation& observation) const;
  void Test(const Candidate& candidate, FrameEstimate& estimate);
  WaveletMatch Compare(const WaveletView& view, const WaveletMap& map, int place, double ahead_rad,
                       double heading_rad) const;
  WaveletMatch CompareHere(const WaveletView& view, double heading_rad) const;
  double AheadHere() const;
  double BearingOf(const WaveletMatch& match) const;
  void SetHeading(double bearing_rad, double turned_rad);
  void Forget();
  void Decide(int best, int64_t stamp_ns);

  TopoSlamOptions options_;
  UpDirection up_;
  GyroBias gyro_bias_;
  PanoramaLayout layout_;
  CylinderProjection projection_;
  WaveletEncoder encoder_;
  WaveletMap map_;
  LoopFilter filter_;
  PlaceGraph graph_;
  std::vector<Panorama> stitches_;

  ImuCalibration imu_;
  size_t standing_samples_ = 0;  ///< Of the IMU, since the bias was learned last.
  bool wants_scan_ = true;
  int64_t wanted_ns_ = -1, scan_began_ns_ = -1;
  std::optional<PanoramaBuilder> builder_;
  double asked_heading_rad_ = 0;  ///< As the scan was asked for, ...
  double ahead_rad_ = 0;          ///< ... and as it began.
  int64_t scanned_ns_ = -1;       ///< When the last scan was over; -1 once the robot has walked on.
  bool gave_up_ = false;

  std::optional<Candidate> candidate_;
  int64_t tested_ns_ = -1;
  std::vector<Reckoned> reckoned_;  ///< Of each node.
  double heading_offset_rad_ = 0;   ///< Heading is the gyroscope's and this.
  bool heading_is_old_ = true;      ///< A scan has passed since it was put right.
  std::optional<Here> here_;
  StepReckoning steps_;
  int last_ = -1;         ///< Node visited last.
  int streak_ = 0;        ///< Tests in a row that said ...
  int streak_best_ = -2;  ///< ... this; -2 none.
};

}  // namespace gaitcam
