#include "algorithms/odometry/rotation_chain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "algorithms/core/random.h"
#include "algorithms/core/se3.h"

namespace gaitcam {
namespace {

using Rotation = RotationChain::Rotation;

Eigen::Vector3d Normal3(RandomStream& random, double sigma) {
  return {random.Normal() * sigma, random.Normal() * sigma, random.Normal() * sigma};
}

/// A head that nods and swings, seen by images that are wrong by 0.02 rad about each axis, while its turns are told to
/// 0.001 rad.
struct Walk {
  static constexpr double kImage = 0.02, kTurn = 0.001;
  std::vector<Eigen::Quaterniond> truth;
  std::vector<FrameTurn> turns;
  std::vector<Rotation> images;

  explicit Walk(int frames, const Eigen::Vector3d& bias = Eigen::Vector3d::Zero()) {
    RandomStream random(1, "rotation_chain_test");
    for (int k = 0; k < frames; ++k) {
      truth.push_back(ExpSo3({0.2 * std::sin(0.7 * k), 0.3 * std::cos(0.4 * k), 0.05 * k}));
      FrameTurn turn;
      turn.seconds = 0.1;
      if (k > 0) {
        const Eigen::Vector3d phi = LogSo3(truth[size_t(k) - 1].conjugate() * truth.back());
        turn.turn = phi + Normal3(random, kTurn) + turn.seconds * bias;
      }
      turn.sigma = kTurn;
      turn.spread = kImage * kImage * Eigen::Matrix3d::Identity();
      turns.push_back(turn);
      images.push_back(truth.back() * ExpSo3(Normal3(random, kImage)));
    }
  }

  /// Root mean square over the frames from the tenth on, rad.
  double Error(const std::vector<Rotation>& rotations) const {
    double sum = 0;
    for (size_t k = 10; k < rotations.size(); ++k)
      sum += LogSo3(truth[k].conjugate() * rotations[k].value()).squaredNorm();
    return std::sqrt(sum / double(rotations.size() - 10));
  }
};

std::vector<Rotation> Filtered(const Walk& walk, RotationChain& chain) {
  std::vector<Rotation> filtered;
  for (size_t k = 0; k < walk.truth.size(); ++k) filtered.push_back(chain.Add(walk.turns[k], walk.images[k], false));
  return filtered;
}

// The steady state of a scalar filter with these two deviations: sqrt(3 kImage kTurn) = 0.0077; smoothed, half its
// variance.
TEST(RotationChain, KnowsBetterThanItsImagesAndBestOfAllInTheEnd) {
  const Walk walk(200);
  RotationChain chain(0, 0);
  const double images = walk.Error(walk.images), live = walk.Error(Filtered(walk, chain)),
               final = walk.Error(chain.Smoothed(walk.images));
  EXPECT_NEAR(images, 0.035, 0.003);
  EXPECT_NEAR(live, 0.0077, 0.002);
  EXPECT_LT(final, 0.8 * live);
}

// The bias turns by 0.003 rad from frame to frame, as much as three standard deviations of a turn.
TEST(RotationChain, LearnsTheBiasOfTheGyroscope) {
  const Walk straight(200), biased(200, {0.03, -0.02, 0.01});
  RotationChain without(0, 0), unaware(0, 0), learning(0.02, 0);
  const double live = straight.Error(Filtered(straight, without));
  EXPECT_GT(biased.Error(Filtered(biased, unaware)), 2 * live) << "a bias that is not looked for";
  EXPECT_LT(biased.Error(Filtered(biased, learning)), 1.5 * live);
  EXPECT_LT(biased.Error(learning.Smoothed(biased.images)), 1.1 * straight.Error(without.Smoothed(straight.images)));
}

TEST(RotationChain, WithoutTurnsItIsTheImages) {
  Walk walk(20);
  for (FrameTurn& turn : walk.turns) turn.turn.reset();
  RotationChain chain(0, 0);
  const std::vector<Rotation> live = Filtered(walk, chain), final = chain.Smoothed(walk.images);
  for (size_t k = 0; k < 20; ++k) {
    EXPECT_TRUE(live[k]->isApprox(*walk.images[k])) << k;
    EXPECT_TRUE(final[k]->isApprox(*walk.images[k])) << k;
  }
}

TEST(RotationChain, TurnsOnWhereThereIsNoImage) {
  Walk walk(60);
  for (size_t k = 30; k < 60; ++k) walk.images[k].reset();
  RotationChain chain(0, 0);
  const std::vector<Rotation> live = Filtered(walk, chain);
  EXPECT_LT(LogSo3(walk.truth.back().conjugate() * live.back().value()).norm(), 0.03) << "30 turns: 0.0055 an axis";
}

/// An image is wrong along one axis alone, as of a camera that turned about it while it was exposed.
TEST(RotationChain, DoubtsAnImageAboutTheAxisThatTheCameraTurnedAbout) {
  FrameTurn still;
  still.turn = Eigen::Vector3d::Zero();
  still.sigma = 0.001;
  still.spread = 1e-6 * Eigen::Matrix3d::Identity();
  RotationChain chain(0, 0);
  for (int k = 0; k < 30; ++k) chain.Add(still, Eigen::Quaterniond::Identity(), false);
  FrameTurn blurred = still;
  blurred.spread(1, 1) = 0.02 * 0.02;
  const Eigen::Vector3d left = LogSo3(*chain.Add(blurred, ExpSo3({0.002, 0.02, 0}), false));
  EXPECT_GT(left.x(), 0.001) << "as good as the turns";
  EXPECT_LT(left.y(), 0.0002);
}

TEST(RotationChain, AWrongImageTurnsItLittle) {
  Walk walk(100);
  walk.images[60] = walk.truth[60] * ExpSo3({0, 1, 0});
  RotationChain chain(0, 0);
  const std::vector<Rotation> live = Filtered(walk, chain);
  EXPECT_LT(LogSo3(walk.truth[60].conjugate() * live[60].value()).norm(), 0.03);
}

TEST(RotationChain, AnotherMapBeginsAnew) {
  const Walk walk(40);
  const Eigen::Quaterniond R_NW = ExpSo3({0, 0, 1});  // into the new map
  RotationChain chain(0, 0);
  std::vector<Rotation> images = walk.images;
  for (size_t k = 0; k < 40; ++k) {
    if (k >= 20) images[k] = R_NW * *images[k];
    const Rotation live = chain.Add(walk.turns[k], images[k], k == 20);
    const Eigen::Quaterniond truth = (k >= 20 ? R_NW : Eigen::Quaterniond::Identity()) * walk.truth[k];
    EXPECT_LT(LogSo3(truth.conjugate() * live.value()).norm(), 0.1) << k;
  }
  const std::vector<Rotation> final = chain.Smoothed(images);
  EXPECT_LT(LogSo3(walk.truth[19].conjugate() * final[19].value()).norm(), 0.03);
  EXPECT_LT(LogSo3((R_NW * walk.truth[20]).conjugate() * final[20].value()).norm(), 0.03);
}

}  // namespace
}  // namespace gaitcam
