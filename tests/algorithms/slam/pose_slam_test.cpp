#include "algorithms/slam/pose_slam.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "algorithms/core/errors.h"
#include "tests/algorithms/odometry/odometry_trials.h"

namespace gaitcam {
namespace {

Calibration LoopRig() {
  Calibration calibration = OneCamera();
  calibration.right = calibration.camera;
  calibration.X_LR = Pose(Eigen::Matrix3d(RotZ(0.01) * RotY(-0.01)), {0.1, 0, 0});
  return calibration;
}

/// 50 cm to the side and back to where it began, in 40 frames.
const Film& ThereAndBack() {
  static const Film film = [] {
    constexpr double kTurn_s = 0.667, kTimesAsFast = 3;
    const auto pose = [](double t_s) { return SidewaysPose(kTimesAsFast * (t_s < kTurn_s ? t_s : 2 * kTurn_s - t_s)); };
    const Calibration rig = LoopRig();
    Film both = FilmPath(Room(), rig.camera, 40, pose, 5, 1);
    const Film right = FilmPath(
        Room(), *rig.right, 40, [&](double t_s) { return pose(t_s) * rig.X_LR; }, 5, 1);
    for (size_t i = 0; i < both.frames.size(); ++i) both.frames[i].right = right.frames[i].image;
    return both;
  }();
  return film;
}

PoseSlamOptions Small() {
  PoseSlamOptions options;
  options.odometry.sensitivity = 4;
  options.odometry.window = 2;
  options.odometry.policy.keyframe_displacement_px = 0;  // every frame is one
  options.loops.loop_inliers = 12;                       // small pictures have few points
  options.loops.loop_inlier_pct = 10;
  options.node_m = 0.03;
  options.near_m = 0.1;
  options.loop_gain = 0;  // a walk of a second has hardly drifted
  return options;
}

struct Mapped {
  std::vector<FrameEstimate> frames;
  PoseGraph graph;

  explicit Mapped(const PoseSlamOptions& options, const Calibration& rig = LoopRig()) {
    PoseSlam slam(rig, options, 1);
    for (const Observation& frame : ThereAndBack().frames) slam.Track(frame);
    frames = slam.Finish();
    graph = slam.graph();
  }
  int Loops(double trust) const {
    return int(std::count_if(graph.links.begin(), graph.links.end(),
                             [&](const GraphLink& link) { return link.loop && link.trust == trust; }));
  }
  double EndError_m() const {
    const auto& truth = ThereAndBack().truth;
    const Pose motion = frames.front().pose->Inverse() * *frames.back().pose;
    return (motion.translation - (truth.front().pose.Inverse() * truth.back().pose).translation).norm();
  }
};

TEST(PoseSlam, ClosesLoopsWhereItComesBackAndKnowsItselfBetterThere) {
  const Mapped closed(Small());
  PoseSlamOptions open_options = Small();
  open_options.loop_candidates = 0;
  const Mapped open(open_options);
  EXPECT_GE(closed.Loops(1), 1);
  EXPECT_EQ(open.Loops(1) + open.Loops(0), 0);
  EXPECT_LT(closed.EndError_m(), 0.01);  // a pixel is 14 mm on the wall
  const auto size = [](const Mapped& mapped) { return mapped.frames.back().covariance->topLeftCorner<3, 3>().trace(); };
  EXPECT_LE(size(closed), size(open));
}

TEST(PoseSlam, KeepsNoPoseTwice) {
  const Mapped mapped(Small());
  EXPECT_LT(mapped.graph.nodes.size(), size_t(mapped.graph.candidates));
  for (size_t n = 1; n + 1 < mapped.graph.nodes.size(); ++n) {
    bool has_loop = false, is_near = false;
    for (const GraphLink& link : mapped.graph.links)
      has_loop |= link.loop && (link.from == int(n) || link.to == int(n));
    for (size_t m = 0; m < n; ++m) {
      const Pose between = mapped.graph.nodes[m].X_WC.Inverse() * mapped.graph.nodes[n].X_WC;
      // The limit, and what the graph may have moved since.
      is_near |= between.translation.norm() < 0.8 * Small().node_m;
    }
    EXPECT_TRUE(has_loop || !is_near) << "node " << n;
  }
}

TEST(PoseSlam, FalseLoopsAreFound) {
  PoseSlamOptions options = Small();
  options.false_loops = 1;
  const Mapped mapped(options);
  EXPECT_GE(mapped.Loops(0), 1);
  EXPECT_EQ(mapped.Loops(1), 0);
  EXPECT_LT(mapped.EndError_m(), 0.02);  // as the odometry alone
}

TEST(PoseSlam, WithoutLoopsItIsTheOdometry) {
  PoseSlamOptions options = Small();
  options.loop_candidates = 0;
  const Mapped mapped(options);
  StereoVo odometry(LoopRig(), options.odometry, 1);
  for (const Observation& frame : ThereAndBack().frames) odometry.Track(frame);
  const std::vector<FrameEstimate> frames = odometry.Finish();
  ASSERT_EQ(frames.size(), mapped.frames.size());
  for (size_t i = 0; i < frames.size(); ++i) {
    ASSERT_EQ(frames[i].pose.has_value(), mapped.frames[i].pose.has_value());
    if (!frames[i].pose) continue;
    EXPECT_LT(Minus(*frames[i].pose, *mapped.frames[i].pose).norm(), 1e-6);
  }
}

/// A focal length that is told wrongly, by as much as the calibration says that it may be. To first order and by a part
/// of the points, and both films are tracked with different outliers: a fifth of the largest error is allowed. The rig
/// is not adjusted, which would follow the wrong lens. On this way back by the same places a chain without loops has
/// nearly the same errors.
TEST(PoseSlam, SaysWhatAWrongLensDoesToItsPoses) {
  Calibration right_lens = LoopRig();
  right_lens.lens.focal = 0.02;
  Calibration wrong_lens = right_lens;
  for (CameraModel* camera : {&wrong_lens.camera, &*wrong_lens.right}) camera->fx *= 1.02, camera->fy *= 1.02;
  PoseSlamOptions options = Small();
  options.odometry.rig_rotation_deg = 0;
  const Mapped with_right(options, right_lens), with_wrong(options, wrong_lens);
  EXPECT_GE(with_right.Loops(1), 1);
  double most_m = 0, most_rad = 0, off_m = 0, off_rad = 0;
  for (size_t i = 0; i < with_right.frames.size(); ++i) {
    const Vector6d found = Minus(*with_right.frames[i].pose, *with_wrong.frames[i].pose);
    const Vector6d off = found - with_right.frames[i].common_errors.col(0);
    most_m = std::max(most_m, found.head<3>().norm());
    most_rad = std::max(most_rad, found.tail<3>().norm());
    off_m = std::max(off_m, off.head<3>().norm());
    off_rad = std::max(off_rad, off.tail<3>().norm());
  }
  EXPECT_LT(off_m, 0.2 * most_m);
  EXPECT_LT(off_rad, 0.2 * most_rad);
}

TEST(StereoLoops, AViewLooksMostLikeTheKeyframeTakenWhereItStands) {
  const StereoRig rig = StereoRig::Of(LoopRig());
  const cv::Ptr<cv::Feature2D> detector = MakeFeature2d("sift", 4);
  StereoLoops loops({}, {}, 1);
  for (const int frame : {0, 10, 19, 39}) {  // to the side, and back to where it began
    StereoView view = DetectInBoth(ThereAndBack().frames[size_t(frame)], rig, *detector, 500);
    UndoMotion(rig.left, {}, {}, {}, view.left);
    UndoMotion(rig.right, {}, {}, {}, view.right);
    view.partner = MatchStereo(rig, view.left, view.right, {});
    loops.Keep(frame, view, rig);
  }
  const std::map<int, double> likeness = loops.LikeLast();
  ASSERT_EQ(likeness.size(), 3u) << "not like itself";
  EXPECT_GT(likeness.at(0), 2 * likeness.at(10));
  EXPECT_GT(likeness.at(0), 2 * likeness.at(19));
  loops.Drop(10);
  EXPECT_EQ(loops.LikeLast().count(10), 0u);
  EXPECT_EQ(loops.LikeLast().at(0), likeness.at(0)) << "what is not kept still tells how rare a word is";
}

TEST(PoseSlam, RefusesWhatItsOptionsDoNotAllow) {
  PoseSlamOptions options;
  options.false_loops = 2;
  EXPECT_THROW(PoseSlam(LoopRig(), options, 1), BadOption);
  EXPECT_THROW(PoseSlam(OneCamera(), PoseSlamOptions(), 1), BadInput);
}

}  // namespace
}  // namespace gaitcam
