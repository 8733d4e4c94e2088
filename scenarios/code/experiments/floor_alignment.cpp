#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "algorithms/core/random.h"
#include "algorithms/core/units.h"
#include "algorithms/planes/alignment_image.h"
#include "algorithms/planes/plane_alignment.h"
#include "models/code/scenes/scene.h"
#include "scenarios/code/experiments/processor_time.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/files/folders.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/light.h"

namespace gaitcam {
namespace {

struct FloorAlignmentOptions {
  int pairs = 200;  ///< Of each row.
};

template <class Visitor>
void VisitFields(Visitor& visit, FloorAlignmentOptions& o) {
  visit("pairs", o.pairs, Between(1, 100000), "pairs of pictures in each row; a quarter of them in rows with blur");
}

constexpr double kFramePeriod_ms = 1000.0 / 30;
constexpr double kRangeHeights = 6;  // farther floor is not aligned
constexpr double kExact_px = 0.05, kConverged_px = 0.3, kLost_px = 2;
constexpr double kTilt_deg = 1.0, kDistance = 0.01;  // how well the plane is known beforehand
const CameraModel kCamera = CameraModel::FromHorizontalFov(320, 240, 60);

/// A floor as light, in halved copies, and views of it.
class Floor {
 public:
  Floor(const std::string& name, double px_per_m) : name_(name), px_per_m_(px_per_m) {
    const Scene scene = ReadScene(name, ModelsFolder());
    min_ = scene.floor_min;
    max_ = scene.floor_max;
    cv::Mat grey, light;
    cv::cvtColor(FloorImage(scene, px_per_m), grey, cv::COLOR_BGR2GRAY);
    cv::Mat table(1, 256, CV_32FC1);
    for (int i = 0; i < 256; ++i) table.at<float>(i) = float(SrgbToLinear(i / 255.0));
    cv::LUT(grey, table, light);
    for (int k = 0; k < 7; ++k) {
      levels_.push_back(light);
      cv::Mat half;  // means of 2 x 2, so that the corners of all levels coincide
      cv::resize(light, half, {light.cols / 2, light.rows / 2}, 0, 0, cv::INTER_AREA);
      light = half;
    }
  }

  const std::string& name() const { return name_; }
  Eigen::Vector2d middle() const { return 0.5 * (min_ + max_); }
  Eigen::Vector2d size() const { return max_ - min_; }
  bool Contains(const Eigen::Vector3d& p) const {
    return p.x() > min_.x() && p.y() > min_.y() && p.x() < max_.x() && p.y() < max_.y();
  }
  /// Mean light of views from these poses; every pixel is the mean of 2 x 4 rays.
  cv::Mat Light(const std::vector<Pose>& poses_WC) const;

 private:
  float At(const Eigen::Vector3d& p, double footprint_m) const;
  static float Bilinear(const cv::Mat& image, double u, double v);

  std::string name_;
  double px_per_m_;
  Eigen::Vector2d min_, max_;
  std::vector<cv::Mat> levels_;
};

float Floor::Bilinear(const cv::Mat& image, double u, double v) {
  u = std::clamp(u, 0.0, image.cols - 1.001);
  v = std::clamp(v, 0.0, image.rows - 1.001);
  const int i = int(u), j = int(v);
  const float a = float(u - i), b = float(v - j);
  const float *top = image.ptr<float>(j) + i, *bottom = image.ptr<float>(j + 1) + i;
  return (1 - b) * ((1 - a) * top[0] + a * top[1]) + b * ((1 - a) * bottom[0] + a * bottom[1]);
}

/// Between the two levels whose pixels are next to the footprint.
float Floor::At(const Eigen::Vector3d& p, double footprint_m) const {
  const double level = std::clamp(std::log2(footprint_m * px_per_m_), 0.0, double(levels_.size()) - 1.001);
  const int k = int(level);
  const auto sample = [&](int which) {
    const double scale = px_per_m_ / double(1 << which);
    return Bilinear(levels_[size_t(which)], (p.x() - min_.x()) * scale - 0.5, (max_.y() - p.y()) * scale - 0.5);
  };
  const float share = float(level - k);
  return (1 - share) * sample(k) + (share > 0 ? share * sample(k + 1) : 0);
}

cv::Mat Floor::Light(const std::vector<Pose>& poses_WC) const {
  constexpr int kAcross = 2, kDown = 4;  // floors are foreshortened along the view
  constexpr float kBeyond = 0.3F;
  cv::Mat light(kCamera.height_px, kCamera.width_px, CV_32FC1, cv::Scalar(0));
  const float share = 1.0F / float(kAcross * kDown * int(poses_WC.size()));
  for (const Pose& X_WC : poses_WC) {
    const Eigen::Matrix3d R = X_WC.R();
    const Eigen::Vector3d& t = X_WC.translation;
    for (int v = 0; v < light.rows; ++v) {
      float* row = light.ptr<float>(v);
      for (int i = 0; i < kDown * kAcross * light.cols; ++i) {
        const int u = i / (kDown * kAcross), sample = i % (kDown * kAcross);
        const double x = u + (sample % kAcross + 0.5) / kAcross - 0.5, y = v + (sample / kAcross + 0.5) / kDown - 0.5;
        const Eigen::Vector3d ray =
            R * Eigen::Vector3d((x - kCamera.cx) / kCamera.fx, (y - kCamera.cy) / kCamera.fy, 1);
        const double depth = -t.z() / ray.z();
        const Eigen::Vector3d p = t + depth * ray;
        row[u] += share * (ray.z() < 0 && Contains(p) ? At(p, depth / kCamera.fx / kAcross) : kBeyond);
      }
    }
  }
  return light;
}

/// What is drawn for a pair.
struct PairOptions {
  double min_px = 0, max_px = 8;  ///< Mean displacement, uniform in between.
  double exposure_ms = 0;         ///< Of both pictures; while it lasts, each moves in a way of its own.
  bool noise = false;             ///< Of the simulator's sensor, at that exposure (10 ms for an instant's).
  double guess_ratio = 0;         ///< How much of the motion is foreseen.
};

/// Two pictures and what is true of them.
struct Pair {
  cv::Mat first, second, mask;  ///< `mask`: the floor within range in the first.
  PlaneState truth, guess;
  double displacement_px = 0;
  Vector6d steps[2] = {Vector6d::Zero(), Vector6d::Zero()};  ///< Motion of each from the frame before it to itself.
  double blur_ratio = 0, blur_px = 0;                        ///< Exposure over the frames' period; mean of both.
};

/// Mean distance between where two states put the floor's pixels; every 8th that both keep in view.
double MeanDistance_px(const PlaneState& a, const PlaneState& b, const cv::Mat& mask) {
  double sum = 0;
  int count = 0;
  for (int v = 0; v < mask.rows; v += 8) {
    for (int u = 0; u < mask.cols; u += 8) {
      if (mask.at<uchar>(v, u) == 0) continue;
      const auto pa = WarpPixel(kCamera, a, {double(u), double(v)}), pb = WarpPixel(kCamera, b, {double(u), double(v)});
      if (!pa || !pb || !kCamera.Contains(*pa)) continue;
      sum += (*pa - *pb).norm();
      ++count;
    }
  }
  return count > 0 ? sum / count : 1e9;
}

Pose DrawCamera(const Floor& floor, RandomStream& random) {
  const Eigen::Matrix3d forward = (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();  // camera, level
  const double pitch = random.Uniform(30, 50) * kRadPerDeg, roll = random.Normal(0, 2) * kRadPerDeg;
  const Eigen::Matrix3d R = RotZ(random.Uniform(0, 2 * M_PI)) * forward * RotX(-pitch) * RotZ(roll);
  const Eigen::Vector2d at =
      floor.middle() + floor.size().cwiseProduct(Eigen::Vector2d(random.Uniform(-0.3, 0.3), random.Uniform(-0.3, 0.3)));
  return {R, {at.x(), at.y(), random.Uniform(0.30, 0.38)}};
}

cv::Mat FloorMask(const Floor& floor, const Pose& X_WC) {
  cv::Mat mask(kCamera.height_px, kCamera.width_px, CV_8UC1, cv::Scalar(0));
  for (int v = 0; v < mask.rows; ++v) {
    for (int u = 0; u < mask.cols; ++u) {
      const Eigen::Vector3d ray = X_WC.R() * kCamera.Unproject({double(u), double(v)});
      const double depth = -X_WC.translation.z() / ray.z();
      const Eigen::Vector3d p = X_WC * (depth * kCamera.Unproject({double(u), double(v)}));
      const double range = (p - X_WC.translation).head<2>().norm();
      if (ray.z() < 0 && range < kRangeHeights * X_WC.translation.z() && floor.Contains(p)) mask.at<uchar>(v, u) = 255;
    }
  }
  return mask;
}

PlaneState PlaneSeenFrom(const Pose& X_WC) {
  PlaneState state;
  state.normal_d = -X_WC.R().row(2).transpose() / X_WC.translation.z();
  return state;
}

/// @param step motion of points in the camera's frame from one frame to the next; it is even.
cv::Mat Picture(const Floor& floor, const Pose& X_WC, const Vector6d& step, const PairOptions& options, uint64_t seed) {
  const double ratio = options.exposure_ms / kFramePeriod_ms;
  PlaneState still = PlaneSeenFrom(X_WC), moved = still;
  moved.X_CR = ExpSe3(ratio * step);
  const double blur_px = ratio > 0 ? MeanDistance_px(moved, still, FloorMask(floor, X_WC)) : 0;
  const int instants = 1 + int(std::ceil(2 * blur_px));
  std::vector<Pose> poses;
  for (int i = 0; i < instants; ++i) poses.push_back(X_WC * ExpSe3((0.5 - (i + 0.5) / instants) * ratio * step));
  cv::Mat light;
  cv::cvtColor(floor.Light(poses), light, cv::COLOR_GRAY2BGR);
  ExposureOptions exposure;
  exposure.exposure_ms = options.exposure_ms > 0 ? options.exposure_ms : 10;
  const ImageSensor sensor(exposure, true);
  return options.noise ? sensor.Develop(light, RandomStream(seed, "sensor")) : sensor.DevelopNoiseless(light);
}

/// A motion of random direction, turning and moving in like shares, that displaces the floor by that much in the mean.
Vector6d DrawMotion(const PlaneState& still, const cv::Mat& mask, double wanted_px, RandomStream& random) {
  Vector6d motion;
  for (int k = 0; k < 6; ++k) motion[k] = random.Normal() * (k < 3 ? 0.004 : 0.5 * kRadPerDeg);
  for (int i = 0; i < 6; ++i) {  // displacement is nearly linear in the motion
    PlaneState moved = still;
    moved.X_CR = ExpSe3(motion);
    motion *= wanted_px / MeanDistance_px(moved, still, mask);
  }
  return motion;
}

Pair DrawPair(const Floor& floor, const PairOptions& options, uint64_t seed) {
  RandomStream random(seed, "pair");
  const Pose X_WR = DrawCamera(floor, random);
  Pair pair;
  pair.mask = FloorMask(floor, X_WR);
  const PlaneState still = PlaneSeenFrom(X_WR);
  const auto draw = [&] {
    return DrawMotion(still, pair.mask, random.Uniform(options.min_px, options.max_px), random);
  };
  const Vector6d motion = draw();
  pair.truth = still;
  pair.truth.X_CR = ExpSe3(motion);
  pair.displacement_px = MeanDistance_px(pair.truth, still, pair.mask);
  pair.guess = still;
  const Eigen::Vector3d tilt(random.Normal(), random.Normal(), random.Normal());
  pair.guess.normal_d = ExpSe3((Vector6d() << 0, 0, 0, tilt * kTilt_deg * kRadPerDeg).finished()).R() * still.normal_d /
                        (1 + kDistance * random.Normal());
  pair.guess.X_CR = ExpSe3(options.guess_ratio * motion);
  pair.blur_ratio = options.exposure_ms / kFramePeriod_ms;
  for (Vector6d& step : pair.steps) {
    step = draw();
    PlaneState moved = still;
    moved.X_CR = ExpSe3(pair.blur_ratio * step);
    pair.blur_px += 0.5 * MeanDistance_px(moved, still, pair.mask);
  }
  pair.first = Picture(floor, X_WR, pair.steps[0], options, 2 * seed);
  pair.second = Picture(floor, X_WR * pair.truth.X_CR.Inverse(), pair.steps[1], options, 2 * seed + 1);
  return pair;
}

double Quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, size_t(q * double(values.size())))];
}

/// One row of a table.
struct Row {
  std::vector<double> errors_px, iterations, times_ms;
  int said = 0, wrongly = 0;

  void Add(const PlaneAlignment& found, const Pair& pair, double time_ms) {
    const double error_px = MeanDistance_px(found.state, pair.truth, pair.mask);
    errors_px.push_back(error_px);
    iterations.push_back(found.iterations);
    times_ms.push_back(time_ms);
    said += found.converged;
    wrongly += found.converged && error_px > kLost_px;
  }
  double Percent(int count) const { return 100.0 * count / double(std::max<size_t>(1, errors_px.size())); }
  double Within(double px) const {
    return Percent(int(std::count_if(errors_px.begin(), errors_px.end(), [px](double e) { return e <= px; })));
  }
  std::string Text() const {
    return fmt::format(
        "{:.1f} % | {:.1f} % | {:.1f} % | {:.3f} / {:.3f} px | {:.1f} % | {:.1f} % | {:.0f} / {:.0f} | {:.1f} / {:.1f}",
        Within(kExact_px), Within(kConverged_px), Within(kLost_px), Quantile(errors_px, 0.5), Quantile(errors_px, 0.95),
        Percent(int(errors_px.size()) - said), Percent(wrongly), Quantile(iterations, 0.5), Quantile(iterations, 0.95),
        Quantile(times_ms, 0.5), Quantile(times_ms, 0.95));
  }
  static std::string Head() {
    return fmt::format("≤ {:g} px | ≤ {:g} px | ≤ {:g} px | error | given up | wrong unawares | iterations | ms",
                       kExact_px, kConverged_px, kLost_px);
  }
};

/// What a row compares.
enum class Compared { kLight, kLightSharp, kDisplay };  ///< `kLightSharp`: without the model of blur.

void AlignPair(const Pair& pair, Compared compared, uint64_t seed, Row& row) {
  PlaneAlignmentOptions options;
  if (compared == Compared::kLightSharp) options.max_blur_samples = 1;
  const PlaneAligner aligner(kCamera, options);
  PlanePrior prior;
  prior.tilt_sigma_rad = kTilt_deg * kRadPerDeg;
  prior.distance_sigma = kDistance;
  const auto prepared = [&](const cv::Mat& image) {
    return compared == Compared::kDisplay ? image : AlignmentImage(image);
  };
  PlaneReference reference = aligner.MakeReference(prepared(pair.first), pair.mask);
  CurrentBlur blur(pair.blur_ratio);
  blur.X_RP = pair.truth.X_CR.Inverse() * ExpSe3(pair.steps[1]);
  RandomStream random(seed, "reference blur");  // a tracker knows the reference's blur from earlier frames, not quite
  reference.blur = (1 + 0.1 * random.Normal()) * pair.blur_ratio * pair.steps[0];
  const double before_ms = ProcessorTime_ms();
  const ImagePyramid pyramid = aligner.MakePyramid(prepared(pair.second));
  const PlaneAlignment found = aligner.Align(reference, pyramid, pair.guess, prior, blur);
  row.Add(found, pair, ProcessorTime_ms() - before_ms);
}

void Log(const std::string& text) {
  std::fprintf(stderr, "%s", text.substr(text.rfind('\n', text.size() - 2) + 1).c_str());
}

std::string BasinTable(const std::vector<Floor>& floors, int pairs) {
  std::string text =
      fmt::format("| floor | start | noise | {} |\n|---|---|---|---|---|---|---|---|---|---|---|\n", Row::Head());
  for (const Floor& floor : floors) {
    for (const auto& [min_px, max_px] : {std::pair(0.0, 8.0), std::pair(0.0, 20.0), std::pair(20.0, 30.0)}) {
      for (const bool noise : {false, true}) {
        Row row;
        for (int i = 0; i < pairs; ++i) {
          const Pair pair = DrawPair(floor, {min_px, max_px, 0, noise, 0}, uint64_t(i));
          AlignPair(pair, Compared::kLight, uint64_t(i), row);
        }
        text += fmt::format("| {} | {:g}–{:g} px | {} | {} |\n", floor.name(), min_px, max_px,
                            noise ? "sensor" : "none", row.Text());
        Log(text);
      }
    }
  }
  return text;
}

std::string ExposureTable(const std::vector<Floor>& floors, int pairs) {
  constexpr std::pair<Compared, const char*> kWays[] = {
      {Compared::kLight, "with"}, {Compared::kLightSharp, "without"}, {Compared::kDisplay, "with, display values"}};
  std::string text = fmt::format(
      "| floor | exposure | mean blur | blur model | {} |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      Row::Head());
  for (const Floor& floor : floors) {
    for (const double exposure_ms : {0.0, 5.0, 10.0, 20.0, 33.0}) {
      std::map<Compared, Row> rows;
      double blur_px = 0;
      for (int i = 0; i < pairs; ++i) {
        const Pair pair = DrawPair(floor, {2, 20, exposure_ms, true, 0.7}, uint64_t(i));
        for (const auto& [way, name] : kWays) AlignPair(pair, way, uint64_t(i), rows[way]);
        blur_px += pair.blur_px / pairs;
      }
      for (const auto& [way, name] : kWays) {
        text += fmt::format("| {} | {:g} ms | {:.1f} px | {} | {} |\n", floor.name(), exposure_ms, blur_px, name,
                            rows[way].Text());
        Log(text);
      }
    }
  }
  return text;
}

/// How far away, how exactly and how fast a floor is aligned: pairs of pictures of real floors with known motion, seen
/// by a camera as a small humanoid carries it.
class FloorAlignment : public ExperimentOf<FloorAlignmentOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    command_ = setup.command;
    cv::setNumThreads(1);  // times are one thread's
    const std::vector<Floor> floors{Floor("lab", 480), Floor("tabletop", 480)};
    basin_ = BasinTable(floors, options_.pairs);
    exposure_ = ExposureTable(floors, BlurredPairs());
  }
  std::string Table() const override { return About() + Basin() + Blur(); }

 private:
  int BlurredPairs() const { return std::max(1, options_.pairs / 4); }
  std::string About() const {
    return fmt::format(
        "# Alignment of floors\n\nMade by `{}`: pairs of pictures, 320 x 240, 60° wide, of the floors of two scenes, "
        "from 0.30 to 0.38 m above, 30° to 50° down, with a motion drawn in all six freedoms and scaled to a mean "
        "displacement (\"start\") over the floor within {:g} heights. The plane is known to {:g}° and {:g} % "
        "beforehand. "
        "An error is the mean distance between where the found and the true state put the floor's pixels. \"Given "
        "up\": "
        "the alignment says that it has not converged; \"wrong unawares\": it says that it has, more than {:g} px off. "
        "Errors, iterations and times: median / 95 % of all pairs. Times are the processor's for the current frame's "
        "pyramid and the alignment, one thread. Pictures are compared as smoothed light "
        "(algorithms/planes/alignment_image.h), except where display values are named.\n\n",
        command_, kRangeHeights, kTilt_deg, 100 * kDistance, kLost_px);
  }
  std::string Basin() const {
    return fmt::format(
        "## How far away it finds\n\n{} pairs a row, an instant's exposure, no motion foreseen. Noise: none but 8 "
        "bits, "
        "or the simulator's sensor at 10 ms.\n\n{}",
        options_.pairs, basin_);
  }
  std::string Blur() const {
    return fmt::format(
        "\n## Motion blur\n\n{} pairs a row with the sensor's noise. Each picture is smeared along a motion of its "
        "own, "
        "as a keyframe and a later frame are: 2 to 20 px from one frame to the next at 30 Hz, its share by the "
        "exposure; light is added in linear units, two instants per pixel of blur. Between the two pictures lie 2 to "
        "20 px, of which 70 % are foreseen. With the model, the current picture's blur follows from the pose that is "
        "estimated and the true pose of the frame before it, and the reference's is known to 10 %.\n\n{}",
        BlurredPairs(), exposure_);
  }

  std::string command_, basin_, exposure_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakeFloorAlignment() { return std::make_unique<FloorAlignment>(); }

}  // namespace gaitcam
