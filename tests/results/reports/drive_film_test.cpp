#include "results/reports/drive_film.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

constexpr int kSteps = 12, kHeight_px = 200;

/// Six metres along x in steps of half a metre and a quarter of a second, along a taught way, past a person who stands
/// 1 m to its left halfway. Confirmed in the first half only.
struct Drive {
  TaughtDrive said;
  DriveComparison truth;

  Drive() {
    said.half_view_rad = 0.5;
    truth.taught_m = {{Vector2d(0, 0), Vector2d(6, 0)}};
    for (int s = 0; s < kSteps; ++s) {
      DriveStep step;
      step.stamp_ns = s * 250'000'000LL;
      step.state = DriveState::kDriving;
      step.confirmed = s < kSteps / 2;
      step.places = 1;
      said.steps.push_back(step);
      DrivenStep driven;
      driven.at_m = Vector2d(0.5 * s, 0);
      driven.heading_rad = 0;
      driven.people_m = {Vector2d(3, 1)};
      truth.steps.push_back(driven);
    }
  }

  /// The margin of 1.5 m makes the ground 3 m high and 8.5 m or 9 m wide: to the last step or the way's end.
  cv::Vec3b ColourAt(size_t step, const Vector2d& p) const {
    const cv::Mat picture = DriveFilmPicture(said, truth, step, kHeight_px);
    const double px_per_m = kHeight_px / 3.0;
    EXPECT_NEAR(picture.cols, 9 * px_per_m, 1);
    return picture.at<cv::Vec3b>(int((1.5 - p.y()) * px_per_m), int((p.x() + 1.5) * px_per_m));
  }
};

/// Which channel is the strongest; white and grey: none.
char Hue(const cv::Vec3b& bgr) {
  const int most = std::max({bgr[0], bgr[1], bgr[2]});
  if (most - std::min({bgr[0], bgr[1], bgr[2]}) < 20) return '-';
  return most == bgr[2] ? 'r' : most == bgr[1] ? 'g' : 'b';
}

TEST(DriveFilm, ShowsTheRobotWhereItIsAndWhetherItKnowsIt) {
  const Drive drive;
  const Vector2d beside(0, 0.12);  // the middle is crossed by lines
  EXPECT_EQ(Hue(drive.ColourAt(2, drive.truth.steps[2].at_m + beside)), 'g') << "a view confirms it";
  EXPECT_EQ(Hue(drive.ColourAt(9, drive.truth.steps[9].at_m + beside)), 'r') << "none does";
  EXPECT_EQ(Hue(drive.ColourAt(9, drive.truth.steps[2].at_m + beside)), '-') << "it has left";
}

TEST(DriveFilm, ShowsPeopleAndTheTaughtWayAhead) {
  Drive drive;
  EXPECT_NE(Hue(drive.ColourAt(0, {3, 1})), '-');
  EXPECT_EQ(Hue(drive.ColourAt(0, {5.4, 0})), 'b') << "the taught way";
  for (DrivenStep& step : drive.truth.steps) step.people_m.clear();
  EXPECT_EQ(Hue(drive.ColourAt(0, {3, 1})), '-');
}

TEST(DriveFilm, IsAFilmOfEveryStepThatHasATruePlace) {
  const TemporaryFolder folder;
  Drive drive;
  drive.truth.steps[3] = DrivenStep();
  const std::filesystem::path file = folder.path() / kDriveFilmName;
  WriteDriveFilm(file, drive.said, drive.truth);
  cv::VideoCapture film(file.string());
  ASSERT_TRUE(film.isOpened());
  EXPECT_EQ(int(film.get(cv::CAP_PROP_FRAME_COUNT)), kSteps - 1);
  // Ten intervals in 11 x 0.25 s, four times as fast.
  EXPECT_NEAR(film.get(cv::CAP_PROP_FPS), 4 * 10 / 2.75, 1e-2);
  std::filesystem::remove(file);
  for (DrivenStep& step : drive.truth.steps) step = DrivenStep();
  WriteDriveFilm(file, drive.said, drive.truth);
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace gaitcam
