// Maps made up from a floor that is a formula, so that nothing here shares code with what reads pictures.

#include "results/scoring/floor_score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

constexpr double kCell = 0.005, kDegree = std::numbers::pi / 180;
const Vector2d kFloorMin(-0.8, -0.6), kFloorMax(0.9, 0.7);
const Vector2d kSpot(0.3, 0.2);  // the middle of the floor's one white disk

/// Blotches of several sizes, none finer than two cells, and one white disk: 30..230.
double TrueGrey(const Vector2d& p) {
  if ((p - kSpot).norm() < 0.03) return 240;
  double grey = 120;
  for (int k = 0; k < 24; ++k) {
    const double turn = 2.4 * k, wave = 2 * std::numbers::pi / (0.03 + 0.006 * k);  // rad/m
    grey += 12 * std::sin(wave * (std::cos(turn) * p.x() + std::sin(turn) * p.y()) + 1.7 * k * k);
  }
  return std::clamp(grey, 0.0, 255.0);
}

FloorTruth MakeTruth() {
  static FloorTruth truth;  // the same every time, and not cheap
  if (!truth.grey.empty()) return truth;
  truth.px_per_m = 400;
  truth.corner_m = {kFloorMin.x() + 0.5 / truth.px_per_m, kFloorMax.y() - 0.5 / truth.px_per_m};
  const Vector2d size = (kFloorMax - kFloorMin) * truth.px_per_m;
  truth.grey.create(int(std::lround(size.y())), int(std::lround(size.x())), CV_8UC1);
  for (int v = 0; v < truth.grey.rows; ++v) {
    for (int u = 0; u < truth.grey.cols; ++u) {
      const Vector2d p = truth.corner_m + Vector2d(u, -v) / truth.px_per_m;
      truth.grey.at<uchar>(v, u) = cv::saturate_cast<uchar>(TrueGrey(p));
    }
  }
  return truth;
}

/// A map of V whose cells are right if `where` says where in W a point of V really lies.
FloorPicture MakeMap(const std::function<Vector2d(const Vector2d&)>& where, int columns = 200, int rows = 160) {
  FloorPicture map;
  map.cell_m = kCell;
  map.corner_m = {-kCell * columns / 2, kCell * rows / 2};
  map.intensity = cv::Mat::zeros(rows, columns, CV_8UC1);
  map.sightings = cv::Mat(rows, columns, CV_16UC1, cv::Scalar(7));
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < columns; ++u) {
      double sum = 0;
      for (int k = 0; k < 9; ++k) {  // over the cell's area
        const Vector2d within((k % 3 - 1) / 3.0, (k / 3 - 1) / 3.0);
        sum += TrueGrey(where(map.corner_m + kCell * (Vector2d(u, -v) + within)));
      }
      map.intensity.at<uchar>(v, u) = cv::saturate_cast<uchar>(sum / 9);
    }
  }
  return map;
}

Similarity Motion(double yaw, const Vector2d& translation) {
  Similarity X;
  X.rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
  X.translation = {translation.x(), translation.y(), 0.3};
  return X;
}

double Value(const FloorComparison& comparison, const std::string& name) {
  for (const Score& score : comparison.scores) {
    if (score.name == name) return score.value;
  }
  ADD_FAILURE() << "no score " << name;
  return 0;
}

const FloorMotion kWhere(2.1, Vector2d(0.05, 0.04));  // of V in W
const Similarity kAligned = Motion(2.1, {0.05, 0.04});
Vector2d Right(const Vector2d& p_V) { return kWhere * p_V; }

TEST(FloorScore, ARightMapIsRightHoweverItsWorldIsTurned) {
  const FloorComparison c = CompareFloor(MakeMap(Right), MakeTruth(), kAligned);
  // What differs is the rounding of both to grey levels (0.3 of some 40), and the disk's edge.
  EXPECT_GT(Value(c, "map_ncc"), 0.998);
  EXPECT_GT(Value(c, "map_ncc_unaligned"), 0.998);
  EXPECT_GT(Value(c, "map_ncc_local"), 0.995);
  EXPECT_NEAR(Value(c, "map_area_m2"), 200 * 160 * kCell * kCell, 1e-9);
  EXPECT_EQ(Value(c, "map_outside_ratio"), 0);
  EXPECT_GT(Value(c, "map_landmarks"), 50);
  EXPECT_GT(Value(c, "map_landmarks_found_ratio"), 0.97);
  EXPECT_LT(Value(c, "map_landmark_error_median_m"), 0.0005);  // a tenth of a cell
  EXPECT_LT(Value(c, "map_landmark_error_p90_m"), 0.001);
  EXPECT_LT(Value(c, "map_shift_m"), 0.0005);
  EXPECT_NEAR(Value(c, "map_turn_deg"), 0, 0.05);
}

// What the trajectories' alignment mends, the first pose does not.
TEST(FloorScore, FromTheStartNothingIsAligned) {
  EXPECT_TRUE(std::isnan(Value(CompareFloor(MakeMap(Right), MakeTruth(), kAligned), "map_ncc_from_start")));
  const FloorComparison right = CompareFloor(MakeMap(Right), MakeTruth(), kAligned, {}, kAligned);
  EXPECT_EQ(Value(right, "map_ncc_from_start"), Value(right, "map_ncc_unaligned"));
  Similarity drifted = kAligned;
  drifted.translation.x() += 0.2;
  const FloorComparison c = CompareFloor(MakeMap(Right), MakeTruth(), kAligned, {}, drifted);
  EXPECT_EQ(Value(c, "map_ncc_unaligned"), Value(right, "map_ncc_unaligned"));
  EXPECT_LT(Value(c, "map_ncc_from_start"), 0.5 * Value(c, "map_ncc_unaligned"));
}

TEST(FloorScore, BrightnessNeedNotAgree) {
  FloorPicture map = MakeMap(Right);
  const double before = Value(CompareFloor(map, MakeTruth(), kAligned), "map_ncc");
  map.intensity.convertTo(map.intensity, CV_8U, 0.5, 60);
  EXPECT_NEAR(Value(CompareFloor(map, MakeTruth(), kAligned), "map_ncc"), before, 0.002);  // coarser grey levels
}

TEST(FloorScore, ASmallMotionOfTheWholeMapIsFoundAndForgivenButTold) {
  const double turn = 1.5 * kDegree;
  const Similarity off = Motion(2.1 + turn, Vector2d(0.05, 0.04) + Vector2d(0.06, -0.03));
  const FloorComparison c = CompareFloor(MakeMap(Right), MakeTruth(), off);
  EXPECT_LT(Value(c, "map_ncc_unaligned"), 0.5);
  EXPECT_GT(Value(c, "map_ncc"), 0.998);
  EXPECT_LT(Value(c, "map_landmark_error_median_m"), 0.0005);
  EXPECT_NEAR(Value(c, "map_shift_m"), std::hypot(0.06, 0.03), 0.003);
  EXPECT_NEAR(Value(c, "map_turn_deg"), -1.5, 0.05);
  EXPECT_NEAR(c.X_WV.yaw, kWhere.yaw, 0.05 * kDegree);
  EXPECT_NEAR((c.X_WV.translation - kWhere.translation).norm(), 0, 0.0005);
}

TEST(FloorScore, AMapThatLiesTooFarOffIsNotForgiven) {
  const FloorComparison far = CompareFloor(MakeMap(Right), MakeTruth(), Motion(2.1, {0.35, 0.04}));
  EXPECT_LT(Value(far, "map_ncc"), 0.5);
  const FloorComparison turned = CompareFloor(MakeMap(Right), MakeTruth(), Motion(2.3, {0.05, 0.04}));  // by 11 deg
  EXPECT_LT(Value(turned, "map_ncc"), 0.7);
  EXPECT_LE(std::abs(Value(turned, "map_turn_deg")), 3.0);
}

TEST(FloorScore, AnAlignmentThatIsRightStaysAsItIs) {
  FloorPicture map = MakeMap(Right);
  cv::Mat(map.intensity.size(), CV_8UC1, cv::Scalar(90)).copyTo(map.intensity);  // nothing to align by
  const FloorComparison c = CompareFloor(map, MakeTruth(), kAligned);
  EXPECT_EQ(Value(c, "map_shift_m"), 0);
  EXPECT_EQ(Value(c, "map_turn_deg"), 0);
  EXPECT_TRUE(std::isnan(Value(c, "map_ncc")));
  EXPECT_EQ(Value(c, "map_landmarks_found_ratio"), 0);
  EXPECT_TRUE(std::isnan(Value(c, "map_landmark_error_median_m")));
}

TEST(FloorScore, AWrongScaleIsNotForgivenAndShowsInTheLandmarks) {
  const auto grown = [](const Vector2d& p_V) { return kWhere * (p_V / 1.04); };
  const FloorComparison c = CompareFloor(MakeMap(grown), MakeTruth(), kAligned);
  EXPECT_LT(Value(c, "map_ncc"), 0.8);
  // A landmark at p is shown 4 % of its distance from the middle too far out.
  std::vector<double> expected, errors;
  for (const FloorLandmark& l : c.landmarks) {
    if (!l.found) continue;
    const Vector2d p_V = kWhere.Inverse() * l.truth_m;
    EXPECT_NEAR((l.map_m - kWhere * (1.04 * p_V)).norm(), 0, 0.004);  // the alignment may shift all a little
  }
  EXPECT_GT(Value(c, "map_landmark_error_median_m"), 0.006);
  EXPECT_LT(Value(c, "map_landmark_error_median_m"), 0.02);
}

TEST(FloorScore, ASeamShowsInTheLandmarksBeyondIt) {
  constexpr double kSeam = 0.012;
  const auto torn = [](const Vector2d& p_V) {
    return kWhere * (p_V + (p_V.x() > 0.25 ? Vector2d(0, -kSeam) : Vector2d(0, 0)));
  };
  const FloorComparison c = CompareFloor(MakeMap(torn), MakeTruth(), kAligned);
  // The alignment shares the error out between both sides, so look where in V the map has put things.
  Vector2d beyond = Vector2d::Zero(), before = Vector2d::Zero();
  int count_beyond = 0, count_before = 0;
  for (const FloorLandmark& l : c.landmarks) {
    const Vector2d right_V = kWhere.Inverse() * l.truth_m;
    if (!l.found || std::abs(right_V.x() - 0.25) < 0.05) continue;  // patches across the seam
    const Vector2d off = c.X_WV.Inverse() * l.map_m - right_V;
    (right_V.x() > 0.25 ? beyond : before) += off;
    ++(right_V.x() > 0.25 ? count_beyond : count_before);
  }
  ASSERT_GT(std::min(count_beyond, count_before), 10);
  EXPECT_NEAR((before / count_before).norm(), 0, 0.0005);  // a tenth of a cell
  EXPECT_NEAR((beyond / count_beyond - Vector2d(0, kSeam)).norm(), 0, 0.0005);
  EXPECT_GT(Value(c, "map_landmark_error_p90_m"), kSeam / 3);
  EXPECT_LT(Value(c, "map_landmark_error_p90_m"), kSeam);
}

TEST(FloorScore, NoiseLooksLikeNothing) {
  FloorPicture map = MakeMap(Right);
  RandomStream random(3, "floor noise");
  for (int v = 0; v < map.intensity.rows; ++v) {
    for (int u = 0; u < map.intensity.cols; ++u) {
      map.intensity.at<uchar>(v, u) = cv::saturate_cast<uchar>(128 + 40 * random.Normal());
    }
  }
  const FloorComparison c = CompareFloor(map, MakeTruth(), kAligned);
  EXPECT_LT(std::abs(Value(c, "map_ncc")), 0.1);
  EXPECT_LT(Value(c, "map_landmarks_found_ratio"), 0.02);
}

TEST(FloorScore, OnlyWhatWasSeenOftenEnoughCounts) {
  FloorPicture map = MakeMap(Right);
  const cv::Rect left(0, 0, 80, 160);
  map.intensity(left).setTo(0);  // wrong, but hardly seen
  map.sightings(left).setTo(2);
  const FloorComparison c = CompareFloor(map, MakeTruth(), kAligned);
  EXPECT_GT(Value(c, "map_ncc"), 0.998);
  EXPECT_NEAR(Value(c, "map_area_m2"), 120 * 160 * kCell * kCell, 1e-9);
  FloorScoreOptions generous;
  generous.min_sightings = 2;
  EXPECT_LT(Value(CompareFloor(map, MakeTruth(), kAligned, generous), "map_ncc"), 0.6);
}

TEST(FloorScore, WhatLiesBeyondTheFloorIsCountedAndNotCompared) {
  // 1.4 m long from the floor's middle to 0.6 m beyond its right edge.
  const auto where = [](const Vector2d& p_V) { return Vector2d(p_V + Vector2d(0.8, 0)); };
  const FloorComparison c = CompareFloor(MakeMap(where, 280, 80), MakeTruth(), Motion(0, {0.8, 0}));
  EXPECT_NEAR(Value(c, "map_outside_ratio"), 0.6 / 1.4, 0.01);
  EXPECT_GT(Value(c, "map_ncc"), 0.998);
  EXPECT_NEAR(Value(c, "map_area_m2"), 0.8 * 0.4, 0.01);
  EXPECT_LT(c.corner_m.x() + kCell * c.estimate.cols, kFloorMax.x() + 0.12);  // the pictures end there, with a margin
}

TEST(FloorScore, ThePicturesShowTheSameGround) {
  FloorPicture map = MakeMap(Right);
  map.sightings(cv::Rect(0, 0, 40, 40)).setTo(0);
  map.intensity(cv::Rect(0, 0, 40, 40)).setTo(0);
  const FloorComparison c = CompareFloor(map, MakeTruth(), kAligned);
  ASSERT_FALSE(c.empty());
  for (const cv::Mat& picture : {c.mask, c.truth, c.difference}) EXPECT_EQ(picture.size(), c.estimate.size());
  const auto pixel = [&](const Vector2d& p_W) {
    const Vector2d at = (p_W - c.corner_m) / c.cell_m;
    return cv::Point(int(std::lround(at.x())), int(std::lround(-at.y())));
  };
  cv::Mat disk;
  const cv::Rect around(pixel(kSpot) - cv::Point(10, 10), cv::Size(21, 21));
  cv::findNonZero(c.truth(around) == 240, disk);
  const cv::Scalar middle = cv::mean(disk);
  const Vector2d found = c.corner_m + c.cell_m * Vector2d(around.x + middle[0], -around.y - middle[1]);
  EXPECT_LT((found - kSpot).norm(), 0.3 * c.cell_m);  // of some hundred pixels
  EXPECT_EQ(c.truth.at<uchar>(pixel(kSpot)), 240);
  EXPECT_EQ(c.estimate.at<uchar>(pixel(kSpot)), 240);
  EXPECT_EQ(c.mask.at<uchar>(pixel(kSpot)), 255);
  const cv::Vec3b same = c.difference.at<cv::Vec3b>(pixel(kSpot));
  EXPECT_GT(std::min({same[0], same[1], same[2]}), 240);  // white
  const cv::Point hole = pixel(kWhere * CellMiddle(map, 20, 20));
  EXPECT_EQ(c.mask.at<uchar>(hole), 0);
  EXPECT_EQ(c.estimate.at<uchar>(hole), 0);
  EXPECT_NEAR(c.truth.at<uchar>(hole), TrueGrey(kWhere * CellMiddle(map, 20, 20)), 12);  // up to a cell's grey slope
  EXPECT_LT(c.difference.at<cv::Vec3b>(hole)[0], 60);                                    // dark
}

TEST(FloorScore, TheDifferenceIsRedWhereTheMapIsTooBright) {
  FloorPicture map = MakeMap(Right);
  const int u = 100, v = 80;
  cv::circle(map.intensity, {u, v}, 4, cv::Scalar(255), cv::FILLED);
  const FloorComparison c = CompareFloor(map, MakeTruth(), kAligned);
  const Vector2d at = (kWhere * CellMiddle(map, u, v) - c.corner_m) / c.cell_m;
  const cv::Vec3b there = c.difference.at<cv::Vec3b>(int(std::lround(-at.y())), int(std::lround(at.x())));
  EXPECT_EQ(there[2], 255);
  EXPECT_LT(there[0], 60);
}

TEST(FloorScore, AnEmptyMapHasScoresWithoutValuesAndNoPictures) {
  const FloorComparison none = CompareFloor({}, MakeTruth(), kAligned);
  EXPECT_TRUE(none.empty());
  EXPECT_TRUE(std::isnan(Value(none, "map_ncc")));
  EXPECT_EQ(Value(none, "map_area_m2"), 0);
  FloorPicture glimpse = MakeMap(Right);
  glimpse.sightings.setTo(1);
  EXPECT_TRUE(CompareFloor(glimpse, MakeTruth(), kAligned).empty());
  const FloorComparison elsewhere = CompareFloor(MakeMap(Right), MakeTruth(), Motion(2.1, {50, 0}));
  EXPECT_TRUE(elsewhere.empty());
  EXPECT_EQ(Value(elsewhere, "map_outside_ratio"), 1);
  ASSERT_EQ(none.scores.size(), elsewhere.scores.size());
  for (size_t i = 0; i < none.scores.size(); ++i) EXPECT_EQ(none.scores[i].name, elsewhere.scores[i].name);
}

TEST(FloorScore, ContradictionsAreRefused) {
  FloorPicture map = MakeMap(Right);
  FloorTruth truth = MakeTruth();
  truth.px_per_m = 0;
  EXPECT_THROW(CompareFloor(map, truth, kAligned), BadOption);
  truth = MakeTruth();
  truth.grey = cv::Mat();
  EXPECT_THROW(CompareFloor(map, truth, kAligned), BadOption);
  map.sightings = map.sightings.rowRange(1, 10);
  EXPECT_THROW(CompareFloor(map, MakeTruth(), kAligned), BadOption);
  FloorScoreOptions options;
  options.min_sightings = 0;
  EXPECT_THROW(CompareFloor(MakeMap(Right), MakeTruth(), kAligned, options), BadOption);
}

}  // namespace
}  // namespace gaitcam
