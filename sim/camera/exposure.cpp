#include "sim/camera/exposure.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <span>

#include "algorithms/core/errors.h"
#include "algorithms/core/median.h"

namespace gaitcam {
namespace {

constexpr int kPointsAcross = 24;     // points followed per image row to find the fastest
constexpr int kRollingBands = 64;     // bands of rows whose blur vectors share one interval
constexpr int64_t kLookNs = 1000000;  // the motion is measured at least this often

/// Principal axis and median length of the points' motions.
void DescribeFlow(const std::vector<Eigen::Vector2d>& open, const std::vector<Eigen::Vector2d>& close,
                  MotionProfile& motion) {
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  Eigen::Vector2d sum(0, 0);
  std::vector<double> lengths;
  for (size_t i = 0; i < open.size(); ++i) {
    const Eigen::Vector2d moved = close[i] - open[i];
    if (!moved.allFinite()) continue;
    moments += moved * moved.transpose();
    sum += moved;
    lengths.push_back(moved.norm());
  }
  if (lengths.empty()) return;
  motion.typical_px = UpperMedian(std::move(lengths));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(moments);
  motion.axis = solver.eigenvectors().col(1);
  if (motion.axis.dot(sum) < 0) motion.axis = -motion.axis;
}

/// The lens's point spread, of standard deviation `sigma_px`. Variances add: each pass of (v/2, 1 - v, v/2) adds v.
cv::Mat Soften(const cv::Mat& light, double sigma_px) {
  const double variance = sigma_px * sigma_px;
  const int passes = int(std::ceil(variance / 0.4));
  cv::Mat soft = light;
  for (int i = 0; i < passes; ++i) {
    const float v = float(variance / passes);
    const cv::Matx13f kernel(0.5f * v, 1 - v, 0.5f * v);
    cv::sepFilter2D(soft, soft, CV_32F, kernel, kernel, {-1, -1}, 0, cv::BORDER_REPLICATE);
  }
  return soft;
}

}  // namespace

/// What is seen at mid-exposure.
struct ExposingCamera::Middle {
  SceneInstant instant;
  cv::Mat depth, bodies;  ///< As the camera sees them; no bodies where only the world is in view.
  cv::Mat sharp;          ///< Light of the sharp twin, if asked for.
  std::optional<SeenPoints> points;
};

ExposingCamera::ExposingCamera(const mjModel* model, const std::string& camera_name, const CameraModel& camera,
                               const FilmOptions& options)
    : model_(model),
      camera_id_(FindCamera(model, camera_name)),
      lens_(camera),
      options_(options),
      sensor_(options.exposure, options.grey),
      data_(MakePoseData(model)) {
  GAITCAM_ASSERT(options.antialias >= 1 && data_ != nullptr);
}

SceneInstant ExposingCamera::At(const MotionRecord& record, int64_t stamp_ns) {
  record.Evaluate(model_, stamp_ns, data_.get());
  return CaptureInstant(model_, *data_, camera_id_, stamp_ns);
}

void ExposingCamera::Collect(Renderer& renderer, const Eigen::Vector2d& shift_px, std::span<const float> row_weights,
                             LightAccumulator& light) {
  renderer.ReadColor(buffer_);
  if (lens_.warps()) {
    light.AddBent(buffer_, lens_.map(), shift_px, row_weights);
  } else {
    light.Add(buffer_, row_weights);
  }
}

/// The mean of the image just rendered, sampled at the pixel centres, and `options_.antialias` more with sub-pixel
/// offsets.
cv::Mat ExposingCamera::Sharp(Renderer& renderer, const Pose& X_WC) {
  const CameraModel& camera = lens_.camera();
  LightAccumulator light(camera.width_px, camera.height_px);
  const std::vector<Eigen::Vector2d> shifts =
      options_.antialias > 1 ? PixelShifts(options_.antialias) : std::vector<Eigen::Vector2d>();
  const std::vector<float> weights(size_t(camera.height_px), 1.f / float(shifts.size() + 1));
  Collect(renderer, Eigen::Vector2d::Zero(), weights, light);
  for (const Eigen::Vector2d& shift : shifts) {
    renderer.Draw(*data_, X_WC, lens_.pinhole(), shift);
    Collect(renderer, shift, weights, light);
  }
  return Soften(light.light(), options_.softness_px);
}

ExposingCamera::Middle ExposingCamera::SeeMiddle(Renderer& renderer, const MotionRecord& record, int64_t stamp_ns,
                                                 bool sharp) {
  Middle middle;
  middle.instant = At(record, stamp_ns);
  renderer.Update(*data_);
  const CameraModel& pinhole = lens_.pinhole();
  const Pose& X_WC = middle.instant.X_WC;
  renderer.Draw(*data_, X_WC, pinhole);
  middle.depth = lens_.WarpDepth(renderer.ReadDepth());
  if (sharp) middle.sharp = Sharp(renderer, X_WC);
  if (renderer.SeesMovingBodies(X_WC, pinhole)) {
    middle.bodies = lens_.WarpLabels(renderer.Bodies(*data_, X_WC, pinhole));
  }
  const int stride = std::max(1, lens_.camera().width_px / kPointsAcross);
  middle.points.emplace(lens_.rays(), middle.depth, middle.bodies, middle.instant, stride);
  return middle;
}

MotionProfile ExposingCamera::MeasureMotion(const MotionRecord& record, const ShutterInterval& shutter,
                                            const SeenPoints& points) {
  MotionProfile motion;
  std::vector<Eigen::Vector2d> first;
  const int64_t duration = shutter.close_ns - shutter.open_ns;
  const int64_t looks = std::clamp<int64_t>((duration + kLookNs - 1) / kLookNs, 8, 256);
  std::vector<Eigen::Vector2d> before;
  for (int64_t i = 0; i <= looks; ++i) {
    const int64_t stamp = shutter.open_ns + duration * i / looks;
    std::vector<Eigen::Vector2d> now = points.Project(lens_.camera(), At(record, stamp));
    double step = 0;
    for (size_t k = 0; k < before.size(); ++k) step = std::fmax(step, (now[k] - before[k]).norm());  // skips NaN
    if (i == 0) first = now;
    motion.stamps_ns.push_back(stamp);
    motion.travel_px.push_back(i == 0 ? 0 : motion.travel_px.back() + step);
    before = std::move(now);
  }
  DescribeFlow(first, before, motion);
  return motion;
}

cv::Mat ExposingCamera::Integrate(Renderer& renderer, const MotionRecord& record, const ShutterPlan& plan,
                                  FilmedTruth& truth, std::vector<SceneInstant>& instants, int64_t stamp_ns) {
  const CameraModel& camera = lens_.camera();
  std::vector<std::vector<float>> weights;  // by row, then slot
  weights.reserve(size_t(camera.height_px));
  for (int row = 0; row < camera.height_px; ++row) {
    weights.push_back(RowWeights(options_.exposure, stamp_ns, plan, row, camera.height_px));
  }
  LightAccumulator light(camera.width_px, camera.height_px);
  std::vector<float> row_weights(size_t(camera.height_px));
  for (size_t i = 0; i < plan.size(); ++i) {
    instants.push_back(At(record, plan[i].stamp_ns));
    const Pose& X_WC = instants.back().X_WC;
    truth.subframes.push_back({plan[i].stamp_ns, plan[i].weight, X_WC});
    for (int row = 0; row < camera.height_px; ++row) row_weights[row] = weights[row][i];
    renderer.Move(*data_);
    renderer.Draw(*data_, X_WC, lens_.pinhole(), plan[i].shift_px);
    Collect(renderer, plan[i].shift_px, row_weights, light);
  }
  return Soften(light.light(), options_.softness_px);
}

void ExposingCamera::DescribeBlur(const MotionRecord& record, int64_t stamp_ns, const Middle& middle,
                                  const std::vector<SceneInstant>& instants, bool vectors, FilmedTruth& truth) {
  const int rows = lens_.camera().height_px;
  const int bands = options_.exposure.readout_ms > 0 ? std::min(kRollingBands, rows) : 1;
  std::vector<std::pair<SceneInstant, SceneInstant>> open_close;
  for (int band = 0; band < bands; ++band) {
    const ShutterInterval own = RowShutter(options_.exposure, stamp_ns, (band + 0.5) * rows / bands - 0.5, rows);
    open_close.emplace_back(At(record, own.open_ns), At(record, own.close_ns));
  }
  if (vectors) {
    truth.blur = BlurVectors(lens_.camera(), lens_.rays(), middle.depth, middle.bodies, middle.instant, open_close);
  }
  const ShutterInterval own = MiddleRowShutter(options_.exposure, stamp_ns);
  std::vector<SceneInstant> path = {At(record, own.open_ns)};
  for (const SceneInstant& instant : instants) {
    if (instant.stamp_ns > own.open_ns && instant.stamp_ns < own.close_ns) path.push_back(instant);
  }
  path.push_back(At(record, own.close_ns));
  const PathLengths lengths = MeasurePaths(lens_.camera(), *middle.points, path);
  truth.blur_median_px = lengths.median_px;
  truth.blur_p90_px = lengths.p90_px;
  truth.blur_max_px = lengths.max_px;
}

ExposedFrame ExposingCamera::Expose(Renderer& renderer, const MotionRecord& record, int64_t stamp_ns,
                                    const TruthOptions& wanted, RandomStream noise) {
  ExposedFrame frame;
  FilmedTruth& truth = frame.truth;
  // Depth and motion determine the sub-frames, so they are measured whatever truth is requested: the image must not
  // depend on that.
  const Middle middle = SeeMiddle(renderer, record, stamp_ns, wanted.sharp);
  const ShutterInterval whole = WholeShutter(options_.exposure, stamp_ns);
  MotionProfile motion;
  if (whole.close_ns > whole.open_ns) motion = MeasureMotion(record, whole, *middle.points);
  const ShutterPlan plan = PlanShutter(options_.exposure, stamp_ns, options_.antialias, motion);

  std::vector<SceneInstant> instants;
  const cv::Mat light = Integrate(renderer, record, plan, truth, instants, stamp_ns);
  frame.image = {stamp_ns, sensor_.Develop(light, noise)};

  const ShutterInterval own = MiddleRowShutter(options_.exposure, stamp_ns);
  truth.X_WC_open = At(record, own.open_ns).X_WC;
  truth.X_WC = middle.instant.X_WC;
  truth.X_WC_close = At(record, own.close_ns).X_WC;
  if (wanted.sharp) truth.sharp = sensor_.DevelopNoiseless(middle.sharp);
  if (wanted.depth) truth.depth = middle.depth;
  DescribeBlur(record, stamp_ns, middle, instants, wanted.blur, truth);
  return frame;
}

}  // namespace gaitcam
