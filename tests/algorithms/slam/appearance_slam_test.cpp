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

std::unique_ptr<System> MakePirfNav(SystemSettings settings = {}) {
  SystemSetup setup;
  setup.calibration.camera = CameraModel::FromHorizontalFov(320, 240, 60);
  setup.settings = std::move(settings);
  return MakeSystem("pirf_nav", setup);
}

TEST(AppearanceSlam, ASecondWalkClosesLoopsToTheFirst) {
  const PlaceGraph graph = WalkTwice(*MakePirfNav({{"apart_s", 10}}));
  ASSERT_EQ(graph.nodes.size(), size_t(2 * Wall::kSeconds));
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
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(right, Wall::kSeconds * 8 / 10);
  for (const PlaceNode& node : graph.nodes) EXPECT_GT(node.bytes, 1000u);
}

TEST(AppearanceSlam, WhatWasSeenShortlyBeforeIsNoLoop) {
  const PlaceGraph graph = WalkTwice(*MakePirfNav({{"apart_s", 60}}));
  for (const PlaceLink& link : graph.links) EXPECT_FALSE(link.loop);
  for (const PlaceTest& test : graph.tests) EXPECT_EQ(test.matched, -1);
}

TEST(AppearanceSlam, SameFramesGiveTheSameLinks) {
  const PlaceGraph a = WalkTwice(*MakePirfNav({{"apart_s", 10}})), b = WalkTwice(*MakePirfNav({{"apart_s", 10}}));
  ASSERT_EQ(a.links.size(), b.links.size());
  for (size_t k = 0; k < a.links.size(); ++k) EXPECT_EQ(a.links[k].to, b.links[k].to);
}

TEST(AppearanceSlam, SaysWhatIsWrongInOneLine) {
  EXPECT_THAT(ErrorOf([] { MakePirfNav({{"feature", "surff"}}); }), HasSubstr("did you mean surf?"));
  EXPECT_THAT(ErrorOf([] {
                MakePirfNav({{"dictionary.max_distance", 0}});
              }),
              HasSubstr("pirf_nav.dictionary.max_distance"));
  EXPECT_THAT(ErrorOf([] { MakePirfNav({{"apart", 3}}); }), HasSubstr("pirf_nav.apart"));
}

}  // namespace
}  // namespace gaitcam
