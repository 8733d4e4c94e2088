#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/geometry/stereo_motion.h"
#include "results/scoring/consistency.h"
#include "scenarios/code/experiments/ellipse_plot.h"
#include "scenarios/code/experiments/rendered_stereo.h"
#include "scenarios/code/experiments/stereo_trials.h"
#include "scenarios/code/experiments/table_experiment.h"

namespace gaitcam {
namespace {

struct StereoConsistencyOptions {
  int repeats = 1000;
  int trials = 200;
  int steps = 20;
  std::string scene = "lab";
  uint64_t seed = 1;
};

template <class Visitor>
void VisitFields(Visitor& visit, StereoConsistencyOptions& o) {
  visit("repeats", o.repeats, Between(1, 100000), "of each of the chapter's tests");
  visit("trials", o.trials, Between(2, 100000), "of each cell of the map");
  visit("steps", o.steps, Between(2, 1000), "of the rig that are rendered; half of them calibrate the pixels' error");
  visit("scene", o.scene, Words{}, "that is rendered");
  visit("seed", o.seed, Nested(), "of everything drawn");
}

constexpr double kSigma_px = 2;            // the chapter's
constexpr double kNear_m = 1, kFar_m = 4;  // of points in the chapter's tests; it does not say
constexpr int kPointSamples = 300, kPoints = 100, kMotionSamples = 1000, kRenderedPoints = 40, kMinRendered = 12;

RandomStream StreamOf(uint64_t seed, const std::string& what, int i) {
  return {seed, "nees." + what + "." + std::to_string(i)};
}

/// One of the chapter's tests, repeated.
struct RepeatedTest {
  std::string name, chapter;
  int degrees = 0;
  std::vector<double> sums;

  double Share(double normal_quantile) const {
    const ChiSquareInterval band = ChiSquareBand(degrees, normal_quantile);
    const auto inside = std::count_if(sums.begin(), sums.end(), [&](double sum) { return band.Contains(sum); });
    return double(inside) / double(sums.size());
  }
  double MeanPerDimension() const {
    return std::accumulate(sums.begin(), sums.end(), 0.0) / double(sums.size()) / degrees;
  }
};

template <class Sum>
RepeatedTest Repeat(const std::string& name, const std::string& chapter, int degrees, int repeats, int jobs, Sum sum) {
  RepeatedTest test{name, chapter, degrees, std::vector<double>(size_t(repeats))};
  InParallel(repeats, jobs, [&](int i) { test.sums[size_t(i)] = sum(i); });
  return test;
}

/// A mean over trials; those that are not numbers are left out.
class Mean {
 public:
  void Add(double value) {
    if (!std::isfinite(value)) return;
    ++n_;
    sum_ += value;
  }
  double value() const { return sum_ / n_; }
  std::string Text() const { return !n_ ? "-" : value() < 100 ? fmt::format("{:.2f}", value()) : "> 100"; }

 private:
  int n_ = 0;
  double sum_ = 0;
};

/// NEES per dimension of points, one by one, by how first order is evaluated.
struct PointCell {
  Mean chapter;        ///< Eq. 2.26, covariance at the exact pixels.
  Mean likely;         ///< Most likely point, covariance at the measured pixels, as a robot has it.
  Mean second;         ///< The same with the terms of second order.
  Mean inverse_depth;  ///< The same of first order in (x/z, y/z, 1/z).
  Mean relative;       ///< sigma_z / z.
  int first_order_holds = 0, reconstructed = 0, drawn = 0;
};

/// The same of motions, for one number of points.
struct MotionCell {
  int points = 0;
  Mean chapter;    ///< SVD, covariance at the exact pixels.
  Mean distances;  ///< SVD, covariance at the measured pixels.
  Mean likely;     ///< Most likely motion.
  Mean second;     ///< The same of points without their bias and with covariances of second order.
  Mean pixels;     ///< RefineStereoMotion.
  int chapter_holds = 0, likely_holds = 0, trials = 0;
};

MotionCell CellOf(int points) {
  MotionCell cell;
  cell.points = points;
  return cell;
}

struct MapRow {
  double baseline_m = 0, depth_m = 0, sigma_px = 0;
  PointCell point;
  std::array<MotionCell, 3> motions{CellOf(6), CellOf(25), CellOf(100)};
};

constexpr ReconstructionOptions kChapter{StereoCost::kAlgebraic, 0}, kLikely{StereoCost::kMaximumLikelihood, 3};

double InverseDepthNees(const StereoPoint& point, const Eigen::Vector3d& truth) {
  const auto coordinates = [](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p.x() / p.z(), p.y() / p.z(), 1 / p.z());
  };
  const Eigen::Vector3d& p = point.p_L;
  Eigen::Matrix3d J;
  J << 1, 0, -p.x() / p.z(), 0, 1, -p.y() / p.z(), 0, 0, -1 / p.z();
  J /= p.z();
  return SquaredNorm<3>(coordinates(p) - coordinates(truth), J * point.covariance * J.transpose()) / 3;
}

void TryPoint(const StereoRig& rig, const Eigen::Vector3d& truth, double sigma_px, RandomStream& random,
              PointCell& cell) {
  const StereoSighting exact = ExactSighting(rig, truth, sigma_px), noisy = WithNoise(exact, random);
  const StereoPoint at_truth = ReconstructPoint(rig, exact, kChapter);
  cell.relative.Add(std::sqrt(at_truth.covariance(2, 2)) / truth.z());
  cell.chapter.Add(SquaredNorm<3>(SolveLinearly(rig, noisy.left, noisy.right) - truth, at_truth.covariance) / 3);
  const StereoPoint point = ReconstructPoint(rig, noisy, kLikely);
  ++cell.drawn;
  if (!point.ok()) return;
  ++cell.reconstructed;
  cell.first_order_holds += point.first_order_holds;
  cell.likely.Add(SquaredNorm<3>(point.p_L - truth, point.covariance) / 3);
  cell.second.Add(SquaredNorm<3>(point.p_L - point.bias - truth, point.covariance + point.covariance_second) / 3);
  cell.inverse_depth.Add(InverseDepthNees(point, truth));
}

double MotionNees(const Pose& estimate, const Pose& truth, const Matrix6d& covariance) {
  return SquaredNorm<6>(Minus(truth, estimate), covariance) / 6;
}

void TryMotion(const SceneSightings& exact, RandomStream& random, MotionCell& cell) {
  const SceneSightings noisy = WithNoise(exact, random);
  ++cell.trials;
  const auto at_truth = Reconstruct(exact, kChapter), algebraic = Reconstruct(noisy, kChapter);
  if (int(algebraic.size()) == exact.size()) {
    const Pose X = FitRigidMotion(MatchesOf(algebraic), RigidMotionMethod::kSvd).X_AB;
    cell.chapter.Add(
        MotionNees(X, exact.X_AB, PropagateMotion(at_truth, exact.X_AB, MotionCost::kDistances).covariance));
    const PropagatedMotion measured = PropagateMotion(algebraic, X, MotionCost::kDistances);
    cell.distances.Add(MotionNees(X, exact.X_AB, measured.covariance));
    cell.chapter_holds += measured.first_order_holds;
  }
  const auto points = Reconstruct(noisy, kLikely);
  std::vector<PointMatch> matches = MatchesOf(points);
  if (Degeneracy(matches) != RigidMotionStatus::kOk) return;
  const LikelyMotion likely = RefineRigidMotion(matches, FitRigidMotion(matches, RigidMotionMethod::kSvd).X_AB);
  cell.likely.Add(MotionNees(likely.X_AB, exact.X_AB, likely.covariance));
  cell.likely_holds += PropagateMotion(points, likely.X_AB, MotionCost::kMaximumLikelihood).first_order_holds;
  for (size_t k = 0; k < points.size(); ++k) {
    matches[k] = {points[k].A.p_L - points[k].A.bias, points[k].B.p_L - points[k].B.bias,
                  points[k].A.covariance + points[k].A.covariance_second,
                  points[k].B.covariance + points[k].B.covariance_second};
  }
  const LikelyMotion pixels = RefineStereoMotion(exact.rig, noisy.A, noisy.B, likely.X_AB);
  cell.pixels.Add(MotionNees(pixels.X_AB, exact.X_AB, pixels.covariance));
  const LikelyMotion second = RefineRigidMotion(matches, likely.X_AB);
  cell.second.Add(MotionNees(second.X_AB, exact.X_AB, second.covariance));
}

void FillRow(MapRow& row, int trials, uint64_t seed, int number) {
  const StereoRig rig = ValenciaRig(row.baseline_m);
  RandomStream random = StreamOf(seed, "map", number);
  // Points about the depth, so that clouds have one.
  const double near_m = 0.75 * row.depth_m, far_m = 1.25 * row.depth_m;
  constexpr int kPointsPerTrial = 10;
  for (int trial = 0; trial < trials; ++trial) {
    const SceneSightings points = DrawScene(rig, Pose(), kPointsPerTrial, near_m, far_m, row.sigma_px, random);
    for (const StereoSighting& sighting : points.A)
      TryPoint(rig, SolveLinearly(rig, sighting.left, sighting.right), row.sigma_px, random, row.point);
    for (MotionCell& cell : row.motions)
      TryMotion(DrawScene(rig, StepOfTrials(), cell.points, near_m, far_m, row.sigma_px, random), random, cell);
  }
}

/// What the true motion says of covariances over rendered steps, which Monte Carlo about the measurement cannot.
struct RenderedTruth {
  int steps = 0, points = 0;
  double median_scale_px = 0, calibrated_px = 0;
  Mean by_scale, by_calibration;  ///< NEES per dimension.
  Mean error_scale_m, error_calibration_m;
};

/// The standard deviation of a pixel coordinate by how far matches miss their epipolar lines, which needs no truth.
double EpipolarSigma_px(const std::vector<RenderedStep>& steps) {
  double sum = 0;
  int count = 0;
  for (const RenderedStep& step : steps) {
    for (const auto* sightings : {&step.sightings.A, &step.sightings.B}) {
      for (StereoSighting sighting : *sightings) {
        sighting.covariance_left = sighting.covariance_right = Eigen::Matrix2d::Identity();
        const StereoPoint point = ReconstructPoint(step.sightings.rig, sighting, {StereoCost::kMaximumLikelihood, 0});
        if (!point.ok()) continue;
        sum += point.squared_error;
        ++count;
      }
    }
  }
  return std::sqrt(sum / count);
}

RenderedTruth CompareWithTruth(const std::vector<RenderedStep>& steps) {
  RenderedTruth result;
  const size_t half = steps.size() / 2;
  result.calibrated_px = EpipolarSigma_px({steps.begin(), steps.begin() + long(half)});
  std::vector<double> scales;
  for (size_t i = half; i < steps.size(); ++i) {
    SceneSightings scene = steps[i].sightings;
    ++result.steps;
    result.points += scene.size();
    for (const StereoSighting& sighting : scene.A) scales.push_back(std::sqrt(sighting.covariance_left(0, 0)));
    const auto chapter = Reconstruct(scene, kChapter);
    const Pose X = FitRigidMotion(MatchesOf(chapter), RigidMotionMethod::kSvd).X_AB;
    result.by_scale.Add(MotionNees(X, scene.X_AB, PropagateMotion(chapter, X, MotionCost::kDistances).covariance));
    result.error_scale_m.Add((X.translation - scene.X_AB.translation).norm());
    for (auto* sightings : {&scene.A, &scene.B})
      for (StereoSighting& sighting : *sightings)
        sighting.covariance_left = sighting.covariance_right =
            result.calibrated_px * result.calibrated_px * Eigen::Matrix2d::Identity();
    const auto matches = MatchesOf(Reconstruct(scene, kLikely));
    const LikelyMotion likely =
        RefineStereoMotion(scene.rig, scene.A, scene.B, FitRigidMotion(matches, RigidMotionMethod::kSvd).X_AB);
    result.by_calibration.Add(MotionNees(likely.X_AB, scene.X_AB, likely.covariance));
    result.error_calibration_m.Add((likely.X_AB.translation - scene.X_AB.translation).norm());
  }
  std::nth_element(scales.begin(), scales.begin() + long(scales.size() / 2), scales.end());
  result.median_scale_px = scales[scales.size() / 2];
  return result;
}

/// Without the points of which first order is said not to hold, in either frame; no point where it does not for the
/// motion.
SceneSightings WhereFirstOrderHolds(const SceneSightings& scene) {
  SceneSightings kept{scene.rig, scene.X_AB, {}, {}};
  for (size_t k = 0; k < scene.A.size(); ++k) {
    if (!ReconstructPoint(scene.rig, scene.A[k], kChapter).first_order_holds ||
        !ReconstructPoint(scene.rig, scene.B[k], kChapter).first_order_holds)
      continue;
    kept.A.push_back(scene.A[k]);
    kept.B.push_back(scene.B[k]);
  }
  const auto points = Reconstruct(kept, kChapter);
  if (points.size() < size_t(kMinRendered)) return {scene.rig, scene.X_AB, {}, {}};
  const Pose X_AB = FitRigidMotion(MatchesOf(points), RigidMotionMethod::kSvd).X_AB;
  if (!PropagateMotion(points, X_AB, MotionCost::kDistances).first_order_holds) return {scene.rig, scene.X_AB, {}, {}};
  return kept;
}

/// The chapter says "covariance" of what its synthetic tests have squared.
SceneSightings WithScaleAsVariance(SceneSightings scene) {
  for (auto* sightings : {&scene.A, &scene.B}) {
    for (StereoSighting& sighting : *sightings) {
      sighting.covariance_left /= std::sqrt(sighting.covariance_left(0, 0));
      sighting.covariance_right /= std::sqrt(sighting.covariance_right(0, 0));
    }
  }
  return scene;
}

std::string RowText(const MapRow& row) {
  return fmt::format("{:g} m | {:g} m | {:g} px", row.baseline_m, row.depth_m, row.sigma_px);
}

/// The chapter's tests of consistency of stereo reconstruction and of the motion between pairs, and where they end.
class StereoConsistency : public ExperimentOf<StereoConsistencyOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    command_ = setup.command;
    jobs_ = setup.jobs;
    const std::vector<RenderedStep> steps =
        RenderSteps(options_.scene, ValenciaRig(), options_.steps, kRenderedPoints, options_.seed);
    truth_ = CompareWithTruth(steps);
    RunTests(steps);
    FillMap();
    const std::filesystem::path picture = std::filesystem::path(setup.table).replace_extension(".png");
    picture_ = picture.filename().string();
    if (!cv::imwrite(picture.string(), Picture())) throw MissingResource(picture.string() + ": cannot be written");
  }
  std::string Table() const override;

 private:
  void RunTests(const std::vector<RenderedStep>& steps) {
    const StereoRig rig = ValenciaRig();
    const uint64_t seed = options_.seed;
    tests_.push_back(Repeat("one point at 1 to 4 m, 300 samples", "860.2 in [831.3, 970.4]", 3 * kPointSamples,
                            options_.repeats, jobs_, [&](int i) {
                              RandomStream random = StreamOf(seed, "point", i);
                              const SceneSightings point =
                                  DrawScene(rig, Pose(), 1, kNear_m, kFar_m, kSigma_px, random);
                              return PointNeesSum(rig, point.A[0], kPointSamples, random);
                            }));
    for (const double far_m : {2.0, kFar_m}) {
      const std::string name = fmt::format("motion by 100 points at {:g} to {:g} m, 1000 samples", kNear_m, far_m);
      tests_.push_back(
          Repeat(name, "6.07e3 in [5.8e3, 6.2e3]", 6 * kMotionSamples, options_.repeats, jobs_, [&](int i) {
            RandomStream random = StreamOf(seed, name, i);
            return MotionNeesSum(DrawScene(rig, StepOfTrials(), kPoints, kNear_m, far_m, kSigma_px, random),
                                 kMotionSamples, random);
          }));
    }
    const auto rendered = [&](const std::string& how, auto change) {
      std::vector<SceneSightings> scenes;
      for (const RenderedStep& step : steps) {
        const SceneSightings scene = change(step.sightings);
        if (scene.size() >= kMinRendered) scenes.push_back(scene);
      }
      if (scenes.empty()) return;
      const std::string name = fmt::format("{} of {} rendered steps, {}", scenes.size(), steps.size(), how);
      tests_.push_back(
          Repeat(name, "6.14e3 in [5.8e3, 6.2e3]", 6 * kMotionSamples, options_.repeats, jobs_, [&](int i) {
            RandomStream random = StreamOf(seed, "rendered." + how, i);
            return MotionNeesSum(WithNoise(scenes[size_t(i) % scenes.size()], random), kMotionSamples, random);
          }));
    };
    rendered("SIFT's scale as standard deviation", [](const SceneSightings& scene) { return scene; });
    rendered("the same, where first order holds", WhereFirstOrderHolds);
    rendered("SIFT's scale as variance", WithScaleAsVariance);
  }
  void FillMap() {
    for (const double baseline_m : {0.06, 0.12, 0.385})
      for (const double depth_m : {1.0, 2.0, 4.0, 8.0, 16.0})
        for (const double sigma_px : {0.25, 1.0, 2.0}) map_.push_back({baseline_m, depth_m, sigma_px, {}});
    InParallel(int(map_.size()), jobs_, [&](int i) { FillRow(map_[size_t(i)], options_.trials, options_.seed, i); });
  }
  cv::Mat Picture() const;
  std::string TestTable() const;
  std::string TruthTable() const;
  std::string PointTable() const;
  std::string MotionTable() const;

  std::string command_, picture_;
  int jobs_ = 0;
  std::vector<RepeatedTest> tests_;
  std::vector<MapRow> map_;
  RenderedTruth truth_;
};

EllipsePanel PointPanel(const std::string& title, double depth_m, uint64_t seed) {
  const StereoRig rig = ValenciaRig();
  const StereoSighting exact = ExactSighting(rig, {0, 0, depth_m}, kSigma_px);
  const StereoPoint point = ReconstructPoint(rig, exact, {StereoCost::kMaximumLikelihood, 0});
  RandomStream random = StreamOf(seed, title, 0);
  EllipsePanel panel{title, "x (m)", "z (m)", {}, {}};
  constexpr int kSamples = 2000;
  for (int i = 0; i < kSamples; ++i) {
    const StereoPoint sample = ReconstructPoint(rig, WithNoise(exact, random), {StereoCost::kMaximumLikelihood, 0});
    if (sample.ok()) panel.samples.emplace_back(sample.p_L.x(), sample.p_L.z());
  }
  const auto xz = [](const Eigen::Matrix3d& S) {
    Eigen::Matrix2d T;
    T << S(0, 0), S(0, 2), S(2, 0), S(2, 2);
    return T;
  };
  const Eigen::Vector3d shifted = point.p_L + point.bias;
  panel.ellipses.push_back(EllipseOf(panel.samples, "Monte Carlo", {0, 0, 0}));
  panel.ellipses.push_back({"first order", {point.p_L.x(), point.p_L.z()}, xz(point.covariance), {0, 150, 0}, true});
  panel.ellipses.push_back(
      {"second order", {shifted.x(), shifted.z()}, xz(point.covariance + point.covariance_second), {200, 60, 0}, true});
  return panel;
}

EllipsePanel MotionPanel(uint64_t seed) {
  RandomStream random = StreamOf(seed, "picture", 0);
  const SceneSightings scene = DrawScene(ValenciaRig(), StepOfTrials(), kPoints, kNear_m, kFar_m, kSigma_px, random);
  std::vector<Vector6d> poses;
  MotionNeesSum(scene, kMotionSamples, random, &poses);
  const auto points = Reconstruct(scene, kChapter);
  const Matrix6d J = EulerJacobian(scene.X_AB);
  const Matrix6d S = J * PropagateMotion(points, scene.X_AB, MotionCost::kDistances).covariance * J.transpose();
  EllipsePanel panel{"motion by 100 points", "x (m)", "z (m)", {}, {}};
  for (const Vector6d& d : poses) panel.samples.emplace_back(d[0], d[2]);
  const Vector6d d = EulerOf(scene.X_AB);
  Eigen::Matrix2d T;
  T << S(0, 0), S(0, 2), S(2, 0), S(2, 2);
  panel.ellipses.push_back(EllipseOf(panel.samples, "Monte Carlo", {0, 0, 0}));
  panel.ellipses.push_back({"propagated", {d[0], d[2]}, T, {0, 150, 0}, true});
  return panel;
}

cv::Mat StereoConsistency::Picture() const {
  return DrawPanels({PointPanel("point at 2 m, 2 px, 385 mm", 2, options_.seed), MotionPanel(options_.seed),
                     PointPanel("point at 12 m, 2 px, 385 mm", 12, options_.seed)});
}

std::string StereoConsistency::Table() const {
  return fmt::format(
             "# Does a stereo motion know its error?\n\nMade by `{}`. Source: Valencia, section 2.3.3. The rig is "
             "the chapter's, with cameras of 640 x 480 px over 60 degrees, which it does not state.\n\n",
             command_) +
         TestTable() + TruthTable() + PointTable() + MotionTable();
}

std::string StereoConsistency::TestTable() const {
  std::string text =
      "## The chapter's tests\n\nNEES of samples around exact pixels, summed; mean and covariance are those of the "
      "exact "
      "pixels. A repeat draws points and samples anew. Such a test asks whether the propagation is right, not whether "
      "a "
      "robot's covariance is: that one is made from pixels with errors (below). What it can fail by is curvature, so "
      "it "
      "depends on how far points are. The chapter's interval [831.3, 970.4] is the 90 % one.\n\n"
      "| test | chapter | first repeat | 95 % interval | in it | in the 90 % one | NEES per dimension |\n"
      "|---|---|---|---|---|---|---|\n";
  for (const RepeatedTest& test : tests_) {
    const ChiSquareInterval band = ChiSquareBand(test.degrees);
    text += fmt::format("| {} | {} | {:.1f} | [{:.1f}, {:.1f}] | {:.1f} % | {:.1f} % | {:.3f} |\n", test.name,
                        test.chapter, test.sums[0], band.low, band.high, 100 * test.Share(1.959964),
                        100 * test.Share(1.644854), test.MeanPerDimension());
  }
  return text + fmt::format("\n![Samples and ellipses of two standard deviations]({})\n\n", picture_);
}

std::string StereoConsistency::TruthTable() const {
  return fmt::format(
      "## Against the true motion\n\n{0} rendered steps of `{1}`, {2} points by SIFT. The pixels' error is calibrated "
      "on "
      "{3} other steps by the distances from epipolar lines, without truth.\n\n"
      "| weights | standard deviation | NEES per dimension | mean error |\n|---|---|---|---|\n"
      "| SVD, SIFT's scale (chapter) | {4:.2f} px in the median | {5:.3g} | {6:.2f} mm |\n"
      "| pixels, calibrated | {7:.3f} px | {8:.2f} | {9:.2f} mm |\n\n",
      truth_.steps, options_.scene, truth_.points, options_.steps / 2, truth_.median_scale_px, truth_.by_scale.value(),
      1e3 * truth_.error_scale_m.value(), truth_.calibrated_px, truth_.by_calibration.value(),
      1e3 * truth_.error_calibration_m.value());
}

std::string StereoConsistency::PointTable() const {
  std::string text = fmt::format(
      "## Where first order ends: points\n\nNEES per dimension, {} points a row. *exact*: Eq. 2.26 with the covariance "
      "at "
      "the exact pixels. The others as a robot has it: the most likely point with the covariance at the measured "
      "pixels, "
      "where infinity is 3 standard deviations away (*used*); *second*: bias taken off, covariance of second order "
      "added; *inverse*: of first order in (x/z, y/z, 1/z). *flag*: first order is said to hold.\n\n"
      "| baseline | depth | sigma | sigma_z / z | exact | used | measured | second | inverse | flag |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n",
      map_.front().point.drawn);
  for (const MapRow& row : map_) {
    const PointCell& p = row.point;
    text += fmt::format("| {} | {:.3f} | {} | {:.0f} % | {} | {} | {} | {:.0f} % |\n", RowText(row), p.relative.value(),
                        p.chapter.Text(), 100.0 * p.reconstructed / p.drawn, p.likely.Text(), p.second.Text(),
                        p.inverse_depth.Text(), p.reconstructed ? 100.0 * p.first_order_holds / p.reconstructed : 0);
  }
  return text + "\n";
}

std::string StereoConsistency::MotionTable() const {
  std::string text = fmt::format(
      "## Where first order ends: motions\n\nNEES per dimension of a step of 15 cm, {} trials a row, points at 0.75 to "
      "1.25 of the depth. *exact*, *svd*: the chapter's motion, covariance at the exact and at the measured pixels; "
      "*points*: aligned with their covariances; *second*: the same with terms of second order; *pixels*: points as "
      "unknowns. *flags*: first order is said to hold, of svd / of points.\n\n"
      "| baseline | depth | sigma | points | exact | svd | points | second | pixels | flags |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n",
      options_.trials);
  for (const MapRow& row : map_)
    for (const MotionCell& m : row.motions)
      text += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {:.0f} % / {:.0f} % |\n", RowText(row), m.points,
                          m.chapter.Text(), m.distances.Text(), m.likely.Text(), m.second.Text(), m.pixels.Text(),
                          100.0 * m.chapter_holds / m.trials, 100.0 * m.likely_holds / m.trials);
  return text;
}

}  // namespace

std::unique_ptr<TableExperiment> MakeStereoConsistency() { return std::make_unique<StereoConsistency>(); }

}  // namespace gaitcam
