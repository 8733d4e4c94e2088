#include "algorithms/core/camera.h"

#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

CameraModel Distorted() {
  CameraModel camera = CameraModel::FromHorizontalFov(640, 480, 70);
  camera.k1 = -0.28;
  camera.k2 = 0.07;
  camera.p1 = 0.001;
  camera.p2 = -0.0007;
  return camera;
}

TEST(CameraModel, FieldOfViewSpansTheImageFromEdgeToEdge) {
  const CameraModel camera = CameraModel::FromHorizontalFov(320, 240, 60);
  const Eigen::Vector3d left_edge = camera.Unproject({-0.5, camera.cy});
  EXPECT_NEAR(std::atan(-left_edge.x()) * 180 / M_PI, 30.0, 1e-12);
  EXPECT_NEAR(camera.fx, 277.128129211, 1e-6);
}

TEST(CameraModel, UnprojectUndoesProject) {
  const CameraModel camera = Distorted();
  RandomStream random(1, "camera_test");
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector2d pixel(random.Uniform(0, 639), random.Uniform(0, 479));
    const Eigen::Vector3d ray = camera.Unproject(pixel);
    const double depth = random.Uniform(0.1, 10);
    // Newton stops at a step of 1e-13 in normalised units, times a focal length of some 450 px.
    EXPECT_LT((*camera.Project(depth * ray) - pixel).norm(), 1e-9);
  }
}

TEST(CameraModel, WhatLiesBehindTheCameraDoesNotProject) {
  EXPECT_FALSE(Distorted().Project({0.1, 0.2, -1}));
  EXPECT_FALSE(Distorted().Project({0.1, 0.2, 0}));
}

TEST(CameraModel, RefusesAnEmptyImage) {
  EXPECT_THROW(CameraModel().Check(), BadOption);
  EXPECT_NO_THROW(Distorted().Check());
}

}  // namespace
}  // namespace gaitcam
