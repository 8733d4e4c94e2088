/// Topological SLAM with a camera that pans: Alberto Pretto, Visual-SLAM for Humanoid Robots, PhD thesis, University of
/// Padua, chapter 4, section 4.5.
///
/// The robot walks and compares its view with the last panorama. Where they no longer fit, or a known place fits
/// clearly better, a Bayes filter over all places is asked (loop_filter.h); then the robot stops, scans a panorama, and
/// closes a loop or adds a node. The system acts: it asks the body for scans (scan_controller.h), the first at its
/// first frame.
///
/// Beyond the thesis:
/// - Of the frames between two tests the steadiest is taken (steady_view.h); it is projected onto the panorama's
///   cylinder by gravity, as the camera sways; and `persist` tests in a row must agree.
/// - A view only raises the question. A panorama, which shows as much as eight views, answers it (panorama_match.h);
///   the thesis closes loops by single views (`look_around: false`).
/// - Dead reckoning by steps along the gyroscope's heading says where the robot cannot be (step_gate.h): rooms that
/// look
///   the same are told apart by nothing else. The bias is learned in each scan. Without joints or gyroscope any place
///   is possible.

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/observation.h"
#include "algorithms/geometry/gyro_heading.h"
#include "algorithms/places/loop_filter.h"
#include "algorithms/places/panorama.h"
#include "algorithms/places/place_map.h"
#include "algorithms/places/scan_controller.h"
#include "algorithms/places/steady_view.h"
#include "algorithms/slam/step_gate.h"
#include "algorithms/slam/topo_slam_options.h"

namespace gaitcam {

class TopoSlam {
 public:
  /// @throws BadOption; BadInput if the calibration does not say how the camera stands, or views are too narrow.
  TopoSlam(const Calibration& calibration, const TopoSlamOptions& options);
  TopoSlam(const TopoSlam&) = delete;
  TopoSlam& operator=(const TopoSlam&) = delete;

  /// A place has no pose: the estimate is empty, its status "initializing"; `features` is the number of bits compared
  /// in a test, `inliers` those that agree with the surroundings.
  FrameEstimate Track(const Observation& observation);
  /// After the last frame: a scan that had just ended counts.
  void Finish();
  /// Whether a scan is asked for.
  bool wants_scan() const { return scan_.wants_scan(); }
  const PlaceGraph& graph() const { return graph_; }
  /// Why there is no map, or it is not complete; empty if it is.
  std::string Failure() const;

  /// Against straight ahead at the first frame, as estimated, rad.
  double heading_rad() const { return heading_.heading_rad(); }
  const PanoramaLayout& layout() const { return layout_; }
  /// Of each node, how its panorama was stitched; `image` is empty.
  const std::vector<Panorama>& stitches() const { return stitches_; }

 private:
  struct KnownPlace {
    int node = 0;
    double bearing_rad = 0;  ///< Of straight ahead as the scan began, in the node's panorama.
  };
  /// Answers of tests: how many in a row were the same.
  struct Streak {
    static constexpr int kNone = -2;
    int answer = kNone, length = 0;
  };

  void EndScan(const ScanController::Scan& scan);
  std::optional<KnownPlace> Recognise(const ScanController::Scan& scan);
  void AddNode(const ScanController::Scan& scan);
  void CloseLoop(int node, int64_t stamp_ns);
  void Test(const SteadyView& candidate, FrameEstimate& estimate);
  void Decide(int best, int64_t stamp_ns);
  void Record(const LoopFilter::Belief& belief, int64_t stamp_ns, double bearing_rad, const cv::Mat& view);
  std::vector<bool> LeftOut() const;
  void Forget();

  TopoSlamOptions options_;
  PanoramaLayout layout_;
  CylinderProjection projection_;
  GyroHeading heading_;
  ScanController scan_;
  SteadyViewPicker steady_;
  PlaceMap places_;
  StepGate gate_;
  LoopFilter filter_;
  Streak streak_;
  PlaceGraph graph_;
  std::vector<Panorama> stitches_;
};

}  // namespace gaitcam
