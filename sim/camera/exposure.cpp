#include "sim/camera/exposure.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <span>

#include "algorithms/core/errors.h"
#include "algorithms/core/median.h"
#include "sim/camera/occlusion.h"

namespace gaitcam {
namespace {

constexpr int kPointsAcross = 24;                 // points followed per image row to find the fastest
constexpr int kRollingBands = 64;                 // bands of rows whose blur vectors share one interval
constexpr int64_t kLookNs = 1000000;              // the motion is measured at least this often
constexpr int kLeastDetail = 2, kMostDetail = 3;  // pixels of a key picture in the place of one, in a row
constexpr int kFewSubframes = 7;                  // fewer are rendered sooner than one key picture
constexpr double kShapesLikePicture = 60;         // pieces of people, as long to draw as the image's size in pixels
constexpr double kGuessedDepth_m = 0.7;           // of what a small robot sees, before anything was rendered
constexpr double kMostKeyPixels = 6e6;            // of a key picture; beyond, its memory would outweigh its use
constexpr GreyError kOcclusionBound{0.3, 4};      // what depth edges may add; the rest of the error is sampling's

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

/// A point spread of a variance in px^2. Variances add: each pass of (v/2, 1 - v, v/2) adds v.
cv::Mat Soften(const cv::Mat& light, double variance) {
  const int passes = int(std::ceil(variance / 0.4));
  cv::Mat soft = light;
  for (int i = 0; i < passes; ++i) {
    const float v = float(variance / passes);
    const cv::Matx13f kernel(0.5f * v, 1 - v, 0.5f * v);
    cv::sepFilter2D(soft, soft, CV_32F, kernel, kernel, {-1, -1}, 0, cv::BORDER_REPLICATE);
  }
  return soft;
}

/// How points move through the image from one instant to the next.
MotionProfile MeasureMotion(const CameraModel& camera, const SeenPoints& points,
                            const std::vector<SceneInstant>& looks) {
  MotionProfile motion;
  std::vector<Eigen::Vector2d> first, before;
  for (const SceneInstant& look : looks) {
    std::vector<Eigen::Vector2d> now = points.Project(camera, look);
    double step = 0;
    for (size_t k = 0; k < before.size(); ++k) step = std::fmax(step, (now[k] - before[k]).norm());  // skips NaN
    motion.stamps_ns.push_back(look.stamp_ns);
    motion.travel_px.push_back(motion.travel_px.empty() ? 0 : motion.travel_px.back() + step);
    if (first.empty()) first = now;
    before = std::move(now);
  }
  DescribeFlow(first, before, motion);
  return motion;
}

/// The least detail in which a picture gives each pixel so many samples.
int DetailFor(int samples) { return int(std::ceil(std::sqrt(samples))); }

/// What the pictures of so many keys cost, in pictures of the image's own size: measured on llvmpipe, 320 x 240 px.
/// @param shape_cost of what stands in each picture, beside its pixels.
double CostOf(int keys, int detail, double shape_cost) { return keys * (0.3 + 0.75 * detail * detail + shape_cost); }

}  // namespace

ExposingCamera::ExposingCamera(const mjModel* model, const std::string& camera_name, const CameraModel& camera,
                               const FilmOptions& options)
    : model_(model),
      camera_id_(FindCamera(model, camera_name)),
      lens_(std::make_unique<Lens>(camera)),
      keys_(*lens_),
      options_(options),
      sensor_(options.exposure, options.grey, options.light_level),
      data_(MakePoseData(model)) {
  GAITCAM_ASSERT(options.antialias >= 1 && data_ != nullptr);
}

SceneInstant ExposingCamera::At(const MotionRecord& record, int64_t stamp_ns) {
  record.Evaluate(model_, stamp_ns, data_.get());
  return CaptureInstant(model_, *data_, camera_id_, stamp_ns);
}

cv::Mat ExposingCamera::DepthFrom(Renderer& renderer, const MotionRecord& record, int64_t stamp_ns, const Pose& X_CD) {
  const SceneInstant instant = At(record, stamp_ns);
  renderer.Update(*data_);
  renderer.Draw(*data_, instant.X_WC * X_CD, lens_->pinhole());
  return lens_->Depth(renderer.ReadNearness());
}

/// Camera and robot; people may be many, and few of them are seen.
SceneInstant ExposingCamera::AtWithoutPeople(const MotionRecord& record, int64_t stamp_ns) {
  record.EvaluateRobot(model_, stamp_ns, data_.get());
  return CaptureInstant(model_, *data_, camera_id_, stamp_ns, false);
}

void ExposingCamera::PosePeople(const MotionRecord& record, std::span<const int> seen,
                                std::span<SceneInstant> instants) const {
  if (record.people() == nullptr) return;
  for (SceneInstant& instant : instants) PoseSeenPeople(model_, *record.people(), seen, instant);
}

void ExposingCamera::Collect(Renderer& renderer, const Eigen::Vector2d& shift_px, std::span<const float> row_weights,
                             LightAccumulator& light) {
  renderer.ReadColor(buffer_);
  if (lens_->warps()) {
    light.AddBent(buffer_, lens_->map(), shift_px, row_weights);
  } else {
    light.Add(buffer_, row_weights);
  }
}

/// The mean of the image just rendered, sampled at the pixel centres, and `options_.antialias` more with sub-pixel
/// offsets.
cv::Mat ExposingCamera::Sharp(Renderer& renderer, const Pose& X_WC) {
  const CameraModel& camera = lens_->camera();
  LightAccumulator light(camera.width_px, camera.height_px);
  const std::vector<Eigen::Vector2d> shifts =
      options_.antialias > 1 ? PixelShifts(options_.antialias) : std::vector<Eigen::Vector2d>();
  const std::vector<float> weights(size_t(camera.height_px), 1.f / float(shifts.size() + 1));
  Collect(renderer, Eigen::Vector2d::Zero(), weights, light);
  for (const Eigen::Vector2d& shift : shifts) {
    renderer.Draw(*data_, X_WC, lens_->pinhole(), shift);
    Collect(renderer, shift, weights, light);
  }
  return Soften(light.light(), LensVariance());
}

/// The same from a finer picture.
cv::Mat ExposingCamera::Sharp(const KeyPicture& key) const {
  const CameraModel& camera = lens_->camera();
  const std::vector<Eigen::Vector2d> shifts = PixelShifts(std::max(options_.antialias, 9));
  const std::vector<float> weights(size_t(camera.height_px), 1.f / float(shifts.size()));
  cv::Mat light(camera.height_px, camera.width_px, CV_32FC4, cv::Scalar::all(0));
  std::vector<ShearedFrame> samples;
  for (const Eigen::Vector2d& shift : shifts) samples.push_back({&key.at, shift, weights});
  keys_.Add(key, samples, light);
  return SoftenSheared(light);
}

/// Through the lens, what was added up from key pictures.
cv::Mat ExposingCamera::SoftenSheared(const cv::Mat& light) const {
  cv::Mat colours;
  cv::cvtColor(light, colours, cv::COLOR_BGRA2BGR);
  return Soften(colours, LensVariance());
}

/// What it takes to draw people, in pictures of the image's own size without any. However few pixels they fill, their
/// shapes are drawn for every picture, fine or coarse.
double ExposingCamera::ShapeCost(Renderer& renderer, const Pose& X_WC) const {
  return renderer.CountPeople(X_WC, lens_->pinhole()) / kShapesLikePicture;
}

void ExposingCamera::SeeMiddle(Renderer& renderer, const MotionRecord& record, const std::vector<SceneInstant>& looks,
                               LatentFrame& latent) {
  latent.middle = At(record, latent.frame.image.stamp_ns);
  renderer.Update(*data_);
  const CameraModel& pinhole = lens_->pinhole();
  const Pose& X_WC = latent.middle.X_WC;
  latent.shape_cost = ShapeCost(renderer, X_WC);
  const std::optional<int> detail = KeyDetail(looks, latent.shape_cost);
  if (detail) {
    const CameraModel largest = keys_.Raster(std::max(*detail, kMostDetail));
    renderer.Reserve(largest.width_px, largest.height_px);
    latent.middle_key = keys_.See(renderer, *data_, latent.middle, *detail, Eigen::Vector2d::Zero(), &latent.depth);
    const KeyPicture& key = *latent.middle_key;
    if (!key.bodies.empty()) latent.bodies = key.bodies.colRange(0, latent.depth.cols);
  } else {
    renderer.Draw(*data_, X_WC, pinhole, Eigen::Vector2d::Zero(), 1, true);
    latent.depth = lens_->Depth(renderer.ReadNearness());
    if (renderer.ShowsMovingBodies()) latent.bodies = lens_->WarpLabels(renderer.Bodies(*data_));
    if (latent.wanted.sharp) {
      if (!latent.bodies.empty()) renderer.Draw(*data_, X_WC, pinhole);  // to tell them apart may have taken a picture
      latent.sharp = Sharp(renderer, X_WC);
    }
  }
  const int stride = std::max(1, lens_->camera().width_px / kPointsAcross);
  latent.points.emplace(lens_->rays(), latent.depth, latent.bodies, latent.middle, stride);
}

std::vector<SceneInstant> ExposingCamera::LookAround(const MotionRecord& record, const ShutterInterval& shutter) {
  const int64_t duration = shutter.close_ns - shutter.open_ns;
  const int64_t looks = std::clamp<int64_t>((duration + kLookNs - 1) / kLookNs, 8, 256);
  std::vector<SceneInstant> instants;
  for (int64_t i = 0; i <= looks; ++i)
    instants.push_back(AtWithoutPeople(record, shutter.open_ns + duration * i / looks));
  return instants;
}

/// In how much detail key pictures are rendered; nothing if the light is integrated plainly, as it is where few
/// sub-frames do. An edge that is misplaced by a part of a key's pixel is an error of 1 / (detail x length) of its
/// contrast in each of the `length` pixels that it passes. The image's RMS error goes with 1 / (detail x sqrt(length))
/// therefore, and with the square root of the edges' share of the image, which falls with its width.
std::optional<int> ExposingCamera::KeyDetail(const std::vector<SceneInstant>& looks, double shape_cost) const {
  const ExposureOptions& exposure = options_.exposure;
  if (exposure.integration == LightIntegration::kPlain || exposure.fixed_subframes > 0) return std::nullopt;
  const CameraModel& camera = lens_->camera();
  const cv::Mat depth(camera.height_px, camera.width_px, CV_32FC1, cv::Scalar(kGuessedDepth_m));
  const int stride = std::max(1, camera.width_px / 8);
  const SeenPoints points(lens_->rays(), depth, cv::Mat(), looks[looks.size() / 2], stride);
  const double travel_px = MeasureMotion(camera, points, looks).travel_px.back();
  const double subframes = std::max(travel_px / exposure.max_step_px, double(options_.antialias));
  if (subframes * (1 + shape_cost) < kFewSubframes + shape_cost) return std::nullopt;
  const int enough = int(std::lround(180 / std::sqrt(camera.width_px * std::max(travel_px, 1.0))));
  const int detail = std::max(std::clamp(enough, kLeastDetail, kMostDetail), DetailFor(options_.antialias));
  if (double(detail) * detail * camera.width_px * camera.height_px > kMostKeyPixels) return std::nullopt;
  return detail;
}

/// @returns 0 if all sub-frames had better be rendered.
int ExposingCamera::CountKeys(const LatentFrame& latent, const std::vector<SceneInstant>& looks,
                              const ShutterPlan& plan, const MotionProfile& motion) const {
  if (!latent.middle_key) return 0;
  const int most = int(plan.size());
  if (motion.stamps_ns.size() < 2) return 1;  // one instant
  const GreyError error = OcclusionError(*latent.middle_key, lens_->rays(), latent.depth, looks.front(), looks.back());
  int keys = 1;
  const auto suffice = [&] {
    return error.rms <= keys * kOcclusionBound.rms && error.p99_9 <= keys * kOcclusionBound.p99_9 &&
           LongestReach(PlanKeys(plan, latent.middle.stamp_ns, keys), plan, motion) <= keys_.reach_px();
  };
  while (keys <= most && !suffice()) {
    keys += 2;
    if (keys > most || 2 * CostOf(keys - 1, kLeastDetail, latent.shape_cost) > most * (1 + latent.shape_cost))
      return 0;  // plain is more exact, too
  }
  return keys;
}

cv::Mat ExposingCamera::Integrate(Renderer& renderer, const MotionRecord& record, const ShutterPlan& plan,
                                  int64_t stamp_ns) {
  const CameraModel& camera = lens_->camera();
  const std::vector<std::vector<float>> weights = SlotWeights(options_.exposure, stamp_ns, plan, camera.height_px);
  LightAccumulator light(camera.width_px, camera.height_px);
  for (size_t i = 0; i < plan.size(); ++i) {
    const Pose X_WC = At(record, plan[i].stamp_ns).X_WC;
    renderer.Move(*data_);
    renderer.Draw(*data_, X_WC, lens_->pinhole(), plan[i].shift_px);
    Collect(renderer, plan[i].shift_px, weights[i], light);
  }
  return light.light();
}

void ExposingCamera::SeeKeys(Renderer& renderer, const MotionRecord& record, const ShutterPlan& plan, int keys,
                             LatentFrame& latent) {
  const int64_t stamp_ns = latent.middle.stamp_ns;
  latent.weights = SlotWeights(options_.exposure, stamp_ns, plan, lens_->camera().height_px);
  latent.slots = PlanKeys(plan, stamp_ns, keys);
  for (const ShutterSlot& slot : plan) latent.shifts_px.push_back(slot.shift_px);
  const std::vector<Eigen::Vector2d> shifts = PixelShifts(keys);
  for (const KeySlot& slot : latent.slots) {
    if (slot.stamp_ns == stamp_ns) continue;
    const SceneInstant at = At(record, slot.stamp_ns);
    renderer.Move(*data_);
    const Eigen::Vector2d& shift = shifts[size_t(slot.first) % shifts.size()];
    latent.keys.push_back(keys_.See(renderer, *data_, at, latent.middle_key->finer, shift));
  }
}

/// What the truth about motion is measured by.
void ExposingCamera::TracePaths(const MotionRecord& record, std::span<const int> seen, LatentFrame& latent) {
  const auto at = [&](int64_t stamp_ns) {
    SceneInstant instant = AtWithoutPeople(record, stamp_ns);
    PosePeople(record, seen, {&instant, 1});
    return instant;
  };
  const int64_t stamp_ns = latent.middle.stamp_ns;
  const int rows = lens_->camera().height_px;
  const int bands = options_.exposure.readout_ms > 0 ? std::min(kRollingBands, rows) : 1;
  for (int band = 0; band < bands && latent.wanted.blur; ++band) {
    const ShutterInterval own = RowShutter(options_.exposure, stamp_ns, (band + 0.5) * rows / bands - 0.5, rows);
    latent.open_close.emplace_back(at(own.open_ns), at(own.close_ns));
  }
  const ShutterInterval own = MiddleRowShutter(options_.exposure, stamp_ns);
  latent.path = {at(own.open_ns)};
  for (const SceneInstant& instant : latent.instants) {
    if (instant.stamp_ns > own.open_ns && instant.stamp_ns < own.close_ns) latent.path.push_back(instant);
  }
  latent.path.push_back(at(own.close_ns));
  FilmedTruth& truth = latent.frame.truth;
  truth.X_WC_open = latent.path.front().X_WC;
  truth.X_WC = latent.middle.X_WC;
  truth.X_WC_close = latent.path.back().X_WC;
}

LatentFrame ExposingCamera::Film(Renderer& renderer, const MotionRecord& record, int64_t stamp_ns,
                                 const TruthOptions& wanted, RandomStream noise) {
  LatentFrame latent(wanted, noise);
  latent.frame.image.stamp_ns = stamp_ns;
  FilmedTruth& truth = latent.frame.truth;
  // Depth and motion determine the sub-frames, so they are measured whatever truth is requested: the image must not
  // depend on that.
  const ShutterInterval whole = WholeShutter(options_.exposure, stamp_ns);
  std::vector<SceneInstant> looks = LookAround(record, whole);
  SeeMiddle(renderer, record, looks, latent);
  std::vector<int> seen = SeenBodies(latent.bodies);
  PosePeople(record, seen, looks);
  MotionProfile motion;
  if (whole.close_ns > whole.open_ns) motion = MeasureMotion(lens_->camera(), *latent.points, looks);
  const ShutterPlan plan = PlanShutter(options_.exposure, stamp_ns, options_.antialias, motion);
  for (const ShutterSlot& slot : plan) {
    latent.instants.push_back(AtWithoutPeople(record, slot.stamp_ns));
    truth.subframes.push_back({slot.stamp_ns, slot.weight, latent.instants.back().X_WC});
  }
  const int keys = CountKeys(latent, looks, plan, motion);
  truth.renders = keys > 0 ? keys : int(plan.size());
  if (keys > 0) {
    SeeKeys(renderer, record, plan, keys, latent);
    for (const KeyPicture& key : latent.keys) seen.insert(seen.end(), key.seen.begin(), key.seen.end());
    std::sort(seen.begin(), seen.end());
    seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  } else {
    latent.light = Integrate(renderer, record, plan, stamp_ns);
  }
  latent.luminance = keys > 0 ? MeanLuminance(latent.middle_key->picture) : MeanLuminanceOfLight(latent.light);
  PosePeople(record, seen, latent.instants);
  TracePaths(record, seen, latent);
  return latent;
}

cv::Mat ExposingCamera::Shear(LatentFrame& latent) const {
  const CameraModel& camera = lens_->camera();
  cv::Mat light(camera.height_px, camera.width_px, CV_32FC4, cv::Scalar::all(0));
  auto other = latent.keys.begin();
  for (const KeySlot& slot : latent.slots) {
    std::vector<ShearedFrame> frames;
    for (size_t i = size_t(slot.first); i < size_t(slot.end); ++i) {
      frames.push_back({&latent.instants[i], latent.shifts_px[i], latent.weights[i]});
    }
    const bool is_middle = slot.stamp_ns == latent.middle.stamp_ns;
    KeyPicture& key = is_middle ? *latent.middle_key : *other++;
    keys_.Decode(key);
    keys_.Add(key, frames, light);
    if (is_middle && latent.wanted.sharp) latent.sharp = Sharp(key);
    key.light.release();  // the largest part of a frame's memory
  }
  return SoftenSheared(light);
}

void ExposingCamera::DescribeBlur(const LatentFrame& latent, FilmedTruth& truth) const {
  if (latent.wanted.blur) {
    truth.blur =
        BlurVectors(lens_->camera(), lens_->rays(), latent.depth, latent.bodies, latent.middle, latent.open_close);
  }
  const PathLengths lengths = MeasurePaths(lens_->camera(), *latent.points, latent.path);
  truth.blur_median_px = lengths.median_px;
  truth.blur_p90_px = lengths.p90_px;
  truth.blur_max_px = lengths.max_px;
}

ExposedFrame ExposingCamera::Develop(LatentFrame latent) const {
  ExposedFrame frame = std::move(latent.frame);
  const cv::Mat light = latent.slots.empty() ? Soften(latent.light, LensVariance()) : Shear(latent);
  const Amplification amplification = latent.amplification.value_or(sensor_.amplification());
  frame.image.pixels = sensor_.Develop(light, latent.noise, amplification);
  if (latent.wanted.sharp && latent.sharp.empty()) {  // plainly integrated after all
    keys_.Decode(*latent.middle_key);
    latent.sharp = Sharp(*latent.middle_key);
  }
  if (latent.wanted.sharp) frame.truth.sharp = sensor_.DevelopNoiseless(latent.sharp, amplification);
  if (latent.wanted.depth) frame.truth.depth = latent.depth;
  DescribeBlur(latent, frame.truth);
  return frame;
}

}  // namespace gaitcam
