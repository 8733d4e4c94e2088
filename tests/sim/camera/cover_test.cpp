#include "sim/camera/cover.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/random.h"
#include "tests/sim/camera/film_scene.h"

namespace gaitcam {
namespace {

constexpr double kNear = 0.01;
const CameraModel kCoveredView = CameraModel::FromHorizontalFov(160, 120, 60);

/// A round core along the world's z, which is the picture's height.
std::array<Cover::Disc, 2> Pillar(double x, double y, double radius, double low = -2, double high = 2) {
  const Eigen::Vector3d a(radius, 0, 0), b(0, radius, 0);
  return {{{{x, y, low}, a, b}, {{x, y, high}, a, b}}};
}

bool Hides(const Cover& cover, const Eigen::Vector3d& center, double half) {
  const Eigen::Vector3d corner = Eigen::Vector3d::Constant(half);
  return cover.HidesBox(Pose(RotZ(0.4), center), -corner, corner);
}

TEST(Cover, HidesWhatStandsBehindAndNothingElse) {
  Cover cover(LookingAlongX({0, 0, 0}), kCoveredView, kNear);
  EXPECT_FALSE(Hides(cover, {3, 0, 0}, 0.1));
  cover.Add(Pillar(1, 0, 0.2));
  EXPECT_TRUE(Hides(cover, {3, 0, 0}, 0.1));
  EXPECT_TRUE(Hides(cover, {3, 0.3, 0.5}, 0.1));
  EXPECT_FALSE(Hides(cover, {0.6, 0, 0}, 0.1));  // before it
  EXPECT_FALSE(Hides(cover, {1, 0, 0}, 0.1));    // within it: nearer than the cut through its axis
  EXPECT_FALSE(Hides(cover, {3, 0.6, 0}, 0.1));  // looks out at the side
  EXPECT_FALSE(Hides(cover, {3, 1, 0}, 0.1));
  EXPECT_TRUE(Hides(cover, {3, 4, 0}, 0.1));   // beside the picture
  EXPECT_FALSE(Hides(cover, {0, 0, 0}, 0.1));  // about the camera
}

TEST(Cover, ADiscHidesWhenItsCoreIsSeenEndOn) {
  Cover cover(LookingAlongX({0, 0, 0}), kCoveredView, kNear);
  const Eigen::Vector3d a(0, 0.2, 0), b(0, 0, 0.2);
  cover.Add({{{{1, 0, 0}, a, b}, {{2, 0, 0}, a, b}}});
  EXPECT_TRUE(Hides(cover, {3, 0, 0}, 0.2));
  EXPECT_FALSE(Hides(cover, {3, 0, 0}, 0.5));
}

TEST(Cover, ACoreThatReachesTheCameraHidesNothing) {
  Cover cover(LookingAlongX({0, 0, 0}), kCoveredView, kNear);
  cover.Add(Pillar(0.1, 0, 0.2));
  const Eigen::Vector3d a(0, 0.2, 0), b(0, 0, 0.2);
  cover.Add({{{{-1, 0, 0}, a, b}, {{2, 0, 0}, a, b}}});
  EXPECT_FALSE(Hides(cover, {3, 0, 0}, 0.1));
}

// No ray to any point of a box that is said to be hidden misses all pillars.
TEST(Cover, NothingOfWhatIsHiddenCanBeSeen) {
  RandomStream random(1, "cover");
  int hidden = 0;
  for (int trial = 0; trial < 40; ++trial) {
    Cover cover(LookingAlongX({0, 0, 0}), kCoveredView, kNear);
    std::vector<Eigen::Vector3d> pillars;  // x, y, radius
    for (int i = 0; i < 12; ++i) {
      pillars.emplace_back(random.Uniform(0.8, 2.5), random.Uniform(-1, 1), random.Uniform(0.02, 0.25));
      cover.Add(Pillar(pillars.back().x(), pillars.back().y(), pillars.back().z()));
    }
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector3d center(random.Uniform(1, 5), random.Uniform(-2, 2), random.Uniform(-0.5, 0.5));
      if (!Hides(cover, center, 0.05)) continue;
      ++hidden;
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d half(corner & 1 ? 0.05 : -0.05, corner & 2 ? 0.05 : -0.05, corner & 4 ? 0.05 : -0.05);
        const Eigen::Vector3d p = center + RotZ(0.4) * half;
        const auto pixel = kCoveredView.Project(LookingAlongX({0, 0, 0}).Inverse() * p);
        if (!pixel || pixel->x() < -0.5 || pixel->x() > 159.5 || pixel->y() < -0.5 || pixel->y() > 119.5) continue;
        const bool covered = std::any_of(pillars.begin(), pillars.end(), [&](const Eigen::Vector3d& pillar) {
          // The segment from the camera to p passes within the pillar's radius of its axis.
          const Eigen::Vector2d axis = pillar.head<2>(), to = p.head<2>();
          const double along = std::clamp(axis.dot(to) / to.squaredNorm(), 0.0, 1.0);
          return (axis - along * to).norm() < pillar.z();
        });
        EXPECT_TRUE(covered) << trial << ": " << p.transpose();
      }
    }
  }
  EXPECT_GT(hidden, 300);
}

}  // namespace
}  // namespace gaitcam
