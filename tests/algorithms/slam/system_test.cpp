#include "algorithms/slam/system.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "algorithms/core/errors.h"
#include "algorithms/slam/settings.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// For systems that drive by a map; nobody finds himself in it.
std::shared_ptr<const RouteMap> MapOfOnePoint(const CameraModel& camera) {
  RouteMap map;
  map.camera = camera;
  map.feature = "surf";
  map.graph.nodes.emplace_back();
  MappedView view;
  view.keypoints.emplace_back(100.0F, 100.0F, 5.0F);
  view.descriptors = cv::Mat::ones(1, 64, CV_32FC1);
  view.depth_m = {1};
  map.views.push_back(view);
  return std::make_shared<const RouteMap>(map);
}

SystemSetup SetupWith(const SystemSettings& settings = {}) {
  SystemSetup setup;
  setup.calibration.camera = CameraModel::FromHorizontalFov(320, 240, 60);
  setup.calibration.right = setup.calibration.camera;
  setup.calibration.X_LR.translation.x() = 0.06;
  setup.calibration.standing = StandingCamera{0.3, -Eigen::Vector3d::UnitY()};
  setup.calibration.has_depth = true;
  setup.calibration.odometry.rate_hz = 50;
  setup.map = MapOfOnePoint(setup.calibration.camera);
  setup.settings = settings;
  return setup;
}

TEST(Systems, AreListedByNameAndCanAllBeMadeWithTheirDefaults) {
  const auto infos = ListSystems();
  ASSERT_FALSE(infos.empty());
  for (size_t i = 1; i < infos.size(); ++i) EXPECT_LT(infos[i - 1].name, infos[i].name);
  for (const SystemInfo& info : infos) {
    EXPECT_FALSE(info.description.empty());
    const auto system = MakeSystem(info.name, SetupWith(info.Defaults()));
    Observation black;
    black.stamp_ns = 42;
    black.image = {42, cv::Mat::zeros(240, 320, CV_8UC1)};
    black.right = black.image;
    black.depth = {42, cv::Mat::ones(240, 320, CV_32FC1)};
    const FrameEstimate answer = system->Track(black);
    EXPECT_EQ(answer.stamp_ns, 42) << info.name;
    EXPECT_EQ(answer.status, TrackingStatus::kInitializing) << info.name;
    EXPECT_FALSE(answer.pose) << info.name;
  }
}

TEST(Systems, WhatTheyNeedIsKnownWithoutBuildingThem) {
  EXPECT_EQ(InfoOfSystem("floor_slam").needs, std::vector{SensorNeed::kStandingCamera});
  EXPECT_EQ(InfoOfSystem("hybrid_slam").needs, std::vector{SensorNeed::kDepth});
  EXPECT_TRUE(InfoOfSystem("topo_slam").acts);
  EXPECT_FALSE(InfoOfSystem("mobif_vo_plus").acts);
  EXPECT_EQ(InfoOfSystem("hybrid_drive").map, MapUse::kNeeded);
  EXPECT_EQ(InfoOfSystem("hybrid_slam").map, MapUse::kTaken);
  EXPECT_THAT(ErrorOf([] { InfoOfSystem("sift_v0"); }), HasSubstr("did you mean sift_vo?"));
  for (const SystemInfo& info : ListSystems()) {
    for (const FieldInfo& option : info.options) {
      EXPECT_NO_THROW(MakeSystem(info.name, SetupWith({{option.key, option.default_value}})))
          << info.name << "." << option.key;
    }
  }
}

TEST(Systems, ASensorIsMissingExactlyWhenTheCalibrationHasNone) {
  const std::vector<SensorNeed> all = {SensorNeed::kStereo, SensorNeed::kDepth,    SensorNeed::kImu,
                                       SensorNeed::kJoints, SensorNeed::kOdometry, SensorNeed::kStandingCamera};
  Calibration calibration;
  EXPECT_EQ(MissingSensors(all, calibration, false), all);
  calibration.right.emplace();
  calibration.has_depth = true;
  EXPECT_EQ(MissingSensors(all, calibration, true),
            (std::vector{SensorNeed::kImu, SensorNeed::kOdometry, SensorNeed::kStandingCamera}));
  calibration.imu.rate_hz = 100;
  calibration.odometry.rate_hz = 50;
  calibration.standing.emplace();
  EXPECT_TRUE(MissingSensors(all, calibration, true).empty());
}

TEST(Systems, IcgmVoIsThesisVoWithAnotherDetectorAndAFilter) {
  SystemSettings settings = InfoOfSystem("icgm_vo").Defaults();
  EXPECT_EQ(settings.at("match_filter").text(), "icgm");
  EXPECT_EQ(settings.at("feature").text(), "surf");
  const SystemSettings thesis = InfoOfSystem("thesis_vo").Defaults();
  for (const char* key : {"match_filter", "feature"}) {
    EXPECT_FALSE(settings.at(key) == thesis.at(key)) << key;
    settings[key] = thesis.at(key);
  }
  EXPECT_EQ(settings, thesis);
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
              HasSubstr("sift_vo.ration: unknown key; did you mean ratio?"));
  EXPECT_THAT(ErrorOf([] {
                MakeSystem("sift_vo", SetupWith({{"ratio", 7}}));
              }),
              HasSubstr("sift_vo.ratio: 7 is not permitted; expected a number from 0.1 to 1"));
  EXPECT_THAT(ErrorOf([] {
                MakeSystem("sift_vo", SetupWith({{"max_features", 300.5}}));
              }),
              HasSubstr("sift_vo.max_features: \"300.5\" is not a whole number; expected a number"));
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

enum class Colour { kRed, kBlue };
constexpr auto WordsOf(Colour) { return std::array{EnumWord{Colour::kRed, "red"}, EnumWord{Colour::kBlue, "blue"}}; }

struct Outer {
  using DescribedTag = void;
  int count = 3;
  bool flag = true;
  std::string word = "a";
  Colour colour = Colour::kRed;
  Inner inner;
};
template <class Visitor>
void VisitFields(Visitor& visit, Outer& o) {
  visit("count", o.count, Between(0, 10), "");
  visit("flag", o.flag, Nested(), "");
  visit("word", o.word, OneOf({"a", "beta", "gamma"}), "");
  visit("colour", o.colour, EnumWords<Colour>(), "");
  visit("inner", o.inner, Nested(), "");
}

TEST(Options, DefaultsOfASystemAreItsSettings) {
  SystemInfo info;
  info.options = ListFields(Outer());
  EXPECT_EQ(info.Defaults(), SettingsOf(Outer()));
  EXPECT_EQ(info.options.size(), 5u);
}

TEST(Settings, ReachNumbersFlagsTextsAndNestedStructs) {
  EXPECT_EQ(SettingsOf(Outer()),
            (SystemSettings{{"colour", "red"}, {"count", 3}, {"flag", true}, {"inner.depth", 2}, {"word", "a"}}));
  EXPECT_EQ(OptionsFrom<Outer>({{"colour", "blue"}}, "x").colour, Colour::kBlue);
  EXPECT_THAT(ErrorOf([] {
                OptionsFrom<Outer>({{"colour", "blu"}}, "x");
              }),
              HasSubstr("x.colour: \"blu\" is not permitted; expected one of red, blue (did you mean blue?)"));
  EXPECT_THAT(ErrorOf([] {
                OptionsFrom<Outer>({{"colour", 1}}, "x");
              }),
              HasSubstr("x.colour: \"1\" is not permitted; expected one of red, blue"));
  const Outer changed = OptionsFrom<Outer>({{"count", 5}, {"flag", 0}, {"inner.depth", 0.5}, {"word", "beta"}}, "x");
  EXPECT_EQ(changed.word, "beta");
  EXPECT_EQ(changed.count, 5);
  EXPECT_FALSE(changed.flag);
  EXPECT_EQ(changed.inner.depth, 0.5);
  EXPECT_THAT(ErrorOf([] { OptionsFrom<Outer>({{"flag", 2}}, "x"); }), HasSubstr("x.flag: \"2\" is not true or false"));
  EXPECT_FALSE(OptionsFrom<Outer>({{"flag", "false"}}, "x").flag);
  EXPECT_THAT(ErrorOf([] {
                OptionsFrom<Outer>({{"word", "bete"}}, "x");
              }),
              HasSubstr("x.word: \"bete\" is not permitted; expected one of a, beta, gamma (did you mean beta?)"));
  EXPECT_THAT(ErrorOf([] {
                OptionsFrom<Outer>({{"word", 4}}, "x");
              }),
              HasSubstr("x.word: \"4\" is not permitted; expected one of a, beta, gamma"));
  EXPECT_THAT(ErrorOf([] {
                OptionsFrom<Outer>({{"count", "many"}}, "x");
              }),
              HasSubstr("x.count: \"many\" is not a whole number; expected a number from 0 to 10"));
  EXPECT_THAT(ErrorOf([] { OptionsFrom<Outer>({{"inner.depth", -1}}, "x"); }), HasSubstr("x.inner.depth: -1"));
  EXPECT_THAT(ErrorOf([] {
                OptionsFrom<Outer>({{"inner.dept", 1}}, "x");
              }),
              HasSubstr("x.inner.dept: unknown key; did you mean depth?"));
  EXPECT_THAT(ErrorOf([] { OptionsFrom<Outer>({{"inner", 1}}, "x"); }), HasSubstr("x.inner: expected a map"));
  EXPECT_THAT(ErrorOf([] {
                OptionsFrom<Outer>({{"inner", 1}, {"inner.depth", 1}}, "x");
              }),
              HasSubstr("x: inner is not a map and has no key depth"));
}

}  // namespace
}  // namespace gaitcam
