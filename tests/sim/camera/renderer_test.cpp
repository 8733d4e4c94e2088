#include "sim/camera/renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "sim/camera/light.h"
#include "tests/sim/camera/film_scene.h"

namespace gaitcam {
namespace {

/// A model at rest with its renderer.
struct Stage {
  EglContext gl;
  MjModelPtr model;
  MjDataPtr data;
  Renderer renderer;

  explicit Stage(MjModelPtr m, const RendererOptions& options = {})
      : model(std::move(m)), data(mj_makeData(model.get())), renderer(model.get(), options) {
    mj_forward(model.get(), data.get());
  }
};

/// Mean position of the light in a picture of something bright on black.
Eigen::Vector2d CentreOfLight(const cv::Mat& bgr) {
  double sum = 0;
  Eigen::Vector2d moment(0, 0);
  for (int v = 0; v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      const double light = SrgbToLinear(bgr.at<cv::Vec3b>(v, u)[1] / 255.0);
      sum += light;
      moment += light * Eigen::Vector2d(u, v);
    }
  }
  return moment / sum;
}

CameraModel OffCentreCamera() {
  CameraModel camera = CameraModel::FromHorizontalFov(160, 120, 60);
  camera.cx += 11.3;
  camera.cy -= 7.6;
  return camera;
}

TEST(Renderer, TheCentreOfTheFirstPixelIsTheOrigin) {
  // A thin plate, square to the optical axis: its picture is its outline exactly, so its centre projects to the centre
  // of its light.
  Stage stage(FlyerModel("<geom type='box' pos='1 0.21 0.13' size='0.00001 0.05 0.04' rgba='1 1 1 1'/>"));
  const Pose X_WC = LookingAlongX({0, 0, 0});
  const Eigen::Vector3d centre(0.99999, 0.21, 0.13);
  const CameraModel centred = CameraModel::FromHorizontalFov(80, 60, 60);
  CameraModel off_centre = centred;
  off_centre.cx += 5.3;
  off_centre.cy -= 3.6;
  for (const CameraModel& camera : {centred, off_centre}) {
    const cv::Mat picture = stage.renderer.Picture(*stage.data, X_WC, camera, 64);
    // 64 samples in a row locate each edge, and so the middle of two, to 1/128 px in either direction: 0.011 px
    // together. A picture that is off by one of its own pixels is off by 1/64 px.
    EXPECT_NEAR((CentreOfLight(picture) - *camera.Project(X_WC.Inverse() * centre)).norm(), 0, 0.011);
  }
}

TEST(Renderer, AShiftedPictureLooksBesideThePixelCentres) {
  Stage stage(FlyerModel("<geom type='box' pos='1 0 0' size='0.001 0.05 0.04' rgba='1 1 1 1'/>"));
  const CameraModel camera = CameraModel::FromHorizontalFov(160, 120, 60);
  const Pose X_WC = LookingAlongX({0, 0, 0});
  stage.renderer.Update(*stage.data);
  cv::Mat bgrx;
  const auto picture_at = [&](const Eigen::Vector2d& shift) {
    stage.renderer.Draw(*stage.data, X_WC, camera, shift);
    stage.renderer.ReadColor(bgrx);
    return bgrx.clone();
  };
  // Looking two pixels to the right and one down moves the picture two to the left and one up.
  const cv::Mat straight = picture_at({0, 0}), beside = picture_at({2, 1});
  const cv::Mat inner = straight(cv::Rect(2, 0, 158, 119)),
                moved = beside(cv::Rect(0, 1, 158, 119));  // bottom row first
  EXPECT_EQ(cv::norm(inner, moved, cv::NORM_INF), 0);
}

TEST(Renderer, DrawsWhatMuJoCosOwnLoopDraws) {
  Stage stage(SpeckledRoom());
  const int width = 160, height = 120;
  const double fovy = stage.model->cam_fovy[0] * M_PI / 180;
  CameraModel camera;
  camera.width_px = width;
  camera.height_px = height;
  camera.fx = camera.fy = 0.5 * height / std::tan(0.5 * fovy);
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  const Pose X_WC = LookingAlongX({-0.3, 0.2, 0.5}) * Pose(RotX(-0.3) * RotY(0.4), {0, 0, 0});
  const Eigen::Quaterniond q = X_WC.rotation;
  const double qpos[] = {X_WC.translation.x(), X_WC.translation.y(), X_WC.translation.z(), q.w(), q.x(), q.y(), q.z()};
  std::copy(std::begin(qpos), std::end(qpos), stage.data->qpos);
  mj_forward(stage.model.get(), stage.data.get());
  const cv::Mat ours = stage.renderer.Picture(*stage.data, CameraPose(*stage.data, 0), camera);

  mjvScene scene;
  mjvOption option;
  mjvCamera fixed;
  mjrContext context;
  mjv_defaultScene(&scene);
  mjv_makeScene(stage.model.get(), &scene, 200);
  mjv_defaultOption(&option);
  mjv_defaultCamera(&fixed);
  fixed.type = mjCAMERA_FIXED;
  fixed.fixedcamid = 0;
  mjr_defaultContext(&context);
  stage.model->vis.quality.offsamples = 0;
  mjr_makeContext(stage.model.get(), &context, mjFONTSCALE_50);
  mjr_setBuffer(mjFB_OFFSCREEN, &context);
  scene.flags[mjRND_SHADOW] = scene.flags[mjRND_REFLECTION] = 0;
  mjv_updateScene(stage.model.get(), stage.data.get(), &option, nullptr, &fixed, mjCAT_ALL, &scene);
  mjr_render({0, 0, width, height}, &scene, &context);
  cv::Mat theirs(height, width, CV_8UC3);
  mjr_readPixels(theirs.data, nullptr, {0, 0, width, height}, &context);
  mjr_freeContext(&context);
  mjv_freeScene(&scene);
  cv::flip(theirs, theirs, 0);
  cv::cvtColor(theirs, theirs, cv::COLOR_RGB2BGR);

  // The projection is the same but for rounding; a pixel whose centre lies on an edge may fall to either side.
  cv::Mat difference;
  cv::absdiff(ours, theirs, difference);
  EXPECT_LE(cv::countNonZero(difference.reshape(1) > 2), 10);
  EXPECT_GT(cv::mean(ours)[0], 30);
}

TEST(Renderer, LeavingOutWhatIsBesideThePictureChangesNothing) {
  // With shadows on, nothing is left out; no light casts any here.
  RendererOptions keep_all;
  keep_all.shadows = true;
  const CameraModel camera = OffCentreCamera();
  std::vector<cv::Mat> pictures;
  for (const RendererOptions& options : {RendererOptions(), keep_all}) {
    Stage stage(SpeckledRoom(), options);
    for (int i = 0; i < 12; ++i) {
      const Pose X_WC(RotZ(0.55 * i) * LookingAlongX({0, 0, 0}).R() * RotX(0.2 * (i % 5 - 2)),
                      Eigen::Vector3d(0.1 * i, -0.05 * i, 0.3));
      pictures.push_back(stage.renderer.Picture(*stage.data, X_WC, camera));
    }
  }
  for (size_t i = 0; i < 12; ++i) EXPECT_EQ(cv::norm(pictures[i], pictures[i + 12], cv::NORM_INF), 0) << i;
}

TEST(Renderer, NearnessIsTheReciprocalDistanceAlongTheOpticalAxis) {
  // A wall whose face is the plane n.p = d.
  Stage stage(FlyerModel("<geom type='box' pos='3 0 0' euler='0 20 30' size='0.01 2 2'/>"));
  const CameraModel camera = OffCentreCamera();
  const Pose X_WC = LookingAlongX({0, 0, 0}) * Pose(RotZ(0.2), {0, 0, 0});
  stage.renderer.Update(*stage.data);
  stage.renderer.Draw(*stage.data, X_WC, camera);
  const cv::Mat nearness = stage.renderer.ReadNearness();
  const Eigen::Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(stage.data->geom_xmat);
  const Eigen::Vector3d n = R.col(0), on_face = Eigen::Vector3d(3, 0, 0) - 0.01 * n;
  int seen = 0;
  for (int v = 0; v < nearness.rows; ++v) {
    for (int u = 0; u < nearness.cols; ++u) {
      const Eigen::Vector3d ray = X_WC.R() * camera.Unproject({double(u), double(v)});
      const double z = n.dot(on_face) / n.dot(ray);
      const Eigen::Vector3d on_wall = R.transpose() * (z * ray - on_face);
      if (std::abs(on_wall.y()) > 1.99 || std::abs(on_wall.z()) > 1.99) continue;
      ++seen;
      // One step of a 24-bit depth buffer with near plane n is z^2 / (n 2^24): 0.1 mm at 4 m. OpenGL interpolates to a
      // few.
      EXPECT_NEAR(1 / nearness.at<float>(v, u), z, 3 * z * z / (stage.renderer.options().near_m * (1 << 24)))
          << u << ", " << v;
    }
  }
  EXPECT_GT(seen, 10000);
}

TEST(Renderer, NearnessIsZeroWhereNothingIs) {
  Stage stage(FlyerModel("<geom type='sphere' pos='1 0 0' size='0.1'/>"));
  stage.renderer.Update(*stage.data);
  stage.renderer.Draw(*stage.data, LookingAlongX({0, 0, 0}), CameraModel::FromHorizontalFov(64, 48, 60));
  const cv::Mat nearness = stage.renderer.ReadNearness();
  EXPECT_EQ(nearness.at<float>(0, 0), 0);
  EXPECT_NEAR(1 / nearness.at<float>(24, 32), 0.9, 0.002);
}

TEST(Renderer, KnowsWhichBodyAPixelSees) {
  Stage stage(FlyerModel("<geom type='box' pos='2 0 0' size='0.01 3 3'/>", "", {},
                         "<geom type='box' pos='0.1 0 1' size='0.05 0.05 0.05'/>"));
  const int flyer = mj_name2id(stage.model.get(), mjOBJ_BODY, "flyer");
  const CameraModel camera = CameraModel::FromHorizontalFov(64, 48, 60);
  // The flyer is at the origin with the world's axes, so its box stands at (0.1, 0, 1): look up at it, then away.
  const Pose up(Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero());
  stage.renderer.Update(*stage.data);
  stage.renderer.Draw(*stage.data, up, camera, Eigen::Vector2d::Zero(), 1, true);
  EXPECT_TRUE(stage.renderer.ShowsMovingBodies());
  const cv::Mat bodies = stage.renderer.Bodies(*stage.data);
  const Eigen::Vector2d box = *camera.Project({0.1, 0, 1});
  EXPECT_EQ(bodies.at<int>(int(box.y() + 0.5), int(box.x() + 0.5)), flyer);
  EXPECT_EQ(bodies.at<int>(0, 0), 0);
  stage.renderer.Draw(*stage.data, LookingAlongX({0, 0, 0}), camera);
  EXPECT_FALSE(stage.renderer.ShowsMovingBodies());
}

TEST(Renderer, WhatMovesIsSeenWhereItIsNow) {
  Stage stage(FlyerModel("", "", {}, "<geom type='box' size='0.001 0.03 0.03' rgba='1 1 1 1'/>"));
  const CameraModel camera = CameraModel::FromHorizontalFov(160, 120, 60);
  const Pose X_WC = LookingAlongX({-1, 0, 0});
  stage.renderer.Update(*stage.data);
  stage.data->qpos[1] = 0.2;
  mj_forward(stage.model.get(), stage.data.get());
  stage.renderer.Move(*stage.data);
  stage.renderer.Draw(*stage.data, X_WC, camera);
  cv::Mat bgrx, bgr;
  stage.renderer.ReadColor(bgrx);
  cv::flip(bgrx, bgrx, 0);
  cv::cvtColor(bgrx, bgr, cv::COLOR_BGRA2BGR);
  // One unshifted picture locates an edge to half a pixel.
  EXPECT_NEAR((CentreOfLight(bgr) - *camera.Project(X_WC.Inverse() * Eigen::Vector3d(0, 0.2, 0))).norm(), 0, 0.5);
}

TEST(Renderer, GrowsWithThePicture) {
  Stage stage(SpeckledRoom());
  const Pose X_WC = LookingAlongX({0, 0, 0.4});
  EXPECT_EQ(stage.renderer.Picture(*stage.data, X_WC, CameraModel::FromHorizontalFov(64, 48, 60)).cols, 64);
  const cv::Mat large = stage.renderer.Picture(*stage.data, X_WC, CameraModel::FromHorizontalFov(1000, 700, 60));
  EXPECT_EQ(large.size(), cv::Size(1000, 700));
  EXPECT_GT(cv::mean(large(cv::Rect(900, 600, 100, 100)))[0], 30);
}

TEST(Renderer, NeedsAContext) {
  const MjModelPtr model = FlyerModel("");
  EXPECT_THROW(Renderer{model.get()}, MissingResource);
}

TEST(LookAt, PutsThePointInTheMiddleWithUpUp) {
  const Pose X_WC = LookAt({1, 2, 0.5}, 3, 0.7, -0.3);
  const Eigen::Vector3d p = X_WC.Inverse() * Eigen::Vector3d(1, 2, 0.5);
  EXPECT_NEAR((p - Eigen::Vector3d(0, 0, 3)).norm(), 0, 1e-12);
  EXPECT_GT(X_WC.translation.z(), 0.5);                             // looks down from above
  EXPECT_LT((X_WC.Inverse() * Eigen::Vector3d(1, 2, 0.6)).y(), 0);  // higher is further up, y is down
}

}  // namespace
}  // namespace gaitcam
