#include <array>

#include "algorithms/odometry/keyframe_vo.h"
#include "tests/algorithms/odometry/odometry_trials.h"

namespace gaitcam {
namespace {

// What befalls a camera that moves sideways as in the other films: at one second it is ...
struct Ordeal {
  std::string name;
  Film film;
};

constexpr int kFrames = 46, kJumpAt = 30;

// ... carried 60 cm aside within a frame; the wall is 3 m away,
Film Carried() {
  const auto pose = [](double t) {
    Pose X_WC = SidewaysPose(t);
    if (t > (kJumpAt - 0.5) / 30) X_WC.translation.y() += 0.6;
    return X_WC;
  };
  return FilmPath(Room(), kCamera, kFrames, pose, 5, 2);
}

// ... shaken so that its frames are blurred by up to 25 px,
Film Shaken() {
  const auto pose = [](double t) {
    const Pose X_WC = SidewaysPose(t);
    const double shake = t > (kJumpAt - 0.5) / 30 ? 0.1 * std::sin(40 * t) : 0;
    return LookingForward(X_WC.translation, shake, -0.3, 0.5 * shake);
  };
  return FilmPath(Room(), kCamera, kFrames, pose, 30, 12);
}

// ... shown another room, whose floor and walls are of the same kind.
Film Elsewhere() {
  static const SyntheticScene other(2);
  Film film = FilmPath(Room(), kCamera, kFrames, SidewaysPose, 5, 2);
  const Film there = FilmPath(other, kCamera, kFrames, SidewaysPose, 5, 2);
  for (size_t i = kJumpAt; i < kFrames; ++i) film.frames[i] = there.frames[i];
  return film;
}

const std::vector<Ordeal>& Ordeals() {
  static const std::vector<Ordeal> ordeals = {{"Carried", Carried()}, {"Shaken", Shaken()}, {"Elsewhere", Elsewhere()}};
  return ordeals;
}

// Four standard deviations of the usual speed are the farthest that an odometry takes for a step. The unit is the
// median depth of the points known first, 2 m here, of the floor before the wall; the wall's make it 3.5 m later, and a
// young map may be off by a tenth. The way carried is 0.3 units, twice as far in a frame.
void ExpectNoUnmarkedJump(const std::vector<FrameEstimate>& frames, const std::string& which) {
  const FrameEstimate* last = nullptr;
  for (const FrameEstimate& frame : frames) {
    if (!frame.pose) continue;
    if (last && !frame.restarted) {
      const double apart_s = double(frame.stamp_ns - last->stamp_ns) * 1e-9;
      EXPECT_LT((frame.pose->translation - last->pose->translation).norm(),
                4 * LandmarkLocalizerOptions().usual_speed * 2 * apart_s)
          << which << ", at " << double(frame.stamp_ns) * 1e-9 << " s";
    }
    last = &frame;
  }
}

template <class Odometry>
Estimate ExpectNoUnmarkedJump(Odometry& vo, const Ordeal& ordeal) {
  const Estimate live = TrackAll(vo, ordeal.film.frames);
  for (int i = kJumpAt - 5; i < kJumpAt; ++i) EXPECT_TRUE(live.frames[size_t(i)].pose) << "the film begins well";
  ExpectNoUnmarkedJump(live.frames, "live");
  ExpectNoUnmarkedJump(vo.Finish(), "final estimate");
  return live;
}

class EveryOrdeal : public testing::TestWithParam<size_t> {
 protected:
  const Ordeal& ordeal() const { return Ordeals()[GetParam()]; }
  // Who was carried finds the way: by a marked jump, or in steps of which each can be believed.
  void ExpectFoundAgain(const Estimate& live) const {
    for (int i = 0; i < kJumpAt; ++i) EXPECT_FALSE(live.frames[size_t(i)].restarted) << i;
    if (ordeal().name != "Carried") return;
    constexpr int kLater = kJumpAt + 10;
    for (int i = kLater; i < kFrames; ++i) EXPECT_TRUE(live.frames[size_t(i)].pose) << i;
    Estimate rest = live;
    rest.frames.erase(rest.frames.begin() + kJumpAt, rest.frames.begin() + kLater);
    EXPECT_LT(AlignedError(rest, ordeal().film.truth).rmse_m, 0.03) << "5 % of the way carried";
  }
};

TEST_P(EveryOrdeal, MakesNoUnmarkedJump) {
  KeyframeVo vo(OneCamera(), KeyframeVoOptions::WithFeature("sift", 4), 1);
  ExpectFoundAgain(ExpectNoUnmarkedJump(vo, ordeal()));
}

TEST_P(EveryOrdeal, MakesNoUnmarkedJumpWithRotationsBeforeTheMap) {
  KeyframeVoOptions options = KeyframeVoOptions::WithFeature("sift", 4);
  options.rotation_before_map = true;
  KeyframeVo vo(OneCamera(), options, 1);
  ExpectFoundAgain(ExpectNoUnmarkedJump(vo, ordeal()));
}

// In the order of Ordeals(), which takes seconds to film.
std::string NameOf(const testing::TestParamInfo<size_t>& info) {
  const std::array<std::string, 3> names = {"Carried", "Shaken", "Elsewhere"};
  return names[info.param];
}

INSTANTIATE_TEST_SUITE_P(, EveryOrdeal, testing::Values(0, 1, 2), NameOf);

}  // namespace
}  // namespace gaitcam
