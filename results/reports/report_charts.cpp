#include "results/reports/report_charts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "algorithms/core/units.h"
#include "results/reports/covariance_ellipse.h"
#include "results/scoring/alignment.h"
#include "results/scoring/consistency.h"
#include "results/scoring/jumps.h"
#include "results/scoring/metrics.h"
#include "results/scoring/statistics.h"

namespace gaitcam::internal {
namespace {

using Json = nlohmann::ordered_json;

/// A number with about a tenth of a millimetre of room: enough for a chart, and short in the file.
Json Rounded(double value) { return std::isfinite(value) ? Json(std::round(value * 1e4) / 1e4) : Json(nullptr); }

Json Column(size_t count, const auto& value_at) {
  Json column = Json::array();
  for (size_t i = 0; i < count; ++i) column.push_back(Rounded(value_at(i)));
  return column;
}

/// Median distance of successive stamps, s; 0 for less than two.
double UsualInterval(const Trajectory& trajectory) {
  std::vector<double> gaps;
  for (size_t i = 1; i < trajectory.size(); ++i) {
    gaps.push_back(double(trajectory[i].stamp_ns - trajectory[i - 1].stamp_ns) * 1e-9);
  }
  return gaps.empty() ? 0 : MedianOf(gaps);
}

/// Columns x, y, z; a null where there was no pose for a while, so that no line is drawn across.
Json PathJson(const Trajectory& trajectory) {
  Json x = Json::array(), y = Json::array(), z = Json::array();
  const double longest = 2.5 * UsualInterval(trajectory);
  for (size_t i = 0; i < trajectory.size(); ++i) {
    if (i > 0 && double(trajectory[i].stamp_ns - trajectory[i - 1].stamp_ns) * 1e-9 > longest) {
      for (Json* column : {&x, &y, &z}) column->push_back(nullptr);
    }
    const Eigen::Vector3d& p = trajectory[i].pose.translation;
    x.push_back(Rounded(p.x()));
    y.push_back(Rounded(p.y()));
    z.push_back(Rounded(p.z()));
  }
  return {{"x", x}, {"y", y}, {"z", z}};
}

/// Extent of the true path.
struct PathBox {
  Eigen::Array3d low = Eigen::Array3d::Constant(1e300), high = -low;
  explicit PathBox(const Trajectory& truth) {
    for (const StampedPose& p : truth) {
      low = low.min(p.pose.translation.array());
      high = high.max(p.pose.translation.array());
    }
  }
};

/// Ellipses along the path after SE(3) alignment, far enough apart to be told from each other.
struct PathEllipses {
  std::vector<Eigen::Vector2d> centres_m;
  std::vector<PositionEllipse> ellipses;
  double magnification = 1;

  explicit PathEllipses(const ReportInput& input) {
    constexpr size_t kMost = 40;
    const AlignmentResult& se3 = input.scores->last.se3;
    const std::vector<PosePair> pairs = Apply(se3.X_WV, input.scores->last.pairs);
    const size_t step = pairs.size() / kMost + 1;
    for (size_t i = 0; i < pairs.size(); i += step) {
      if (!pairs[i].covariance) continue;
      centres_m.push_back(pairs[i].estimate.translation.head<2>());
      ellipses.push_back(EllipseOf(pairs[i].estimate.rotation, *pairs[i].covariance));
    }
    const PathBox box(input.truth);
    magnification = EllipseMagnification(ellipses, (box.high - box.low).head<2>().maxCoeff() / 100);
  }
};

/// Their outlines, a null after each.
Json EllipsesJson(const PathEllipses& along) {
  constexpr int kCorners = 24;
  Json x = Json::array(), y = Json::array();
  for (size_t n = 0; n < along.ellipses.size(); ++n) {
    const Eigen::Rotation2Dd turn(along.ellipses[n].turn_rad);
    for (int k = 0; k <= kCorners; ++k) {
      const double angle = 2 * std::numbers::pi * k / kCorners;
      const Eigen::Vector2d on =
          along.ellipses[n].axes_m.cwiseProduct(Eigen::Vector2d(std::cos(angle), std::sin(angle)));
      const Eigen::Vector2d p = along.centres_m[n] + along.magnification * (turn * on);
      x.push_back(Rounded(p.x()));
      y.push_back(Rounded(p.y()));
    }
    for (Json* column : {&x, &y}) column->push_back(nullptr);
  }
  return {{"x", x}, {"y", y}};
}

Json PathsJson(const ReportInput& input) {
  const auto [low, high] = PathBox(input.truth);
  Json json = {{"truth", PathJson(input.truth)}};
  json["side_axis"] = high.y() - low.y() > high.x() - low.x() ? "y" : "x";  // the side from which most is seen
  if (HasPoses(input)) {
    json["sim3"] = PathJson(input.scores->last.aligned_sim3);
    json["se3"] = PathJson(input.scores->last.aligned_se3);
    if (input.scores->live) json["live"] = PathJson(input.scores->live->aligned_sim3);
    if (HasCovariances(input)) json["ellipses"] = EllipsesJson(PathEllipses(input));
  }
  return json;
}

/// Columns over time; nulls where there was no pose for a while.
Json ErrorsJson(const PoseErrors& errors, const ReportClock& clock) {
  const std::vector<PosePair>& pairs = errors.pairs;
  Trajectory stamps;
  for (const PosePair& p : pairs) stamps.push_back({p.stamp_ns, p.truth});
  const double longest = 2.5 * UsualInterval(stamps);
  Json t = Json::array(), se3 = Json::array(), sim3 = Json::array(), rot = Json::array(), own = Json::array();
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (i > 0 && double(pairs[i].stamp_ns - pairs[i - 1].stamp_ns) * 1e-9 > longest) {
      t.push_back(Rounded(clock.Seconds(pairs[i].stamp_ns)));
      for (Json* column : {&se3, &sim3, &rot, &own}) column->push_back(nullptr);
    }
    t.push_back(Rounded(clock.Seconds(pairs[i].stamp_ns)));
    se3.push_back(Rounded(errors.error_se3_m[i]));
    sim3.push_back(Rounded(errors.error_sim3_m[i]));
    rot.push_back(Rounded(errors.error_rot_deg[i]));
    own.push_back(Rounded(errors.error_rot_own_deg[i]));
  }
  return {{"t", t}, {"se3", se3}, {"sim3", sim3}, {"rot", rot}, {"own", own}};
}

Json ErrorsOfBothJson(const Scores& scores, const ReportClock& clock) {
  Json json = ErrorsJson(scores.last, clock);
  // Errors in a foreign scale would press those in the true one flat on the axis: left to a click.
  json["hide_se3"] = scores.Value("ate_rmse_m") > 4 * scores.Value("ate_sim3_rmse_m");
  json["hide_rot"] = scores.Value("ate_rot_rmse_deg") > 4 * scores.Value("ate_rot_own_rmse_deg");
  if (scores.live) json["live"] = ErrorsJson(*scores.live, clock);
  return json;
}

/// When the scorer found jumps: of the live answer, or of the final one if that is all there is.
Json JumpsJson(const Scores& scores, const ReportClock& clock) {
  const PoseErrors& errors = scores.live ? *scores.live : scores.last;
  Json json = Json::array();
  for (const Jump& jump : FindJumps(Apply(errors.sim3.X_WV, errors.pairs))) {
    json.push_back(Rounded(clock.Seconds(errors.pairs[jump.to].stamp_ns)));
  }
  return json;
}

Json NeesJson(const std::vector<PosePair>& pairs, const ReportClock& clock) {
  const std::vector<NeesSample> samples = AbsoluteNees(pairs);
  const size_t n = samples.size();
  return {{"t", Column(n, [&](size_t i) { return clock.Seconds(samples[i].stamp_ns); })},
          {"nees", Column(n, [&](size_t i) { return samples[i].nees; })},
          {"low", Column(n, [&](size_t) { return kNeesLow; })},
          {"high", Column(n, [&](size_t) { return kNeesHigh; })}};
}

Json HeadingJson(const std::vector<PosePair>& pairs, const ReportClock& clock) {
  const TurnCourse course = MeasureTurnCourse(pairs);
  const size_t n = pairs.size();
  return {{"t", Column(n, [&](size_t i) { return clock.Seconds(pairs[i].stamp_ns); })},
          {"truth", Column(n, [&](size_t i) { return course.truth[i] * kDegPerRad; })},
          {"estimate", Column(n, [&](size_t i) { return course.estimate[i] * kDegPerRad; })}};
}

Json FramesJson(const std::vector<ReportFrame>& frames, const ReportClock& clock) {
  const size_t n = frames.size();
  return {{"t", Column(n, [&](size_t i) { return clock.Seconds(frames[i].stamp_ns); })},
          {"blur_median", Column(n, [&](size_t i) { return frames[i].blur_median_px; })},
          {"blur_p90", Column(n, [&](size_t i) { return frames[i].blur_p90_px; })},
          {"blur_max", Column(n, [&](size_t i) { return frames[i].blur_max_px; })},
          {"features", Column(n, [&](size_t i) { return double(frames[i].features); })},
          {"inliers", Column(n, [&](size_t i) { return double(frames[i].inliers); })}};
}

/// Times between which `holds` is true of the frames: each frame stands for the time halfway to its neighbours.
std::vector<std::pair<double, double>> Spans(const std::vector<ReportFrame>& frames, const ReportClock& clock,
                                             const auto& holds) {
  std::vector<std::pair<double, double>> spans;
  const auto edge = [&](size_t i) {  // between frames i - 1 and i
    if (i == 0) return clock.Seconds(frames.front().stamp_ns);
    if (i == frames.size()) return clock.Seconds(frames.back().stamp_ns);
    return 0.5 * (clock.Seconds(frames[i - 1].stamp_ns) + clock.Seconds(frames[i].stamp_ns));
  };
  for (size_t i = 0; i < frames.size(); ++i) {
    if (!holds(frames[i])) continue;
    const size_t begin = i;
    while (i + 1 < frames.size() && holds(frames[i + 1])) ++i;
    spans.emplace_back(edge(begin), edge(i + 1));
  }
  return spans;
}

Json StatusSpansJson(const std::vector<ReportFrame>& frames, const ReportClock& clock) {
  Json json = Json::array();
  for (const TrackingStatus status : {TrackingStatus::kInitializing, TrackingStatus::kLost}) {
    for (const auto& [from, to] : Spans(frames, clock, [&](const ReportFrame& f) { return f.live == status; })) {
      json.push_back({Rounded(from), Rounded(to), ToString(status)});
    }
  }
  return json;
}

Json GaitJson(const std::vector<ReportFrame>& frames, const ReportClock& clock) {
  Json rows = Json::array();
  for (const int side : {0, 1}) {
    Json points = Json::array();
    const auto touches = [&](const ReportFrame& f) { return f.gait && (side == 0 ? f.left_contact : f.right_contact); };
    for (const auto& [from, to] : Spans(frames, clock, touches)) {
      const int row = side == 0 ? 2 : 1;
      points.push_back({{"x", Rounded(from)}, {"y", row}});
      points.push_back({{"x", Rounded(to)}, {"y", row}});
      points.push_back({{"x", Rounded(to)}, {"y", nullptr}});
    }
    rows.push_back(
        {{"name", side == 0 ? "left foot" : "right foot"}, {"colour", side == 0 ? "sim3" : "se3"}, {"points", points}});
  }
  return {{"rows", rows}};
}

}  // namespace

ReportClock::ReportClock(const ReportInput& input) {
  if (!input.frames.empty()) {
    zero_ns = input.frames.front().stamp_ns;
    end_ns = input.frames.back().stamp_ns;
  } else if (!input.truth.empty()) {
    zero_ns = input.truth.front().stamp_ns;
    end_ns = input.truth.back().stamp_ns;
  }
}
bool HasPoses(const ReportInput& input) { return input.scores && input.scores->HasPoses(); }

bool HasCovariances(const ReportInput& input) {
  if (!HasPoses(input)) return false;
  const std::vector<PosePair>& pairs = input.scores->last.pairs;
  return std::any_of(pairs.begin(), pairs.end(), [](const PosePair& pair) { return pair.covariance.has_value(); });
}

double PathEllipseMagnification(const ReportInput& input) { return PathEllipses(input).magnification; }

bool HasGait(const ReportInput& input) {
  return std::any_of(input.frames.begin(), input.frames.end(),
                     [](const ReportFrame& f) { return f.gait && (f.left_contact || f.right_contact); });
}

std::string ReportChartData(const ReportInput& input) {
  const ReportClock clock(input);
  Json json;
  json["t_min"] = 0;
  json["t_max"] = Rounded(clock.Seconds(clock.end_ns));
  json["path"] = PathsJson(input);
  if (HasPoses(input)) {
    json["error"] = ErrorsOfBothJson(*input.scores, clock);
    json["heading"] = HeadingJson(input.scores->last.pairs, clock);
    if (HasCovariances(input)) json["nees"] = NeesJson(input.scores->last.pairs, clock);
  }
  json["frames"] = FramesJson(input.frames, clock);
  json["spans"] = StatusSpansJson(input.frames, clock);
  json["jumps"] = HasPoses(input) ? JumpsJson(*input.scores, clock) : Json::array();
  if (HasGait(input)) json["gait"] = GaitJson(input.frames, clock);
  return json.dump();
}

}  // namespace gaitcam::internal
