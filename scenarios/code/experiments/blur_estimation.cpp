#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "algorithms/core/median.h"
#include "algorithms/core/random.h"
#include "algorithms/core/units.h"
#include "algorithms/features/blur_field.h"
#include "algorithms/features/blur_segmentation.h"
#include "algorithms/features/psf.h"
#include "algorithms/features/psf_inertial.h"
#include "algorithms/features/synthetic_blur.h"
#include "scenarios/code/experiments/photographs.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/runs/calibration_error.h"
#include "scenarios/code/runs/runner.h"

namespace gaitcam {
namespace {

struct BlurEstimationOptions {
  int walks = 10;  ///< At each exposure time, by the seeds from 1 on.
  int frames = 8;  ///< Of each walk.
};

template <class Visitor>
void VisitFields(Visitor& visit, BlurEstimationOptions& o) {
  visit("walks", o.walks, Between(1, 100000), "walks at each exposure time, each a repeat with errors of its own");
  visit("frames", o.frames, Between(1, 100000), "frames of each walk");
}

/// Estimators of one blur for the whole image, by the image alone.
constexpr std::array kImageAlone = {"whitening", "spectral", "spectral_light"};

std::vector<std::string> Photographs() {
  return {"aero1.jpg",    "aloeL.jpg",     "baboon.jpg",     "board.jpg",        "box_in_scene.png",
          "building.jpg", "butterfly.jpg", "cards.png",      "fruits.jpg",       "graf1.png",
          "graf3.png",    "home.jpg",      "leuvenA.jpg",    "messi5.jpg",       "smarties.png",
          "stuff.jpg",    "sudoku.png",    "chicky_512.png", "rubberwhale1.png", "left01.jpg"};
}

double Share(int part, int all) { return all > 0 ? 100.0 * part / all : 0; }

/// One cell: an estimator on all photographs, each blurred in directions of its own.
struct Cell {
  int all = 0, good = 0, close = 0, blurred = 0;
  std::vector<double> direction_deg, extent_px;

  void Add(const BlurEstimate& e, const LineBlur& truth) {
    const double direction = e.blur.DirectionError(truth), extent = std::abs(e.blur.extent_px - truth.extent_px);
    ++all;
    good += direction <= kRadPerDeg && extent <= 0.5;
    close += direction <= 5 * kRadPerDeg && extent <= 2;
    blurred += e.blurred;
    direction_deg.push_back(direction / kRadPerDeg);
    extent_px.push_back(extent);
  }
};

Cell EstimatePhotographs(const PsfEstimator& psf, double extent, double noise, bool linear_light, cv::Size size,
                         int directions) {
  Cell cell;
  RandomStream random(11, "directions");
  for (const std::string& name : Photographs()) {
    const cv::Mat photograph = PackagedPhotograph(name);
    for (int i = 0; i < directions; ++i) {
      const LineBlur truth{extent, random.Uniform(0, M_PI)};
      cell.Add(psf.EstimateWhole(BlurPhotograph(photograph, truth, noise, uint64_t(i), linear_light, size)), truth);
    }
  }
  return cell;
}

std::string PhotographRows(bool linear_light, cv::Size size, int directions) {
  std::string rows =
      "| estimator | extent | noise | ≤ 1°, ≤ 0.5 px | ≤ 5°, ≤ 2 px | median error | called blurred |\n"
      "|---|---|---|---|---|---|---|\n";
  for (const char* name : kImageAlone) {
    const auto psf = MakePsfEstimator(name);
    for (const double extent : {0.0, 3.0, 6.0, 10.0, 20.0, 30.0, 40.0}) {
      for (const double noise : {0.0, 2.0, 5.0}) {
        const Cell c = EstimatePhotographs(*psf, extent, noise, linear_light, size, directions);
        const std::string errors =
            extent >= 6 ? fmt::format("{:.0f} % | {:.0f} % | {:.2f}°, {:.2f} px", Share(c.good, c.all),
                                      Share(c.close, c.all), UpperMedian(c.direction_deg), UpperMedian(c.extent_px))
                        : "– | – | –";
        rows += fmt::format("| {} | {:g} px | {:g} | {} | {:.1f} % |\n", name, extent, noise, errors,
                            Share(c.blurred, c.all));
      }
    }
    std::fprintf(stderr, "photographs: %s\n", name);
  }
  return rows;
}

/// What one way of estimating says of every 8th pixel of a frame.
using VectorAt = std::function<Eigen::Vector2d(int x, int y)>;

double MedianVectorError(const cv::Mat& truth, const VectorAt& vector_at) {
  std::vector<double> errors;
  for (int y = 4; y < truth.rows; y += 8) {
    for (int x = 4; x < truth.cols; x += 8) {
      const cv::Vec2f& v = truth.at<cv::Vec2f>(y, x);
      if (std::isfinite(v[0]) && std::isfinite(v[1])) errors.push_back(BlurVectorError(vector_at(x, y), v));
    }
  }
  return errors.empty() ? 0 : UpperMedian(errors);
}

VectorAt Uniform(const BlurEstimate& e) {
  const Eigen::Vector2d v = e.blur.Vector();
  return [v](int, int) { return v; };
}

VectorAt OfRegions(std::vector<BlurRegion> regions) {
  return [regions = std::move(regions)](int x, int y) -> Eigen::Vector2d {
    for (const BlurRegion& r : regions) {
      if (r.rectangle.contains({x, y})) return r.estimate.blur.Vector();
    }
    return Eigen::Vector2d::Zero();
  };
}

/// Errors of the frames whose median blur lies in one range.
struct FrameGroup {
  int frames = 0;
  std::map<std::string, std::vector<double>> errors;
  std::map<std::string, int> alarms;  ///< Frames called blurred.
};

using Clock = std::chrono::steady_clock;

struct Timing {
  double seconds = 0;
  int count = 0;
};

class WalkTable {
  // A deduced type must be known before it is used.
  template <class Work>
  auto Timed(const std::string& name, Work&& work) {
    const auto start = Clock::now();
    auto result = work();
    times_[name].seconds += std::chrono::duration<double>(Clock::now() - start).count();
    ++times_[name].count;
    return result;
  }

 public:
  void Add(const SimulatedFrame& frame, const Calibration& calibration) {
    cv::Mat grey = frame.observation.image.pixels;
    if (grey.channels() == 3) cv::cvtColor(grey, grey, cv::COLOR_BGR2GRAY);
    const cv::Mat& truth = frame.truth.blur;
    FrameGroup& group = groups_[GroupOf(frame.truth.blur_median_px)];
    ++group.frames;
    const auto add = [&](const std::string& name, const VectorAt& vector_at, bool blurred) {
      group.errors[name].push_back(MedianVectorError(truth, vector_at));
      group.alarms[name] += blurred;
    };
    add("0 no blur assumed", Uniform({}), false);
    for (size_t i = 0; i < kImageAlone.size(); ++i) {
      const auto psf = MakePsfEstimator(kImageAlone[i]);
      const BlurEstimate e = Timed(kImageAlone[i], [&] { return psf->EstimateWhole(grey); });
      add(fmt::format("{} {}", i + 1, kImageAlone[i]), Uniform(e), e.blurred);
    }
    const auto clusters = Timed("K-means", [&] { return SegmentBlur(grey); });
    add("4 K-means, K = 2", OfRegions(clusters), AnyBlurred(clusters));
    BlurFieldOptions options;
    const BlurField affine = Timed("field", [&] { return EstimateBlurField(grey, options); });
    add("5 field, focal length unknown", At(affine), AnyBlurred(DivideByBlur(affine, grey.size(), options)));
    options.focal_px = calibration.camera.fx;
    const BlurField field = EstimateBlurField(grey, options);
    const std::vector<BlurRegion> regions = DivideByBlur(field, grey.size(), options);
    add("6 field", At(field), AnyBlurred(regions));
    add("7 field, its regions", OfRegions(regions), AnyBlurred(regions));
    const int64_t half_ns = int64_t(frame.observation.exposure_ms * 0.5e6);
    const InertialPsf inertial(frame.observation.imu, calibration.imu, calibration.camera,
                               frame.observation.stamp_ns - half_ns, frame.observation.stamp_ns + half_ns);
    add(
        "8 inertial",
        [&](int x, int y) {
          return inertial.BlurVector({double(x), double(y)});
        },
        inertial.EstimateWhole(grey).blurred);
  }

  std::string Rows() const {
    std::string header = "| estimator |", rule = "|---|", counts = "| frames |";
    std::map<std::string, std::string> rows;
    for (const auto& [key, group] : groups_) {
      header += fmt::format(" {} |", key.substr(2));
      rule += "---|";
      counts += fmt::format(" {} |", group.frames);
      for (const auto& [name, errors] : group.errors) {
        rows[name] +=
            fmt::format(" {:.2f} px ({:.0f} %) |", UpperMedian(errors), Share(group.alarms.at(name), group.frames));
      }
    }
    std::string text = header + "\n" + rule + "\n" + counts + "\n";
    for (const auto& [name, row] : rows) text += fmt::format("| {} |{}\n", name.substr(2), row);
    return text;
  }

  std::string Times() const {
    std::string text;
    for (const auto& [name, t] : times_) {
      text += fmt::format("{}{} {:.1f} ms", text.empty() ? "" : ", ", name, t.seconds / t.count * 1e3);
    }
    return text;
  }

 private:
  static std::string GroupOf(double median_px) {
    if (median_px < 3) return "0 below 3 px";
    if (median_px < 6) return "1 3–6 px";
    if (median_px < 10) return "2 6–10 px";
    return median_px < 20 ? "3 10–20 px" : "4 20 px and more";
  }
  static bool AnyBlurred(const std::vector<BlurRegion>& regions) {
    for (const BlurRegion& r : regions) {
      if (r.estimate.blurred) return true;
    }
    return false;
  }
  static VectorAt At(const BlurField& field) {
    return [field](int x, int y) { return field.VectorAt({double(x), double(y)}); };
  }
  std::map<std::string, FrameGroup> groups_;
  std::map<std::string, Timing> times_;
};

/// Every 7th frame of a brisk walk: steps and frames then have no common period. Estimators are told what a bench says
/// of camera and IMU, and read sensors as it leaves them.
void Walk(int seed, double exposure_ms, int frames, WalkTable& table) {
  constexpr int kSkip = 7;
  const ResolvedScenario resolved =
      ReadScenario(DataFolder() / "scenarios/lab_loop_brisk.yaml",
                   {fmt::format("camera.exposure_ms={:g}", exposure_ms), "variation=repeat", "calibration_error=bench",
                    fmt::format("seed={}", seed)});
  const Scenario& scenario = resolved.scenario;
  const CalibrationError error = DrawCalibrationError(scenario.calibration_error, resolved.robot, scenario.seed);
  MiscalibratedSensors sensors(error, resolved.robot, scenario.seed);
  Simulation simulation(resolved.robot, resolved.scene, SimulationOptionsOf(resolved), scenario.seed);
  const Calibration told = Miscalibrated(simulation.calibration(), error);
  TruthOptions with, without;
  with.sharp = without.sharp = false;
  without.blur = without.depth = false;
  for (int i = 0; i < frames * kSkip; ++i) {
    const bool wanted = i % kSkip == kSkip - 1;
    std::optional<SimulatedFrame> frame = simulation.Next(wanted ? with : without);
    if (!frame) break;
    sensors.Apply(frame->observation);
    if (wanted) table.Add(*frame, told);
  }
  std::fprintf(stderr, "walk %d at %g ms\n", seed, exposure_ms);
}

/// How well point spread functions are estimated: on photographs with line blur, and on the frames of brisk walks
/// against the simulator's true blur vectors.
class BlurEstimation : public ExperimentOf<BlurEstimationOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    command_ = setup.command;
    cv::setNumThreads(1);  // times are one thread's
    for (const double exposure_ms : {10.0, 20.0, 33.0}) {
      for (int seed = 1; seed <= options_.walks; ++seed) Walk(seed, exposure_ms, options_.frames, walks_);
    }
    display_ = PhotographRows(false, {640, 480}, 3);
    linear_ = PhotographRows(true, {640, 480}, 1);
    small_ = PhotographRows(false, {320, 240}, 1);
  }
  std::string Table() const override {
    return fmt::format(
        "# Point spread functions\n\nMade by `{}`.\n\n"
        "## Frames of walks\n\n`scenarios/lab_loop_brisk.yaml` at 10, 20 and 33 ms, 320 x 240, {} repeats each with a "
        "bench's calibration, every 7th frame, grouped by the frame's median blur. Each cell: median over frames of "
        "the median over pixels of the error of "
        "the blur vector; in brackets, frames called blurred.\n\n{}\n"
        "Mean times on one thread of this machine: {}.\n\n## Photographs with line blur\n\n"
        "{} photographs of Debian's opencv-doc (one a chessboard), three directions each in the first table and one in "
        "the others, at most 640 x 480 px, blurred, then cropped, then noise. Blur in display values:\n\n{}\n"
        "Blur in linear light (gamma 2.2):\n\n{}\nDisplay values, 320 x 240 px:\n\n{}",
        command_, options_.walks, walks_.Rows(), walks_.Times(), Photographs().size(), display_, linear_, small_);
  }

 private:
  std::string command_, display_, linear_, small_;
  WalkTable walks_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakeBlurEstimation() { return std::make_unique<BlurEstimation>(); }

}  // namespace gaitcam
