#include "algorithms/places/panorama_match.h"

#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "tests/algorithms/places/cylinder_world.h"

namespace gaitcam {
namespace {

constexpr int kSector = 114;  // a view of the ERS-7, 57 degrees

PanoramaLayout Layout() { return {}; }

cv::Mat Room(uint64_t seed) { return CylinderWorld(seed).Panorama(Layout()); }

cv::Mat Turned(const cv::Mat& panorama, int right_px) {
  if (right_px == 0) return panorama;
  cv::Mat turned;
  cv::hconcat(panorama.colRange(panorama.cols - right_px, panorama.cols),
              panorama.colRange(0, panorama.cols - right_px), turned);
  return turned;
}

/// As from a step aside: what lies to the left has come nearer to straight ahead, what lies to the right has gone away
/// from it, by at most `max_px`.
cv::Mat FromAside(const cv::Mat& panorama, double max_px) {
  cv::Mat map_x(panorama.size(), CV_32FC1), map_y(panorama.size(), CV_32FC1), aside;
  for (int y = 0; y < panorama.rows; ++y) {
    for (int x = 0; x < panorama.cols; ++x) {
      const double azimuth = 2 * std::numbers::pi * x / panorama.cols;
      map_x.at<float>(y, x) = float(x + max_px * std::sin(azimuth));
      map_y.at<float>(y, x) = float(y);
    }
  }
  cv::remap(panorama, aside, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_WRAP);
  return aside;
}

struct Fixture {
  WaveletEncoder encoder{160};
  WaveletMap map;

  explicit Fixture(int rooms) {
    for (int k = 0; k < rooms; ++k) map.Add(encoder.OfPanorama(Room(uint64_t(k + 1))));
  }
  std::vector<PanoramaMatch> Match(const cv::Mat& panorama, double slack_deg = 15,
                                   std::optional<WaveletWindow> turns = {}) const {
    const PanoramaSectors sectors = SectorsOf(encoder, panorama, kSector);
    std::vector<PanoramaMatch> matches;
    for (size_t k = 0; k < map.size(); ++k) matches.push_back(MatchPanorama(map, k, sectors, slack_deg, turns));
    return matches;
  }
};

TEST(PanoramaMatch, ARoomIsKnownHoweverItIsTurned) {
  const Fixture fixture(4);
  for (const int turn_px : {0, 100, 333, 600}) {
    const std::vector<PanoramaMatch> matches = fixture.Match(Turned(Room(2), turn_px));
    ASSERT_EQ(matches.size(), 4u);
    EXPECT_GT(matches[1].similarity, 6);
    // The known room lies so far to the left of what is seen; a view is found to a shift of 2 px.
    EXPECT_NEAR(std::remainder(matches[1].turn_px + turn_px, 720), 0, 2);
    // Of other rooms half of the bits agree by chance, which is 1, and more in the best of many windows.
    for (const size_t other : {0u, 2u, 3u}) EXPECT_LT(matches[other].similarity, 1.7);
  }
}

TEST(PanoramaMatch, AStepAsideBendsTheRingAndSectorsFollowIt) {
  const Fixture fixture(1);
  const cv::Mat aside = FromAside(Room(1), 40);  // 20 degrees to the sides
  const PanoramaMatch following = fixture.Match(aside, 15)[0], rigid = fixture.Match(aside, 0)[0];
  EXPECT_GT(following.similarity, 3);
  EXPECT_LT(rigid.similarity, 2);
  // To the left and to the right they slide apart, and cancel out: a fifth of the greatest slide at the most.
  EXPECT_NEAR(std::remainder(following.turn_px, 720), 0, 8);
}

TEST(PanoramaMatch, ARoomThatLooksTheSameTurnedIsFoundWhereTheHeadingSays) {
  cv::Mat half = Room(1).colRange(0, 360), room;
  cv::hconcat(half, half, room);  // the same after 180 degrees
  Fixture fixture(0);
  fixture.map.Add(fixture.encoder.OfPanorama(room));
  for (const double turn_px : {0.0, 360.0}) {
    const PanoramaMatch match = fixture.Match(room, 15, WaveletWindow{turn_px + 20, 90})[0];
    EXPECT_GT(match.similarity, 6);
    EXPECT_NEAR(std::remainder(match.turn_px - turn_px, 720), 0, 2);
  }
  // Where it does not lie it is not found.
  EXPECT_LT(fixture.Match(room, 15, WaveletWindow{180, 45})[0].similarity, 2);
}

TEST(PanoramaMatch, FewerSectorsAgreeTheMoreIsHidden) {
  const Fixture fixture(1);
  double before = 1e9;
  for (const int hidden_px : {1, 120, 240, 480}) {
    cv::Mat seen = Room(1), hidden = seen.colRange(0, hidden_px);
    Room(5).colRange(0, hidden_px).copyTo(hidden);
    const double similarity = fixture.Match(seen)[0].similarity;
    EXPECT_LT(similarity, before);
    before = similarity;
  }
  EXPECT_LT(before, 2);
}

TEST(PanoramaMatch, SaysWhatIsTooSmallOrMissing) {
  const WaveletEncoder encoder(160);
  EXPECT_THROW(SectorsOf(encoder, cv::Mat::zeros(160, 100, CV_8UC1), kSector), BadInput);
  EXPECT_THROW(SectorsOf(encoder, cv::Mat::zeros(160, 720, CV_8UC1), 12), BadInput);  // no square
  const PanoramaSectors sectors = SectorsOf(encoder, Room(1), kSector);
  EXPECT_EQ(sectors.views.size(), 6u);
}

}  // namespace
}  // namespace gaitcam
