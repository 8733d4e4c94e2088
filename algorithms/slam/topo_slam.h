/// Topological SLAM with a camera that pans, after chapter 4 of the thesis: the robot walks and compares what it sees
/// with the place it saw all around last; where that no longer fits, it asks whether it is at a place that it knows
/// (loop_filter.h), and closes a loop, or stops, scans, and adds a node.
///
/// The system acts: it asks the body for a scan at each new place, and at its first frame.
///
/// Beyond the thesis: of the frames between two tests the steadiest is taken; it is laid onto the panorama's cylinder
/// by gravity, as the camera sways; and what is to happen must be so in `persist` tests in a row, be it a new place or
/// a loop; and a known place that fits clearly better than the last one is a loop though that one fits still.

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/observation.h"
#include "algorithms/geometry/up_direction.h"
#include "algorithms/places/loop_filter.h"
#include "algorithms/places/panorama.h"
#include "algorithms/places/wavelet_signature.h"

namespace gaitcam {

struct TopoSlamOptions {
  using DescribedTag = void;
  int width_px = 720;  ///< Of the panoramas; 1830 as the KHR-1HV's.
  int height_px = 160;
  WaveletOptions wavelet;
  PanoramaOptions panorama;
  LoopFilterOptions loop;
  double same_place = 1.6;      ///< Two panoramas more similar than this are of one place.
  double test_every_s = 0.3;    ///< Time between two tests.
  std::string steady = "gyro";  ///< Which frame of that time is tested.
  bool level_views = true;      ///< By gravity, as the IMU feels it; without one the standing camera's.
  double heading_window_deg =
      45;  ///< A view lies so near to where the gyroscope says; 180: anywhere, as in the thesis.
  /// A known place that fits so many times better than the last one, which may fit still, is tried as a loop; 1000:
  /// never, as in the thesis.
  double clearer = 1.2;
  int persist = 3;  ///< Tests in a row that must say the same.
  double rest_after_scan_s =
      2;  ///< The head looks ahead again before tests go on: so long, and until a foot is lifted.
  double scan_patience_s = 120;  ///< A scan that takes longer than this failed.
};

template <class Visitor>
void VisitFields(Visitor& visit, TopoSlamOptions& o) {
  visit("width_px", o.width_px, Between(16, 100000), "of a panorama");
  visit("height_px", o.height_px, Between(8, 10000), "of a panorama");
  visit("wavelet", o.wavelet, Nested(), "the signature of a place");
  visit("panorama", o.panorama, Nested(), "how frames of a scan are stitched");
  visit("loop", o.loop, Nested(), "how known places are recognised");
  visit("same_place", o.same_place, Between(1.0, 1000.0), "panoramas more similar than this are of one place");
  visit("test_every_s", o.test_every_s, Between(0.0, 1000.0), "time between two tests");
  visit("steady", o.steady, OneOf({"gyro", "double_support", "last"}), "which frame of that time is tested");
  visit("level_views", o.level_views, Nested(), "views are laid onto the cylinder by gravity");
  visit("heading_window_deg", o.heading_window_deg, Between(1.0, 180.0),
        "a view lies so near to the gyroscope's heading");
  visit("clearer", o.clearer, Between(1.0, 1000.0),
        "a place that fits so many times better than the last one is tried as a loop though that fits still");
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

  void FollowScan(const Observation& observation);
  double HeadingAtScan(double pan_rad) const;
  void EndScan();
  int KnownPlace(const cv::Mat& panorama) const;
  void AddNode(Panorama panorama);
  void CloseLoop(int node, int64_t stamp_ns);
  bool Rests(const Observation& observation);
  void Collect(const Observation& observation);
  double Unrest(const Observation& observation) const;
  void Test(const Candidate& candidate, FrameEstimate& estimate);
  WaveletMatch Compare(const WaveletView& view, int node, double heading_rad) const;
  double BearingOf(const WaveletMatch& match) const;
  void SetHeading(double bearing_rad, double turned_rad);
  void Forget();
  void Decide(int best, int64_t stamp_ns);

  TopoSlamOptions options_;
  UpDirection up_;
  PanoramaLayout layout_;
  CylinderProjection projection_;
  WaveletEncoder encoder_;
  WaveletMap map_;
  LoopFilter filter_;
  PlaceGraph graph_;
  std::vector<Panorama> stitches_;

  bool knows_heading_ = false;  ///< There is a gyroscope.
  bool wants_scan_ = true;
  int64_t wanted_ns_ = -1, scan_began_ns_ = -1;
  std::optional<PanoramaBuilder> builder_;
  double asked_heading_rad_ = 0;  ///< As the scan was asked for, ...
  double ahead_rad_ = 0;          ///< ... and as it began.
  int64_t scanned_ns_ = -1;       ///< When the last scan was over; -1 once the robot has walked on.
  bool gave_up_ = false;

  std::optional<Candidate> candidate_;
  int64_t tested_ns_ = -1;
  std::vector<double> node_heading_rad_;  ///< Straight ahead in each panorama.
  double heading_offset_rad_ = 0;         ///< Heading is the gyroscope's and this.
  bool heading_is_old_ = true;            ///< A scan has passed since it was put right.
  int last_ = -1;                         ///< Node visited last.
  int streak_ = 0;                        ///< Tests in a row that said ...
  int streak_best_ = -2;                  ///< ... this; -2 none.
};

}  // namespace gaitcam
