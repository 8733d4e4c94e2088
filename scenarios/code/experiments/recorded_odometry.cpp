#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/io/trajectory_file.h"
#include "results/scoring/alignment.h"
#include "results/scoring/jumps.h"
#include "results/scoring/score.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/jobs/study.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

struct RecordedOdometryOptions {
  InputPaths studies;
  int seeds = 0;                       ///< 0: all of each study.
  bool finished = false;               ///< Runs nothing.
  std::string runs = "runs/odometry";  ///< Finished runs are used again, as `gaitcam study` does.
  std::string picture;                 ///< Empty: beside the table.
};

template <class Visitor>
void VisitFields(Visitor& visit, RecordedOdometryOptions& o) {
  visit("studies", o.studies, Nested(), "study files; the first condition of the first one is the picture's");
  visit("seeds", o.seeds, Between(0, 1000), "only so many seeds of each study (0: all)");
  visit("finished", o.finished, Nested(), "run nothing: conditions without a finished run are left out");
  visit("runs", o.runs, AnyText(), "folder of the runs, kept");
  visit("picture", o.picture, AnyText(), "PNG file to write (default: beside the table)");
}

/// One walk and camera, its seeds aside, tracked by one system.
struct Cell {
  Scenario scenario;
  std::vector<std::string> hashes;  ///< One per seed, of those that have run.
  std::vector<JobRecord> records;
};

// --------------------------------------------------------------------------------------------------------- runs

std::vector<uint64_t> SeedsOf(const Study& study, int count) {
  std::vector<uint64_t> seeds = study.options.seeds;
  if (count > 0 && size_t(count) < seeds.size()) seeds.resize(size_t(count));
  return seeds;
}

/// Runs what has not run yet, and reads what the runs say. Rows of one walk stand together.
std::vector<Cell> RunAll(const RecordedOdometryOptions& arguments, const ExperimentSetup& setup) {
  ExecutorOptions options;
  options.runs = arguments.runs;
  options.program = setup.program;
  options.jobs = setup.jobs;
  options.quiet = setup.quiet;
  std::vector<Cell> cells;
  std::vector<WorkItem> items;
  for (const std::string& file : arguments.studies.paths) {
    const Study study = ReadStudy(file, false);
    for (const Condition& condition : study.experiment.conditions) {
      Cell cell{condition.resolved.scenario, {}, {}};
      for (const uint64_t seed : SeedsOf(study, arguments.seeds)) {
        items.push_back(WorkItemOf(condition.WithSeed(seed), "", options.program));
        cell.hashes.push_back(items.back().hash);
      }
      cells.push_back(std::move(cell));
    }
  }
  if (!arguments.finished) {
    for (const auto& [hash, reason] : ExecuteLocally(items, options).failures) throw BadInput(hash + ": " + reason);
  }
  for (size_t next = 0; Cell & cell : cells) {
    std::vector<std::string> there;
    for (const std::string& hash : cell.hashes) {
      const std::optional<JobRecord> record = FindJob(options.runs, hash, items[next++].programs);
      if (!record) continue;
      there.push_back(hash);
      cell.records.push_back(*record);
    }
    cell.hashes = there;
  }
  std::erase_if(cells, [](const Cell& cell) { return cell.records.empty(); });
  if (cells.empty()) throw TooLittleData("no run of these studies is there");
  return cells;
}

// -------------------------------------------------------------------------------------------------------- table

/// One score of all of a cell's runs, times a factor.
std::vector<double> Column(const Cell& cell, const std::string& name, double factor = 1) {
  std::vector<double> values;
  for (const JobRecord& record : cell.records) {
    const auto at = record.scores.find(name);
    if (at != record.scores.end()) values.push_back(factor * at->second);
  }
  return values;
}

/// The system and what was set of it: "thesis_vo (feature sift)".
std::string LabelOf(const SystemChoice& system) {
  std::string settings;
  for (const auto& [name, value] : system.settings) {
    const std::string text = value.AsNumber() ? fmt::format("{:g}", *value.AsNumber()) : value.text();
    settings += fmt::format("{}{} {}", settings.empty() ? "" : ", ", name, text);
  }
  return settings.empty() ? system.name : fmt::format("{} ({})", system.name, settings);
}

/// A length, % of the path walked.
std::vector<double> OfPath(const Cell& cell, const std::string& name) {
  std::vector<double> values;
  for (const JobRecord& record : cell.records) {
    const auto length = record.scores.find(name), path = record.scores.find("path_length_m");
    if (length == record.scores.end() || path == record.scores.end()) continue;
    values.push_back(100 * length->second / path->second);
  }
  return values;
}

std::string Row(const Cell& cell) {
  std::vector<double> blur, ms;
  int scored = 0;
  for (const JobRecord& record : cell.records) {
    blur.push_back(record.blur_median_px);
    if (const auto at = record.timing.find("track_ms_mean"); at != record.timing.end()) ms.push_back(at->second);
    scored += record.not_scored.empty() ? 1 : 0;
  }
  const Scenario& s = cell.scenario;
  return fmt::format(
      "| {} | {} | {:g} ms | {} x {} | {} | {} | {} | {} of {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
      s.name, s.robot == "omni_base" ? s.robot : s.robot + ", " + s.gait.preset, s.camera.exposure.exposure_ms,
      s.camera.width_px, s.camera.height_px, MedianAndRange(blur, 1), MedianAndRange(Column(cell, "path_length_m"), 1),
      LabelOf(s.system), scored, cell.records.size(), MedianAndRange(Column(cell, "coverage_ratio", 100), 1),
      MedianAndRange(Column(cell, "live_coverage_ratio", 100), 1), MedianAndRange(OfPath(cell, "ate_sim3_rmse_m"), 2),
      MedianAndRange(OfPath(cell, "live_ate_sim3_rmse_m"), 2), MedianAndRange(OfPath(cell, "ate_rmse_m"), 2),
      MedianAndRange(Column(cell, "end_drift_sim3_pct"), 2), MedianAndRange(Column(cell, "rotation_gain"), 3),
      MedianAndRange(Column(cell, "live_jumps"), 0), MedianAndRange(ms, 0));
}

std::string TableOf(const std::vector<Cell>& cells, const ExperimentSetup& setup, const fs::path& picture) {
  std::string text = fmt::format(
      "# Odometry on recorded walks\n\nMade by `{}`.\n\n"
      "Every walk is recorded once per seed and tracked by every system; the system sees the sensors' folder alone.\n"
      "Where there are several seeds, a figure is the median over them, (min..max) in brackets. Blur is the median "
      "over\n"
      "the frames of each frame's median blur; the path is the one walked between the first and the last pose "
      "compared,\n"
      "without the gait's sway, and percentages are of it. Live is what a system said of each frame when it had seen\n"
      "nothing later, final its last word. Coverage is the part of the recorded frames that got a pose.\n"
      "The absolute error (ATE, rmse) stands under one Sim(3) alignment of the whole run and, final, under SE(3), "
      "scale\n"
      "included; the end error, between the first and the last pose, is final and under Sim(3). After a restart "
      "nothing is\n"
      "forgiven. Rotation gain is the turning about the vertical, estimated over true, over all frames. Jumps are "
      "steps of\n"
      "the live answer that the true motion makes impossible. \"-\": a run that covers less than\n"
      "10 % of the frames is not scored; how many runs were, says the column \"scored\". Errors say nothing of frames\n"
      "without a pose: read them together with the coverage. Wall time per frame is rough, for it counts whatever "
      "else\n"
      "the machine was doing.\n\n"
      "| scenario | who walks | exposure | image | blur, px | path, m | system | scored | coverage, % | live | ATE, % "
      "of "
      "path | live | ATE, SE(3) | end error, % of path | rotation gain | live jumps | ms per frame |\n"
      "|---|---|---:|---|---:|---:|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
      setup.command);
  for (const Cell& cell : cells) text += Row(cell);
  const fs::path beside = fs::absolute(setup.table).parent_path();
  text += fmt::format(
      "\n![Paths from above]({})\n\nThe paths of the first walk's first seed from above, each estimate under its "
      "Sim(3)\n"
      "alignment; where frames have no pose, or the estimate jumps, the line is broken.\n",
      fs::absolute(picture).lexically_relative(beside).generic_string());
  return text;
}

// ------------------------------------------------------------------------------------------------------ picture

/// One line of the picture, broken where `pieces` says so.
struct Curve {
  std::string label;
  cv::Scalar color;
  int width = 1;
  std::vector<std::vector<Eigen::Vector2d>> pieces;
};

std::set<int64_t> JumpStamps(const std::vector<PosePair>& aligned) {
  std::set<int64_t> stamps;
  for (const Jump& jump : FindJumps(aligned)) stamps.insert(aligned[jump.to].stamp_ns);
  return stamps;
}

std::vector<std::vector<Eigen::Vector2d>> Pieces(const Trajectory& trajectory, const std::set<int64_t>& jumps,
                                                 const Similarity& X_WV, double rate_hz) {
  std::vector<std::vector<Eigen::Vector2d>> pieces;
  int64_t last_ns = 0;
  for (const StampedPose& pose : trajectory) {
    const bool gap = double(pose.stamp_ns - last_ns) > 1.5e9 / rate_hz;
    if (pieces.empty() || gap || jumps.count(pose.stamp_ns) > 0) pieces.emplace_back();
    pieces.back().push_back((X_WV * pose.pose.translation).head<2>());
    last_ns = pose.stamp_ns;
  }
  return pieces;
}

/// Of the cells that show the first one's walk.
std::vector<Curve> Curves(const std::vector<Cell>& cells, const fs::path& runs) {
  const double rate_hz = cells.front().scenario.camera.rate_hz;
  const Trajectory truth = ReadTrajectory(runs / cells.front().hashes.front() / "truth.txt").trajectory;
  std::vector<Curve> curves{{"truth", {150, 150, 150}, 5, Pieces(truth, {}, {}, rate_hz)}};
  Scenario first = cells.front().scenario;
  std::set<std::string> drawn;  // of one system's variants the first
  for (const Cell& cell : cells) {
    const std::string& name = cell.scenario.system.name;
    first.system = cell.scenario.system;
    const bool same_walk =
        ResolvedScenario{first, {}, {}, {}}.ToYaml() == ResolvedScenario{cell.scenario, {}, {}, {}}.ToYaml();
    if (!same_walk || !drawn.insert(name).second || (name != "sift_vo" && name != "mobif_vo_plus")) continue;
    const fs::path run = runs / cell.hashes.front();
    const Trajectory estimate = ReadTrajectory(run / "estimate.txt").trajectory;
    const auto pairs = AssociatePoses(EstimateFromTrajectory(estimate).frames, truth, {});
    if (pairs.size() < 3) continue;
    const Similarity X_WV = Align(pairs, Alignment::kSim3).X_WV;
    const cv::Scalar color = name == "sift_vo" ? cv::Scalar(40, 40, 220) : cv::Scalar(200, 110, 0);
    curves.push_back({fmt::format("{}, {:.1f} %", LabelOf(cell.scenario.system),
                                  100 * cell.records.front().scores.at("coverage_ratio")),
                      color, 2, Pieces(estimate, JumpStamps(Apply(X_WV, pairs)), X_WV, rate_hz)});
  }
  return curves;
}

/// What part of the world is drawn where: x to the right, y up, the same scale for both.
struct View {
  static constexpr int kWidth = 900, kHeight = 700, kLeft = 70, kRight = 20, kTop = 95, kBottom = 60;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double px_per_m = 1;

  static cv::Rect Area() { return {kLeft, kTop, kWidth - kLeft - kRight, kHeight - kTop - kBottom}; }
  /// In the area's own coordinates.
  cv::Point2d operator()(const Eigen::Vector2d& p) const {
    return {Area().width / 2.0 + px_per_m * (p.x() - middle.x()),
            Area().height / 2.0 - px_per_m * (p.y() - middle.y())};
  }
};

/// All of the truth, and of the estimates what is not further off than half the truth's extent.
View ViewOf(const std::vector<Curve>& curves) {
  Eigen::AlignedBox2d box, all;
  for (const auto& piece : curves.front().pieces) {
    for (const auto& p : piece) box.extend(p);
  }
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(std::max(0.5, 0.5 * box.sizes().maxCoeff()));
  for (const Curve& curve : curves) {
    for (const auto& piece : curve.pieces) {
      for (const auto& p : piece) all.extend(p);
    }
  }
  all = all.intersection(Eigen::AlignedBox2d(box.min() - margin, box.max() + margin));
  View view;
  view.middle = all.center();
  view.px_per_m = 0.92 * std::min(View::Area().width / std::max(0.1, all.sizes().x()),
                                  View::Area().height / std::max(0.1, all.sizes().y()));
  return view;
}

void Write(cv::Mat& image, const std::string& text, cv::Point at, double size = 0.55) {
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, size, {30, 30, 30}, 1, cv::LINE_AA);
}

/// Lines at multiples of 1, 2 or 5 times a power of ten, at least 60 px apart.
void DrawGrid(cv::Mat& image, const View& view) {
  const double least = 60 / view.px_per_m, power = std::pow(10, std::floor(std::log10(least)));
  const double step = power * (least <= power ? 1 : least <= 2 * power ? 2 : least <= 5 * power ? 5 : 10);
  const cv::Rect area = View::Area();
  for (const int axis : {0, 1}) {
    const double half = 0.5 * (axis == 0 ? area.width : area.height) / view.px_per_m;
    for (double k = std::ceil((view.middle[axis] - half) / step); k * step <= view.middle[axis] + half; ++k) {
      Eigen::Vector2d p = view.middle;
      p[axis] = k * step;
      const cv::Point at = cv::Point(view(p)) + area.tl();
      const std::string text = fmt::format("{:g}", std::abs(k) < 0.5 ? 0 : k * step);
      if (axis == 0) {
        cv::line(image, {at.x, area.y}, {at.x, area.br().y}, {225, 225, 225});
        Write(image, text, {at.x - 4 * int(text.size()), area.br().y + 20}, 0.5);
      } else {
        cv::line(image, {area.x, at.y}, {area.br().x, at.y}, {225, 225, 225});
        Write(image, text, {area.x - 10 - 9 * int(text.size()), at.y + 5}, 0.5);
      }
    }
  }
  Write(image, "x, m", {area.x + area.width / 2 - 15, area.br().y + 45});
  Write(image, "y, m", {8, area.y - 12});
}

void DrawCurve(cv::Mat area, const View& view, const Curve& curve) {
  constexpr int kShift = 4;
  for (const auto& piece : curve.pieces) {
    std::vector<cv::Point> points;
    for (const auto& p : piece) points.emplace_back(view(p) * double(1 << kShift));
    if (points.size() == 1) points.push_back(points.front());  // a lone pose is a dot
    cv::polylines(area, points, false, curve.color, curve.width, cv::LINE_AA, kShift);
  }
}

/// In a row above the drawing, so that it hides nothing.
void DrawLegend(cv::Mat& image, const std::vector<Curve>& curves) {
  int x = View::kLeft;
  for (const Curve& curve : curves) {
    const int y = View::kTop - 42;
    cv::line(image, {x, y}, {x + 35, y}, curve.color, curve.width, cv::LINE_AA);
    Write(image, curve.label, {x + 43, y + 5}, 0.5);
    x += 43 + cv::getTextSize(curve.label, cv::FONT_HERSHEY_SIMPLEX, 0.5, 1, nullptr).width + 30;
  }
}

void DrawPaths(const std::vector<Cell>& cells, const fs::path& runs, const fs::path& picture) {
  const std::vector<Curve> curves = Curves(cells, runs);
  const View view = ViewOf(curves);
  cv::Mat image(View::kHeight, View::kWidth, CV_8UC3, cv::Scalar::all(255));
  DrawGrid(image, view);
  for (const Curve& curve : curves) DrawCurve(image(View::Area()), view, curve);
  cv::rectangle(image, View::Area(), {90, 90, 90});
  DrawLegend(image, curves);
  const Scenario& scenario = cells.front().scenario;
  Write(image,
        fmt::format("{}, seed {}, {:g} ms: paths from above", scenario.name, scenario.seed,
                    scenario.camera.exposure.exposure_ms),
        {View::kLeft, 30}, 0.65);
  if (!cv::imwrite(picture.string(), image)) throw MissingResource("cannot write " + picture.string());
}

/// How far odometry goes wrong on recorded walks: the runs of study files as a table of medians and spreads over the
/// seeds, and a picture of the paths of the first study's first walk.
class RecordedOdometry : public ExperimentOf<RecordedOdometryOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    if (options_.studies.paths.empty()) throw BadInput("studies: name at least one study file");
    const std::vector<Cell> cells = RunAll(options_, setup);
    fs::path picture = options_.picture;
    if (picture.empty()) picture = fs::path(setup.table).replace_extension(".png");
    DrawPaths(cells, options_.runs, picture);
    table_ = TableOf(cells, setup, picture);
  }
  std::string Table() const override { return table_; }

 private:
  std::string table_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakeRecordedOdometry() { return std::make_unique<RecordedOdometry>(); }

}  // namespace gaitcam
