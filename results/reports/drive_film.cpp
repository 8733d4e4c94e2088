#include "results/reports/drive_film.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "algorithms/core/planar_pose.h"
#include "results/reports/video.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

constexpr double kMargin_m = 1.5;  // around all that is driven and taught
constexpr double kTrail_s = 3;     // so much of people's tracks is seen
constexpr double kSight_m = 5;     // that depth cameras see
constexpr double kFaster = 4;
constexpr int kHeight_px = 480;
constexpr double kBody_m = 0.22, kPerson_m = 0.25;

/// BGR, as page.css has them.
const cv::Scalar kCard(255, 255, 255), kTaught(229, 199, 166), kTruth(64, 58, 52), kGreen(94, 128, 0),
    kWaits(158, 189, 233), kPurple(126, 73, 164), kPale(222, 200, 230), kGoal(30, 38, 179), kView(240, 236, 232);

/// Metres to pixels, y up.
class Ground {
 public:
  Ground(const DriveComparison& comparison, int height_px) {
    Vector2d low = Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    const auto add = [&](const Vector2d& p) {
      if (!p.allFinite()) return;
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    };
    for (const DrivenStep& step : comparison.steps) add(step.at_m);
    for (const auto& taught : comparison.taught_m) std::for_each(taught.begin(), taught.end(), add);
    low_ = low - Vector2d::Constant(kMargin_m);
    high_ = high + Vector2d::Constant(kMargin_m);
    px_per_m_ = height_px / (high_ - low_).y();
    picture_ = cv::Mat(height_px, std::max(2, int(std::lround(px_per_m_ * (high_ - low_).x()))), CV_8UC3, kCard);
  }

  void Path(const std::vector<Vector2d>& points, const cv::Scalar& colour, int width_px) {
    std::vector<cv::Point> line;
    for (const Vector2d& p : points) line.push_back(At(p));
    cv::polylines(picture_, line, false, colour, width_px, cv::LINE_AA, kShift);
  }
  void Area(const std::vector<Vector2d>& points, const cv::Scalar& colour) {
    std::vector<cv::Point> corners;
    for (const Vector2d& p : points) corners.push_back(At(p));
    cv::fillConvexPoly(picture_, corners, colour, cv::LINE_AA, kShift);
  }
  void Disc(const Vector2d& p, double radius_m, const cv::Scalar& colour, int width_px = cv::FILLED) {
    const double radius = std::max(1.0, px_per_m_ * radius_m);
    cv::circle(picture_, At(p), int(std::lround(radius * (1 << kShift))), colour, width_px, cv::LINE_AA, kShift);
  }
  const cv::Mat& picture() const { return picture_; }

 private:
  static constexpr int kShift = 4;  ///< Bits of a pixel's fraction.

  cv::Point At(const Vector2d& p) const {
    const Vector2d at = px_per_m_ * Vector2d(p.x() - low_.x(), high_.y() - p.y()) * (1 << kShift);
    return {int(std::lround(at.x())), int(std::lround(at.y()))};
  }

  Vector2d low_, high_;
  double px_per_m_;
  cv::Mat picture_;
};

/// Of those who are about at a step, over the last seconds.
void DrawPeople(const TaughtDrive& drive, const DriveComparison& comparison, size_t step, Ground& ground) {
  const std::vector<Vector2d>& now = comparison.steps[step].people_m;
  for (size_t person = 0; person < now.size(); ++person) {
    std::vector<Vector2d> trail;
    for (size_t s = step + 1; s-- > 0;) {
      const double age_s = 1e-9 * double(drive.steps[step].stamp_ns - drive.steps[s].stamp_ns);
      if (age_s > kTrail_s || person >= comparison.steps[s].people_m.size()) break;
      trail.push_back(comparison.steps[s].people_m[person]);
    }
    ground.Path(trail, kPurple, 1);
    ground.Disc(now[person], kPerson_m, kPale);
    ground.Disc(now[person], kPerson_m, kPurple, 1);
  }
}

void DrawRobot(const DrivenStep& truth, double half_view_rad, bool confirmed, Ground& ground) {
  const Vector2d ahead(kSight_m, 0);
  ground.Disc(truth.at_m, kBody_m, confirmed ? kGreen : kWaits);
  ground.Disc(truth.at_m, kBody_m, kTruth, 1);
  for (const double side : {-half_view_rad, half_view_rad}) {
    ground.Path({truth.at_m, truth.at_m + 0.2 * Rotate(ahead, truth.heading_rad + side)}, kTruth, 1);
  }
}

std::string StatusOf(const DriveStep& said) {
  std::string words = std::string(ToWord(said.state));
  if (said.places > 1) return words + fmt::format(", may be in {} places", said.places);
  return words + (said.confirmed ? ", sure of its place" : said.places == 1 ? ", by its odometry" : ", lost");
}

}  // namespace

cv::Mat DriveFilmPicture(const TaughtDrive& drive, const DriveComparison& comparison, size_t step, int height_px) {
  Ground ground(comparison, height_px);
  const DrivenStep& now = comparison.steps[step];
  const Vector2d ahead(kSight_m, 0);
  const double half = drive.half_view_rad;
  ground.Area({now.at_m, now.at_m + Rotate(ahead, now.heading_rad - half), now.at_m + Rotate(ahead, now.heading_rad),
               now.at_m + Rotate(ahead, now.heading_rad + half)},
              kView);
  for (const auto& taught : comparison.taught_m) ground.Path(taught, kTaught, 5);
  if (!comparison.taught_m.empty() && !comparison.taught_m.back().empty())
    ground.Disc(comparison.taught_m.back().back(), 0.2, kGoal, 2);
  std::vector<Vector2d> driven;
  for (size_t s = 0; s <= step; ++s) {
    const Vector2d& at = comparison.steps[s].at_m;
    if (!at.allFinite()) continue;
    driven.push_back(at);
    if (drive.steps[s].state == DriveState::kWaiting) ground.Disc(at, 0.13, kWaits);
    if (drive.steps[s].confirmed) ground.Disc(at, 0.04, kGreen);
  }
  ground.Path(driven, kTruth, 1);
  DrawPeople(drive, comparison, step, ground);
  DrawRobot(now, half, drive.steps[step].confirmed, ground);
  return ground.picture();
}

void WriteDriveFilm(const std::filesystem::path& file, const TaughtDrive& drive, const DriveComparison& comparison) {
  std::vector<size_t> steps;
  for (size_t s = 0; s < drive.steps.size(); ++s) {
    if (comparison.steps[s].at_m.allFinite()) steps.push_back(s);
  }
  if (steps.size() < 2) return;
  const int64_t begin_ns = drive.steps[steps.front()].stamp_ns, end_ns = drive.steps[steps.back()].stamp_ns;
  const double rate_hz = double(steps.size() - 1) / (1e-9 * double(end_ns - begin_ns));
  VideoWriter writer(file, {.frame_rate_hz = kFaster * rate_hz, .height_px = kHeight_px});
  for (const size_t s : steps) {
    VideoFrame frame;
    frame.camera = DriveFilmPicture(drive, comparison, s, kHeight_px);
    frame.time_s = 1e-9 * double(drive.steps[s].stamp_ns - begin_ns);
    frame.status = StatusOf(drive.steps[s]);
    frame.alarm = !drive.steps[s].confirmed;
    writer.Add(frame);
  }
  writer.Finish();
}

}  // namespace gaitcam
