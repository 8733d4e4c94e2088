#include "algorithms/features/psf_path.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/features/light_response.h"
#include "algorithms/features/wiener.h"

namespace gaitcam {
namespace {

constexpr double kLowest = 0.02, kHighest = 0.3;  ///< Cycles/px, as psf_spectral.h.
constexpr int kRings = 12;
/// A zero is never seen deeper than this; and of LogSpectrum's floors, which count a zero's neighbourhood, this part.
constexpr float kLeastFloor = 0.003f, kSeenFloorShare = 0.3f;
constexpr double kFreedom = 0.01;      ///< Of agreement, by which a path of more modes must be better.
constexpr float kWindowFloor = 0.01f;  ///< What the window smears into the zeros of those that are compared first.

/// What pictures have of their own is taken out; then scaled to length 1. @returns the length before.
float RemovePicture(const Eigen::MatrixXf& picture, Eigen::VectorXf& values) {
  const Eigen::VectorXf shares = picture.transpose() * values;
  values -= picture * shares;
  const float length = values.norm();
  if (length > 0) values /= length;
  return length;
}

/// Laplacian in units of grey levels, as PowerSpectrum expects it.
cv::Mat LaplacianOf(const cv::Mat& image) {
  cv::Mat edges;
  cv::Laplacian(image, edges, CV_32F, 1, -255);
  return edges(cv::Rect(1, 1, image.cols - 2, image.rows - 2));
}

/// Power at multiples of 1 / kWindow_px, x from 0 to `reach`, y from -reach to reach (rows), as the Hann window of the
/// spectrum smears it: its transform's three taps, squared, along both axes.
Eigen::ArrayXXf SmearedPower(const BlurPath& path, int reach) {
  std::vector<double> fx, fy;
  for (int x = -1; x <= reach + 1; ++x) fx.push_back(double(x) / PathSpectrum::kWindow_px);
  for (int y = -reach - 1; y <= reach + 1; ++y) fy.push_back(double(y) / PathSpectrum::kWindow_px);
  const Eigen::ArrayXXf power = PathTransfer(path, fx, fy).abs2();
  const long n = 2 * reach + 1, m = reach + 1;
  const Eigen::ArrayXXf down = (power.topRows(n) + 4 * power.middleRows(1, n) + power.bottomRows(n)) / 6;
  return (down.leftCols(m) + 4 * down.middleCols(1, m) + down.rightCols(m)) / 6;
}

}  // namespace

PathSpectrum::PathSpectrum(const cv::Mat& image) {
  GAITCAM_ASSERT(image.type() == CV_32FC1 && image.rows > 2 && image.cols > 2);
  PowerSpectrum spectrum(kWindow_px);
  spectrum.Add(LaplacianOf(image));
  if (spectrum.empty()) return;
  const LogSpectrum log = MakeLogSpectrum(spectrum, kLowest, kHighest, kRings);
  samples_ = log.samples;
  const auto radius = [](const SpectrumSample& s) { return s.fx * s.fx + s.fy * s.fy; };
  std::stable_sort(samples_.begin(), samples_.end(),
                   [&](const SpectrumSample& a, const SpectrumSample& b) { return radius(a) < radius(b); });
  floors_ = log.floors;
  for (float& floor : floors_) floor = std::max(kLeastFloor, kSeenFloorShare * floor);
  for (const SpectrumSample& s : samples_)
    places_.emplace_back(int(std::lround(s.fx * kWindow_px)), int(std::lround(s.fy * kWindow_px)));
  for (const double highest : {0.12, 0.2, kHighest}) bands_.push_back(MakeBand(highest));
}

PathSpectrum::Band PathSpectrum::MakeBand(double highest) const {
  Band band;
  band.reach = int(highest * kWindow_px);
  while (band.samples < long(samples_.size()) &&
         std::hypot(samples_[size_t(band.samples)].fx, samples_[size_t(band.samples)].fy) <= float(highest))
    ++band.samples;
  band.picture = Eigen::MatrixXf::Zero(band.samples, kRings + 8);
  band.seen.resize(band.samples);
  for (long i = 0; i < band.samples; ++i) {
    const SpectrumSample& s = samples_[size_t(i)];
    band.seen[i] = s.value;
    band.picture(i, s.ring) = 1;
    const double angle = std::atan2(double(s.fy), double(s.fx)), slope = std::hypot(s.fx, s.fy) / kHighest;
    for (int k = 0; k < 4; ++k) {  // two lobes and four, each along both diagonals
      const double wave = k % 2 ? std::sin((k + 1 + k % 2) / 2 * 2 * angle) : std::cos((k + 2) / 2 * 2 * angle);
      band.picture(i, kRings + 2 * k) = float(wave);
      band.picture(i, kRings + 2 * k + 1) = float(wave * slope);
    }
  }
  // Rings above the band have no samples: those columns stay zero.
  for (long k = 0; k < band.picture.cols(); ++k) {
    for (long j = 0; j < k; ++j)
      band.picture.col(k) -= band.picture.col(j).dot(band.picture.col(k)) * band.picture.col(j);
    const float length = band.picture.col(k).norm();
    if (length > 1e-3f)
      band.picture.col(k) /= length;
    else
      band.picture.col(k).setZero();
  }
  band.depth = RemovePicture(band.picture, band.seen) / std::sqrt(float(std::max(1L, band.samples)));
  return band;
}

Eigen::VectorXf PathSpectrum::Model(const BlurPath& path, const Band& band) const {
  const int reach = band.reach;
  const Eigen::ArrayXXf power = SmearedPower(path, reach);
  Eigen::VectorXf values(band.samples);
  for (long i = 0; i < band.samples; ++i) {
    const cv::Point& p = places_[size_t(i)];
    values[i] = std::log(power(p.y + reach, p.x) + floors_[size_t(samples_[size_t(i)].ring)]);
  }
  RemovePicture(band.picture, values);
  return values;
}

double PathSpectrum::Agreement(const BlurPath& path) const {
  return empty() ? -1 : double(Model(path, bands_.back()).dot(bands_.back().seen));
}

namespace {

/// A path of cosines: coefficients (x, y) of cos(pi j t), j = 1, 2, ...
BlurPath WithModes(const BlurPath& start, const Eigen::VectorXd& modes) {
  BlurPath path = start;
  const double last = double(path.points.size() - 1);
  for (size_t i = 0; i < path.points.size(); ++i)
    for (long j = 0; j < modes.size() / 2; ++j)
      path.points[i] += std::cos(M_PI * double(j + 1) * double(i) / last) * modes.segment<2>(2 * j);
  return path;
}

BlurPath Centred(BlurPath path) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (size_t i = 0; i + 1 < path.points.size(); ++i)
    mean += 0.5 * (path.points[i] + path.points[i + 1]) / double(path.points.size() - 1);
  for (Eigen::Vector2d& p : path.points) p -= mean;
  return path;
}

}  // namespace

double PathDistance(const BlurPath& a, const BlurPath& b) {
  if (a.empty() || b.empty()) return std::abs(a.Length() - b.Length());
  constexpr int kPoints = 17;
  const BlurPath p = Centred(Resampled(a, kPoints)), q = Centred(Resampled(b, kPoints));
  double least = 1e9;
  for (const bool reversed : {false, true})
    for (const double sign : {1.0, -1.0}) {
      double squares = 0;
      for (size_t i = 0; i < size_t(kPoints); ++i)
        squares += (p.points[i] - sign * q.points[reversed ? size_t(kPoints) - 1 - i : i]).squaredNorm();
      least = std::min(least, std::sqrt(squares / kPoints));
    }
  return least;
}

PathFit PathSpectrum::Refine(const BlurPath& start, int modes, int number) const {
  constexpr int kPoints = 33, kRounds = 10;
  constexpr double kStep_px = 0.1;
  if (empty()) return {start, -1};
  const Band& band = bands_[size_t(number)];
  const BlurPath base = Resampled(start, kPoints);
  Eigen::VectorXd at = Eigen::VectorXd::Zero(2 * modes);
  Eigen::VectorXf model = Model(base, band);
  double best = double(model.dot(band.seen)), damping = 1e-5;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::MatrixXf J(model.size(), at.size());
    for (long k = 0; k < at.size(); ++k) {
      Eigen::VectorXd moved = at;
      moved[k] += kStep_px;
      J.col(k) = (Model(WithModes(base, moved), band) - model) / float(kStep_px);
    }
    const Eigen::MatrixXd JJ = (J.transpose() * J).cast<double>();
    const Eigen::VectorXd g = (J.transpose() * (band.seen - model)).cast<double>();
    bool better = false;
    double gain = 0;
    for (int trial = 0; trial < 5 && !better; ++trial, damping *= 6) {
      const Eigen::MatrixXd damped = JJ + damping * Eigen::MatrixXd::Identity(at.size(), at.size());
      const Eigen::VectorXd next = at + damped.ldlt().solve(g);
      const Eigen::VectorXf there = Model(WithModes(base, next), band);
      const double agreement = double(there.dot(band.seen));
      if (!(agreement > best)) continue;
      gain = agreement - best;
      at = next;
      model = there;
      best = agreement;
      better = true;
      damping /= 60;
    }
    if (!better || gain < 2e-4) break;
  }
  return {Centred(WithModes(base, at)), best};
}

namespace {

/// |H|^2 of a path of length 1 over its frequency, from -16 to 16 cycles along both axes.
class ShapePower {
 public:
  ShapePower(double bend_rad, double steepness) {
    constexpr int kPoints = 65;
    double heading = -bend_rad / 2;
    Eigen::Vector2d at(0, 0);
    for (int i = 0; i < kPoints; ++i) {
      unit_.points.push_back(at);
      const double t = (i + 0.5) / (kPoints - 1), step = (1 + steepness * (2 * t - 1)) / (kPoints - 1);
      heading = bend_rad * ((t - 0.5) + steepness * (t * t - t));
      at += step * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    }
    unit_ = Centred(unit_);
    BlurPath scaled = unit_;
    for (Eigen::Vector2d& p : scaled.points) p *= kScale;
    power_ = PathTransfer(scaled, {kSide, kSide}).abs2();
  }

  float At(float u, float v) const {
    if (u < 0) u = -u, v = -v;
    const float x = u * float(kSide / kScale), y = v * float(kSide / kScale);
    const int column = std::min(int(x + 0.5f), kSide / 2), row = int(std::lround(y)) & (kSide - 1);
    return power_(row, column);
  }

  /// Of this length, turned.
  BlurPath Path(double length_px, double direction_rad) const {
    BlurPath path = unit_;
    for (Eigen::Vector2d& p : path.points) p = length_px * (Eigen::Rotation2Dd(direction_rad) * p);
    return path;
  }

 private:
  static constexpr int kSide = 512;
  static constexpr double kScale = 16;  // px of a unit: 32 samples to a cycle
  BlurPath unit_;
  Eigen::ArrayXXf power_;
};

/// Bends and speeds that are compared first. A bent path and its mirror image differ only if it is uneven.
const std::vector<ShapePower>& Shapes() {
  static const std::vector<ShapePower> shapes = [] {
    std::vector<ShapePower> all;
    for (const double bend : {0.0, 0.7, 1.5})
      for (const double steepness : {0.0, 0.4, 0.75}) {
        all.emplace_back(bend, steepness);
        if (bend > 0 && steepness > 0) all.emplace_back(-bend, steepness);
      }
    return all;
  }();
  return shapes;
}

struct PathCandidate {
  double agreement = -1;
  BlurPath path;
};

}  // namespace

PathFit PathSpectrum::Search(double min_extent_px, double max_extent_px) const {
  constexpr long kSamples = 900;  // of a band, for the comparison of all shapes
  constexpr int kDirections = 36;
  constexpr size_t kKept = 5;
  constexpr double kLengthStep = 1.09, kApart_px = 2.5;
  if (empty()) return {};
  std::vector<PathCandidate> found;
  // Each band alone: few of its samples are enough to tell the best.
  const Band& band = bands_[1];
  const long stride = std::max(1L, band.samples / kSamples), count = band.samples / stride;
  Eigen::MatrixXf picture(count, band.picture.cols());
  Eigen::VectorXf seen(count);
  for (long i = 0; i < count; ++i) {
    picture.row(i) = band.picture.row(i * stride);
    seen[i] = band.seen[i * stride];
  }
  for (long k = 0; k < picture.cols(); ++k) {
    for (long j = 0; j < k; ++j) picture.col(k) -= picture.col(j).dot(picture.col(k)) * picture.col(j);
    const float length = picture.col(k).norm();
    if (length > 1e-3f)
      picture.col(k) /= length;
    else
      picture.col(k).setZero();
  }
  RemovePicture(picture, seen);
  Eigen::VectorXf values(count);
  for (const ShapePower& shape : Shapes())
    for (double length = min_extent_px; length <= max_extent_px; length *= kLengthStep)
      for (int d = 0; d < kDirections; ++d) {
        const double direction = M_PI * d / kDirections;
        const float c = float(length * std::cos(direction)), s = float(length * std::sin(direction));
        for (long i = 0; i < count; ++i) {
          const SpectrumSample& sample = samples_[size_t(i * stride)];
          values[i] = std::log(shape.At(c * sample.fx + s * sample.fy, -s * sample.fx + c * sample.fy) +
                               floors_[size_t(sample.ring)] + kWindowFloor);
        }
        RemovePicture(picture, values);
        const double agreement = double(values.dot(seen));
        if (found.size() == kKept && agreement <= found.back().agreement) continue;
        const BlurPath path = shape.Path(length, direction);
        const auto near = [&](const PathCandidate& other) { return PathDistance(path, other.path) < kApart_px; };
        const auto same = std::find_if(found.begin(), found.end(), near);
        if (same != found.end() && same->agreement >= agreement) continue;
        std::erase_if(found, near);
        found.push_back({agreement, path});
        std::stable_sort(found.begin(), found.end(),
                         [](const PathCandidate& a, const PathCandidate& b) { return a.agreement > b.agreement; });
        found.resize(std::min(found.size(), kKept));
      }
  // All by their bends first; the two best by all that a path may have.
  std::vector<PathFit> fits;
  for (const PathCandidate& candidate : found) fits.push_back(Refine(Refine(candidate.path, 2, 1).path, 2, 2));
  std::stable_sort(fits.begin(), fits.end(),
                   [](const PathFit& a, const PathFit& b) { return a.agreement > b.agreement; });
  PathFit best = fits.front();
  for (size_t i = 0; i < std::min<size_t>(2, fits.size()); ++i) {
    PathFit fit = Refine(Refine(fits[i].path, 4, 1).path, 7, 1);
    fit = Refine(fit.path, 7, 2);
    if (fit.agreement > best.agreement + kFreedom) best = fit;
  }
  return best;
}

namespace {

BlurPath HalfTurned(BlurPath path) {
  for (Eigen::Vector2d& p : path.points) p = -p;
  return path;
}

/// Mean absolute over root mean square difference of neighbours: small for few and strong edges.
double EdgeSpread(const cv::Mat& image) {
  double sum = 0, squares = 0;
  for (const cv::Point step : {cv::Point(1, 0), cv::Point(0, 1)}) {
    const cv::Size size(image.cols - step.x, image.rows - step.y);
    const cv::Mat d = image(cv::Rect(step, size)) - image(cv::Rect({0, 0}, size));
    sum += cv::norm(d, cv::NORM_L1) / double(d.total());
    squares += cv::norm(d, cv::NORM_L2SQR) / double(d.total());
  }
  return squares > 0 ? sum / std::sqrt(squares) : 1;
}

}  // namespace

EdgeSpreads CompareEdges(const cv::Mat& image, const BlurPath& path) {
  constexpr int kSide_px = 400;
  WienerOptions options;
  options.gamma = 0.01;
  options.gamma_slope = 0.3;
  options.border_passes = 1;
  const cv::Size size(std::min(image.cols, kSide_px), std::min(image.rows, kSide_px));
  const cv::Mat middle = image(cv::Rect({(image.cols - size.width) / 2, (image.rows - size.height) / 2}, size));
  const int border = std::min({24, size.width / 4, size.height / 4});
  const cv::Rect inside(border, border, size.width - 2 * border, size.height - 2 * border);
  return {EdgeSpread(middle(inside)), EdgeSpread(RestoreWiener(middle, path, options)(inside)),
          EdgeSpread(RestoreWiener(middle, HalfTurned(path), options)(inside))};
}

namespace {

cv::Mat DisplayValues(const cv::Mat& grey) {
  cv::Mat values;
  grey.convertTo(values, CV_32F, 1 / 255.0);
  return values;
}

constexpr int kMinSide_px = 64;

BlurPath PathOfLine(const LineBlur& line) { return {{-0.5 * line.Vector(), 0.5 * line.Vector()}}; }

/// Logistic in the agreement, the length, as a long and wild path agrees with any image a little, and in how much the
/// restored image is the sharper one. Fitted to what 8 photographs gained and 14 sharp ones lost
/// (results/features.md).
double ConfidenceOf(const PathEstimate& estimate) {
  constexpr double kAtZero = 5.69, kOfAgreement = 13.35, kOfLength = -3.39, kOfSharpened = 9.25;
  const double score = kAtZero + kOfAgreement * estimate.agreement +
                       kOfLength * std::log(std::max(1.0, estimate.path.Length())) + kOfSharpened * estimate.sharpened;
  return 1 / (1 + std::exp(-score));
}

}  // namespace

PathEstimate EstimatePath(const cv::Mat& grey, const LineBlur& line) {
  GAITCAM_ASSERT(grey.type() == CV_8UC1);
  constexpr double kShortest_px = 5, kLongest_px = 60;
  PathEstimate estimate;
  if (std::min(grey.rows, grey.cols) < kMinSide_px) return estimate;
  const cv::Mat display = DisplayValues(grey), light = LightOfGrey(grey);
  const PathSpectrum of_display(display), of_light(light);
  if (of_display.empty() || of_light.empty()) return estimate;
  PathFit fit = of_display.Search(kShortest_px, kLongest_px);
  const PathFit in_light = of_light.Refine(fit.path, 4);
  estimate.of_light = in_light.agreement > fit.agreement;
  if (estimate.of_light) fit = in_light;
  const PathSpectrum& spectrum = estimate.of_light ? of_light : of_display;
  estimate.agreement = fit.agreement;
  estimate.depth = spectrum.depth() * fit.agreement;
  estimate.straight =
      line.extent_px >= kShortest_px && spectrum.Agreement(PathOfLine(line)) >= fit.agreement - kFreedom;
  const EdgeSpreads edges = CompareEdges(estimate.of_light ? light : display, fit.path);
  estimate.path = edges.restored <= edges.half_turned ? fit.path : HalfTurned(fit.path);
  estimate.orientation = std::abs(std::log(edges.restored / edges.half_turned));
  estimate.sharpened = std::log(edges.image / std::min(edges.restored, edges.half_turned));
  estimate.confidence = ConfidenceOf(estimate);
  return estimate;
}

bool PathsActedOnLight(const cv::Mat& grey, const std::vector<BlurRegion>& regions) {
  constexpr size_t kMost = 6;
  constexpr int kSeen_px = 160;
  std::vector<BlurRegion> longest = regions;
  std::stable_sort(longest.begin(), longest.end(),
                   [](const BlurRegion& a, const BlurRegion& b) { return a.path.Length() > b.path.Length(); });
  longest.resize(std::min(longest.size(), kMost));
  double more = 0;
  for (const BlurRegion& region : longest) {
    if (region.path.empty()) continue;
    const cv::Point middle = (region.rectangle.tl() + region.rectangle.br()) / 2;
    const cv::Rect around =
        (cv::Rect(middle.x - kSeen_px / 2, middle.y - kSeen_px / 2, kSeen_px, kSeen_px) | region.rectangle) &
        cv::Rect({0, 0}, grey.size());
    if (std::min(around.width, around.height) < kMinSide_px) continue;
    const cv::Mat part = grey(around);
    more += PathSpectrum(LightOfGrey(part)).Agreement(region.path) -
            PathSpectrum(DisplayValues(part)).Agreement(region.path);
  }
  return more > 0;
}

}  // namespace gaitcam
