#include "algorithms/odometry/map_initializer.h"

#include "tests/algorithms/odometry/odometry_trials.h"

namespace gaitcam {
namespace {

/// By each frame of SidewaysFilm() until there is a map.
/// @param turn of each frame, since the first
/// @returns the frame that began it; -1: none
template <class Turn>
int FirstMap(Turn turn) {
  const auto detector = MakeFeature2d("sift", 4);
  MapInitializer initializer(kCamera, {});
  RandomStream random(1, "first map");
  for (size_t i = 0; i < SidewaysFilm().frames.size(); ++i) {
    const FrameView view = ViewFrame(SidewaysFilm().frames[i].image.pixels, kCamera, *detector, 500, {0.5, 0});
    if (initializer.Add(view, {}, turn(int(i)), random) == MapInitializer::Result::kInitialized) return int(i);
  }
  return -1;
}

KnownTurn Turned(double rad) { return {Eigen::Quaterniond(RotY(rad)), 0.01}; }  // of a camera that does not turn

TEST(MapInitializer, AMotionThatTheGyroscopeContradictsBeginsNoMapUnlessItGoesOnToDoSo) {
  const int alone = FirstMap([](int) { return std::optional<KnownTurn>(); });
  ASSERT_GT(alone, 2);
  EXPECT_EQ(FirstMap([](int) { return Turned(0.02); }), alone) << "within what is known of it";
  EXPECT_EQ(FirstMap([&](int i) { return Turned(i == alone ? 0.2 : 0); }), alone + 1) << "a single motion is wrong";
  EXPECT_EQ(FirstMap([](int) { return Turned(0.2); }), alone + 5) << "it is the gyroscope that is wrong";
}

}  // namespace
}  // namespace gaitcam
