#include "algorithms/slam/system.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "algorithms/core/errors.h"
#include "algorithms/slam/settings.h"

namespace gaitcam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

SystemSetup SetupWith(const SystemSettings& settings = {}) {
  SystemSetup setup;
  setup.calibration.camera = CameraModel::FromHorizontalFov(320, 240, 60);
  setup.calibration.standing = StandingCamera{0.3, -Eigen::Vector3d::UnitY()};
  setup.settings = settings;
  return setup;
}

template <class Act>
std::string ErrorOf(Act act) {
  try {
    act();
  } catch (const BadInput& e) {
    return e.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

TEST(Systems, AreListedByNameAndCanAllBeMadeWithTheirDefaults) {
  const auto infos = ListSystems();
  ASSERT_FALSE(infos.empty());
  for (size_t i = 1; i < infos.size(); ++i) EXPECT_LT(infos[i - 1].name, infos[i].name);
  for (const SystemInfo& info : infos) {
    EXPECT_FALSE(info.description.empty());
    const auto system = MakeSystem(info.name, SetupWith(info.defaults));
    Observation black;
    black.stamp_ns = 42;
    black.image = {42, cv::Mat::zeros(240, 320, CV_8UC1)};
    const FrameEstimate answer = system->Track(black);
    EXPECT_EQ(answer.stamp_ns, 42) << info.name;
    EXPECT_EQ(answer.status, TrackingStatus::kInitializing) << info.name;
    EXPECT_FALSE(answer.pose) << info.name;
  }
}

TEST(Systems, AnUnknownNameIsAnsweredWithTheNearest) {
  EXPECT_THAT(ErrorOf([] { MakeSystem("sift_v0", SetupWith()); }), HasSubstr("did you mean sift_vo?"));
  EXPECT_THAT(ErrorOf([] { MakeSystem("cartographer", SetupWith()); }),
              AllOf(HasSubstr("known: "), HasSubstr("sift_vo")));
}

TEST(Systems, SettingsAreCheckedByNameAndValue) {
  EXPECT_NO_THROW(MakeSystem("sift_vo", SetupWith({{"ratio", 0.7}, {"max_features", 300}})));
  EXPECT_THAT(ErrorOf([] {
                MakeSystem("sift_vo", SetupWith({{"ration", 0.7}}));
              }),
              HasSubstr("sift_vo.ration: there is no such setting; did you mean ratio?"));
  EXPECT_THAT(ErrorOf([] {
                MakeSystem("sift_vo", SetupWith({{"ratio", 7}}));
              }),
              HasSubstr("sift_vo.ratio: 7 is not permitted; expected a number from 0.1 to 1"));
  EXPECT_THAT(ErrorOf([] {
                MakeSystem("sift_vo", SetupWith({{"max_features", 300.5}}));
              }),
              HasSubstr("sift_vo.max_features: 300.5 is not permitted; expected a whole number"));
  EXPECT_THAT(ErrorOf([] {
                MakeSystem("sift_vo", SetupWith({{"max_features", std::nan("")}}));
              }),
              HasSubstr("max_features"));
}

struct Inner {
  using DescribedTag = void;
  double depth = 2;
};
template <class Visitor>
void VisitFields(Visitor& visit, Inner& o) {
  visit("depth", o.depth, Positive(), "");
}

struct Outer {
  using DescribedTag = void;
  int count = 3;
  bool flag = true;
  std::string word = "a";
  Inner inner;
};
template <class Visitor>
void VisitFields(Visitor& visit, Outer& o) {
  visit("count", o.count, Between(0, 10), "");
  visit("flag", o.flag, Nested(), "");
  visit("word", o.word, OneOf({"a", "beta", "gamma"}), "");
  visit("inner", o.inner, Nested(), "");
}

TEST(Settings, ReachNumbersFlagsTextsAndNestedStructs) {
  EXPECT_EQ(SettingsOf(Outer()), (SystemSettings{{"count", 3}, {"flag", 1}, {"inner.depth", 2}, {"word", "a"}}));
  const Outer changed = OptionsFrom<Outer>({{"count", 5}, {"flag", 0}, {"inner.depth", 0.5}, {"word", "beta"}}, "x");
  EXPECT_EQ(changed.word, "beta");
  EXPECT_EQ(changed.count, 5);
  EXPECT_FALSE(changed.flag);
  EXPECT_EQ(changed.inner.depth, 0.5);
  EXPECT_THAT(ErrorOf([] {
                OptionsFrom<Outer>({{"flag", 2}}, "x");
              }),
              HasSubstr("x.flag: 2 is not permitted; expected 0 or 1"));
  EXPECT_FALSE(OptionsFrom<Outer>({{"flag", "false"}}, "x").flag);
  EXPECT_THAT(ErrorOf([] {
                OptionsFrom<Outer>({{"word", "bete"}}, "x");
              }),
              HasSubstr("x.word: \"bete\" is not permitted; expected one of a, beta, gamma (did you mean beta?)"));
  EXPECT_THAT(ErrorOf([] {
                OptionsFrom<Outer>({{"word", 4}}, "x");
              }),
              HasSubstr("x.word: 4 is not permitted; expected one of a, beta, gamma"));
  EXPECT_THAT(ErrorOf([] {
                OptionsFrom<Outer>({{"count", "many"}}, "x");
              }),
              HasSubstr("x.count: \"many\" is not permitted; expected a number from 0 to 10"));
  EXPECT_THAT(ErrorOf([] { OptionsFrom<Outer>({{"inner.depth", -1}}, "x"); }), HasSubstr("x.inner.depth: -1"));
  EXPECT_THAT(ErrorOf([] { OptionsFrom<Outer>({{"inner.dept", 1}}, "x"); }), HasSubstr("did you mean inner.depth?"));
}

}  // namespace
}  // namespace gaitcam
