#include "algorithms/slam/appearance_slam.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "algorithms/core/random.h"
#include "algorithms/slam/system.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;
constexpr int64_t kOneSecond_ns = 1'000'000'000;

/// A long wall of blobs, seen through a window that slides along it: 40 px from one second to the next.
class Wall {
 public:
  Wall() : picture_(240, 320 + 40 * kSeconds, CV_8UC1, cv::Scalar(128)) {
    RandomStream random(1, "wall");
    for (int k = 0; k < picture_.cols / 2; ++k) {
      const cv::Point middle(random.Index(picture_.cols), random.Index(picture_.rows));
      cv::circle(picture_, middle, 3 + random.Index(12), cv::Scalar(random.Index(256)), cv::FILLED, cv::LINE_AA);
    }
  }
  static constexpr int kSeconds = 25;

  /// As one sees it after so many seconds of walking.
  cv::Mat At(int second, RandomStream& noise) const {
    cv::Mat view = picture_(cv::Rect(40 * second, 0, 320, 240)).clone();
    for (uchar& pixel : cv::Mat_<uchar>(view)) pixel = cv::saturate_cast<uchar>(pixel + noise.Normal(0, 3));
    return view;
  }

 private:
  cv::Mat picture_;
};

/// Along the wall, and then along it again; a frame each half second.
PlaceGraph WalkTwice(System& system) {
  const Wall wall;
  RandomStream noise(2, "noise");
  for (int frame = 0; frame < 4 * Wall::kSeconds; ++frame) {
    Observation observation;
    observation.stamp_ns = frame * kOneSecond_ns / 2 + 7;
    observation.image = {observation.stamp_ns, wall.At(frame / 2 % Wall::kSeconds, noise)};
    EXPECT_EQ(system.Track(observation).features > 0, frame % 2 == 0);  // every second frame is a place
  }
  const FinalEstimate answer = system.Finish();
  EXPECT_EQ(answer.failure, "");
  return std::get<PlaceGraph>(answer.maps.at(0));
}

struct Choice {
  std::string name;
  SystemSettings settings;
};
/// All ways; a lap of the wall takes 25 s.
std::vector<Choice> Choices(double apart_s) {
  return {{"pirf_nav", {{"apart_s", apart_s}}},
          {"pirf_nav", {{"apart_s", apart_s}, {"robust", "none"}}},
          {"icgm_slam", {{"apart_s", apart_s}}},
          {"icgm_slam", {{"apart_s", apart_s}, {"icgm.direction", "double"}}}};
}

std::unique_ptr<System> MakeMapper(const Choice& choice) {
  SystemSetup setup;
  setup.calibration.camera = CameraModel::FromHorizontalFov(320, 240, 60);
  setup.settings = choice.settings;
  return MakeSystem(choice.name, setup);
}

TEST(AppearanceSlam, ASecondWalkClosesLoopsToTheFirst) {
  for (const Choice& choice : Choices(10)) {
    const PlaceGraph graph = WalkTwice(*MakeMapper(choice));
    ASSERT_EQ(graph.nodes.size(), size_t(2 * Wall::kSeconds)) << choice.name;
    EXPECT_EQ(graph.tests.size(), graph.nodes.size());
    int right = 0, wrong = 0, steps = 0;
    for (const PlaceLink& link : graph.links) {
      steps += !link.loop;
      if (!link.loop) EXPECT_EQ(link.to, link.from + 1);
      // Views of neighbouring places share seven eighths.
      if (link.loop) ++(std::abs(link.from - Wall::kSeconds - link.to) <= 1 ? right : wrong);
      EXPECT_EQ(link.stamp_ns, graph.nodes[size_t(std::max(link.from, link.to))].stamp_ns);
    }
    EXPECT_EQ(steps, 2 * Wall::kSeconds - 1);
    EXPECT_EQ(wrong, 0) << choice.name;
    EXPECT_GE(right, Wall::kSeconds * 8 / 10) << choice.name;
    for (const PlaceNode& node : graph.nodes) EXPECT_GT(node.bytes, 1000u);
  }
}

TEST(AppearanceSlam, WhatWasSeenShortlyBeforeIsNoLoop) {
  for (const Choice& choice : Choices(60)) {
    const PlaceGraph graph = WalkTwice(*MakeMapper(choice));
    for (const PlaceLink& link : graph.links) EXPECT_FALSE(link.loop);
    for (const PlaceTest& test : graph.tests) EXPECT_EQ(test.matched, -1);
  }
}

TEST(AppearanceSlam, ALaterFilmIsAskedAboutAndNotLearned) {
  const Wall wall;
  for (const IcgmDirection direction : {IcgmDirection::kSingle, IcgmDirection::kDouble}) {
    IcgmSlamOptions options;
    options.robust.icgm.direction = direction;
    AppearanceSlam slam(options, 1);
    RandomStream noise(3, "noise");
    const auto walk = [&] {
      for (int second = 0; second < Wall::kSeconds; ++second) {
        Observation observation;
        observation.stamp_ns = second * kOneSecond_ns;  // each film begins at 0
        observation.image = {observation.stamp_ns, wall.At(second, noise)};
        slam.Track(observation);
      }
    };
    walk();
    slam.StopLearning();
    const size_t links = slam.graph().links.size();
    ASSERT_EQ(slam.tests().size(), size_t(Wall::kSeconds));
    walk();
    slam.Finish();
    EXPECT_EQ(slam.tests().size(), size_t(2 * Wall::kSeconds));
    EXPECT_EQ(slam.graph().nodes.size(), size_t(Wall::kSeconds));
    EXPECT_EQ(slam.graph().links.size(), links);
    int right = 0;
    for (size_t k = size_t(Wall::kSeconds); k < slam.tests().size(); ++k) {
      const AppearanceTest& test = slam.tests()[k];
      EXPECT_EQ(test.first_places, Wall::kSeconds);
      EXPECT_LT(test.place, Wall::kSeconds);
      right += test.known && std::abs(test.place - int(k) % Wall::kSeconds) <= 1;
    }
    EXPECT_GE(right, Wall::kSeconds * 8 / 10);
  }
}

TEST(AppearanceSlam, SameFramesGiveTheSameLinks) {
  const Choice choice = Choices(10).back();
  const PlaceGraph a = WalkTwice(*MakeMapper(choice)), b = WalkTwice(*MakeMapper(choice));
  ASSERT_EQ(a.links.size(), b.links.size());
  for (size_t k = 0; k < a.links.size(); ++k) EXPECT_EQ(a.links[k].to, b.links[k].to);
}

TEST(AppearanceSlam, SaysWhatIsWrongInOneLine) {
  const auto error = [](const SystemSettings& settings) {
    return ErrorOf([&] { MakeMapper({"pirf_nav", settings}); });
  };
  EXPECT_THAT(error({{"feature", "surff"}}), HasSubstr("did you mean surf?"));
  EXPECT_THAT(error({{"dictionary.max_distance", 0}}), HasSubstr("pirf_nav.dictionary.max_distance"));
  EXPECT_THAT(error({{"apart", 3}}), HasSubstr("pirf_nav.apart"));
}

FeatureImage ViewOf(const Wall& wall, int second) {
  RandomStream noise(9, "noise");
  const cv::Mat image = wall.At(second, noise);
  return {image.size(), DetectFeatures(*MakeFeature2d("surf"), image, 200)};
}

TEST(RobustViews, ComeInOrderEachOnceAndWaitOnlyForWhatTheyNeed) {
  const Wall wall;
  for (const auto& [robust, direction, delay] : {std::tuple{Robustness::kNone, IcgmDirection::kSingle, 0},
                                                 {Robustness::kPirf, IcgmDirection::kSingle, 0},
                                                 {Robustness::kIcgm, IcgmDirection::kSingle, 0},
                                                 {Robustness::kIcgm, IcgmDirection::kDouble, 1}}) {
    RobustViewOptions options = RobustViewOptions::By(robust);
    options.icgm.direction = direction;
    RobustViews views(options, 1);
    std::vector<RobustView> ready;
    for (int second = 0; second < 6; ++second) {
      for (RobustView& view : views.Add(100 + second, ViewOf(wall, second))) ready.push_back(std::move(view));
      EXPECT_EQ(int(ready.size()), std::max(0, second + 1 - delay));
    }
    for (RobustView& view : views.Finish()) ready.push_back(std::move(view));
    ASSERT_EQ(ready.size(), 6u);
    for (int second = 0; second < 6; ++second) {
      const RobustView& view = ready[size_t(second)];
      EXPECT_EQ(view.stamp_ns, 100 + second);
      EXPECT_EQ(view.features.size(), view.features.descriptors.rows);
      EXPECT_LE(view.features.size(), ViewOf(wall, second).features.size());
      if (second >= 2) EXPECT_GT(view.features.size(), 20);
    }
    EXPECT_EQ(ready[0].features.size() > 0, robust == Robustness::kNone || delay == 1);  // the first has none before it
  }
}

TEST(RobustViews, LookingBothWaysKeepsMore) {
  const Wall wall;
  int single = 0, both = 0;  // features kept
  for (const IcgmDirection direction : {IcgmDirection::kSingle, IcgmDirection::kDouble}) {
    RobustViewOptions options = RobustViewOptions::By(Robustness::kIcgm);
    options.icgm.direction = direction;
    RobustViews views(options, 1);
    int& sum = direction == IcgmDirection::kDouble ? both : single;
    for (int second = 0; second < 10; ++second) {
      for (const RobustView& view : views.Add(second, ViewOf(wall, second))) sum += view.features.size();
    }
  }
  EXPECT_GT(both, single);
}

}  // namespace
}  // namespace gaitcam
