#include "scenarios/code/experiments/feature_experiment.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <tuple>

#include "algorithms/core/errors.h"
#include "algorithms/core/median.h"
#include "algorithms/core/random.h"
#include "algorithms/features/mobif.h"
#include "algorithms/features/mobif_adapt.h"
#include "algorithms/geometry/depth_image.h"
#include "algorithms/io/dataset_layout.h"
#include "algorithms/io/dataset_reader.h"
#include "algorithms/io/trajectory_file.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/runs/recorded_walk.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr double kGamma = 2.2;  ///< Between light and grey values.

cv::Mat ReadGrey(const fs::path& file) {
  cv::Mat grey = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  if (grey.empty()) throw BadInput(file.string() + ": cannot be read as an image");
  return grey;
}

/// The image of number `n`, whatever its format; empty path if there is none.
fs::path OxfordImage(const fs::path& folder, int n) {
  for (const char* suffix : {".ppm", ".pgm", ".png", ".jpg"}) {
    const fs::path file = folder / ("img" + std::to_string(n) + suffix);
    if (fs::exists(file)) return file;
  }
  return {};
}

Matrix3d ReadOxfordHomography(const fs::path& file) {
  std::ifstream in(file);
  Matrix3d H;
  for (int i = 0; i < 9; ++i)
    if (!(in >> H(i / 3, i % 3))) throw BadInput(file.string() + ": should hold the nine numbers of a homography");
  return H;
}

Matrix3d ReadXmlHomography(const fs::path& file) {
  cv::Mat H;
  const cv::FileStorage storage(file.string(), cv::FileStorage::READ);
  if (storage.isOpened()) storage["H13"] >> H;
  if (H.rows != 3 || H.cols != 3) throw BadInput(file.string() + ": should hold the 3 x 3 matrix H13");
  H.convertTo(H, CV_64F);
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(H.ptr<double>());
}

Vector2d Apply(const Matrix3d& H, const Vector2d& p) { return (H * p.homogeneous()).hnormalized(); }

/// A view from the side: turned, nearer or further, tilted; the picture's middle stays about where it is.
Matrix3d RandomHomography(const cv::Size& size, RandomStream& random) {
  const double angle = random.Uniform(-0.4, 0.4), zoom = random.Uniform(0.75, 1.1);
  Matrix3d centre = Matrix3d::Identity(), view = Matrix3d::Identity();
  centre.topRightCorner<2, 1>() = -0.5 * Vector2d(size.width, size.height);
  view.topLeftCorner<2, 2>() = zoom * Eigen::Rotation2Dd(angle).toRotationMatrix();
  view(0, 1) += random.Uniform(-0.15, 0.15);
  const double side = double(std::max(size.width, size.height));
  view(2, 0) = random.Uniform(-0.3, 0.3) / side;
  view(2, 1) = random.Uniform(-0.3, 0.3) / side;
  return centre.inverse() * view * centre;
}

double ToLight(double grey) { return std::pow(std::clamp(grey / 255, 0.0, 1.0), kGamma); }
double ToGrey(double light) { return 255 * std::pow(std::clamp(light, 0.0, 1.0), 1 / kGamma); }

template <class Curve>
void ApplyCurve(cv::Mat& image, Curve curve) {
  for (int y = 0; y < image.rows; ++y)
    for (float& v : cv::Mat_<float>(image.row(y))) v = float(curve(double(v)));
}

}  // namespace

Matrix3d AfterCrop(const Matrix3d& H_ba) {
  Matrix3d shift = Matrix3d::Identity();
  shift(0, 2) = shift(1, 2) = kCrop_px;
  return shift.inverse() * H_ba * shift;
}

std::vector<ImagePair> ReadPairs(const fs::path& folder) {
  std::vector<ImagePair> pairs;
  const std::string name = fs::absolute(folder).lexically_normal().filename().string();
  if (fs::exists(folder / "H1to3p.xml") && fs::exists(folder / "graf1.png"))
    return {{"graf 1-3", ReadGrey(folder / "graf1.png"), ReadGrey(folder / "graf3.png"),
             ReadXmlHomography(folder / "H1to3p.xml")}};
  const fs::path first = OxfordImage(folder, 1);
  for (int n = 2; n <= 6 && !first.empty(); ++n) {
    const fs::path other = OxfordImage(folder, n), homography = folder / ("H1to" + std::to_string(n) + "p");
    if (other.empty() || !fs::exists(homography)) continue;
    pairs.push_back(
        {name + " 1-" + std::to_string(n), ReadGrey(first), ReadGrey(other), ReadOxfordHomography(homography)});
  }
  if (pairs.empty())
    throw BadInput(folder.string() + ": no image pair; expected img1.png, img2.png, H1to2p and the like");
  return pairs;
}

std::vector<ImagePair> MakePairs(const std::vector<fs::path>& photographs, uint64_t seed) {
  constexpr int kWidth_px = 800;
  std::vector<ImagePair> pairs;
  for (const fs::path& file : photographs) {
    ImagePair pair;
    pair.name = file.stem().string();
    cv::Mat photograph = ReadGrey(file);
    const double scale = double(kWidth_px) / photograph.cols;
    if (scale < 1) cv::resize(photograph, photograph, cv::Size(), scale, scale, cv::INTER_AREA);
    RandomStream random(seed, "pair " + pair.name);
    pair.a = photograph;
    pair.H_ba = RandomHomography(pair.a.size(), random);
    cv::Mat H(3, 3, CV_64F);
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(H.ptr<double>()) = pair.H_ba;
    cv::warpPerspective(pair.a, pair.b, H, pair.a.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT_101);
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

TrueMap MapOfHomography(const Matrix3d& H_ba) {
  return [H_ba](const Vector2d& pixel) { return Apply(H_ba, pixel); };
}

namespace {

/// One frame of a recording and what is true of it.
struct WalkFrame {
  cv::Mat grey, depth;  ///< Depth: CV_16UC1, metres times kDepthScale.
  Pose X_WC;
  double blur_px = 0;
};
constexpr double kDepthScale = 5000;

/// Depth at the nearest pixel, m; nothing where it is unknown or jumps.
std::optional<double> SteadyDepthAt(const cv::Mat& depth, const Vector2d& pixel) {
  constexpr double kJump = 1.03;  // ratio of neighbouring depths that is an edge of something
  const int x = int(std::lround(pixel.x())), y = int(std::lround(pixel.y()));
  if (!cv::Rect(2, 2, depth.cols - 4, depth.rows - 4).contains({x, y})) return std::nullopt;
  double low = 0, high = 0;
  cv::minMaxLoc(depth(cv::Rect(x - 2, y - 2, 5, 5)), &low, &high);
  if (low <= 0 || high > kJump * low) return std::nullopt;
  return depth.at<uint16_t>(y, x) / kDepthScale;
}

}  // namespace

std::vector<WalkPair> ReadWalkPairs(const fs::path& dataset, int gap, int stride) {
  GAITCAM_ASSERT(gap > 0 && stride > 0);
  const fs::path sensors = FindDataset(dataset), truth = sensors.string() + "-truth", table = truth / "frames.csv";
  if (!fs::exists(table)) throw BadInput(truth.string() + ": the truth of the recording is not there");
  DatasetReader reader(sensors);
  const CameraModel camera = reader.calibration().camera;
  const Trajectory trajectory = ReadTrajectory(truth / "groundtruth.txt").trajectory;
  std::map<int64_t, double> blur;
  for (const FrameTruth& frame : ReadRecordedTruth({sensors, truth})) blur[frame.stamp_ns] = frame.blur_median_px;
  if (blur.empty()) throw BadInput(table.string() + ": should hold a row per frame");
  std::vector<WalkFrame> frames;
  while (const std::optional<Observation> seen = reader.Next()) {
    const std::optional<Pose> pose = PoseAt(trajectory, seen->stamp_ns);
    if (!pose || !blur.count(seen->stamp_ns)) continue;
    const std::string name = fmt::format("{}.{:09}.png", seen->stamp_ns / 1000000000, seen->stamp_ns % 1000000000);
    WalkFrame frame{seen->image.pixels, cv::imread((truth / "depth" / name).string(), cv::IMREAD_ANYDEPTH), *pose,
                    blur.at(seen->stamp_ns)};
    if (frame.depth.empty()) throw BadInput((truth / "depth" / name).string() + ": cannot be read");
    if (frame.grey.channels() == 3) cv::cvtColor(frame.grey, frame.grey, cv::COLOR_BGR2GRAY);
    frames.push_back(frame);
  }
  std::vector<WalkPair> pairs;
  for (size_t i = 0; i + size_t(gap) < frames.size(); i += size_t(stride)) {
    const WalkFrame &a = frames[i], &b = frames[i + size_t(gap)];
    const Pose X_BA = b.X_WC.Inverse() * a.X_WC;
    const TrueMap map = [camera, X_BA, depth = a.depth](const Vector2d& pixel) -> std::optional<Vector2d> {
      const std::optional<double> z = SteadyDepthAt(depth, pixel);
      if (!z) return std::nullopt;
      return camera.Project(X_BA * Eigen::Vector3d(*z * camera.Unproject(pixel)));
    };
    pairs.push_back({a.grey, b.grey, map, std::max(a.blur_px, b.blur_px)});
  }
  if (pairs.empty()) throw BadInput(sensors.string() + ": fewer than " + std::to_string(gap + 1) + " frames");
  return pairs;
}

std::vector<CameraSetting> CameraSettings() {
  return {{"clean", false, 0, 0}, {"noise", false, 2, 0}, {"realistic", true, 2, 90}};
}

cv::Mat LineKernel(const LineBlur& blur) {
  const int radius = int(std::ceil(blur.extent_px / 2)) + 1;
  const int samples = std::max(100, int(40 * blur.extent_px));
  cv::Mat kernel = cv::Mat::zeros(2 * radius + 1, 2 * radius + 1, CV_32FC1);
  for (int i = 0; i < samples; ++i) {
    const Vector2d p = Vector2d::Constant(radius) + ((i + 0.5) / samples - 0.5) * blur.Vector();
    const int x = int(std::floor(p.x())), y = int(std::floor(p.y()));
    const double a = p.x() - x, b = p.y() - y;
    for (const auto& [dx, dy, w] : {std::tuple{0, 0, (1 - a) * (1 - b)}, std::tuple{1, 0, a * (1 - b)},
                                    std::tuple{0, 1, (1 - a) * b}, std::tuple{1, 1, a * b}})
      if (w > 0) kernel.at<float>(y + dy, x + dx) += float(w / samples);
  }
  return kernel;
}

cv::Mat FilmBlurred(const cv::Mat& grey, const LineBlur& blur, const CameraSetting& setting, uint64_t seed) {
  GAITCAM_ASSERT(grey.type() == CV_8UC1 && std::min(grey.rows, grey.cols) > 2 * kCrop_px);
  cv::Mat image;
  grey.convertTo(image, CV_32F);
  if (blur.extent_px > 0) {
    if (setting.linear_light) ApplyCurve(image, ToLight);
    cv::filter2D(image, image, CV_32F, LineKernel(blur), {-1, -1}, 0, cv::BORDER_REFLECT_101);
    if (setting.linear_light) ApplyCurve(image, ToGrey);
  }
  image = image(cv::Rect(kCrop_px, kCrop_px, grey.cols - 2 * kCrop_px, grey.rows - 2 * kCrop_px)).clone();
  RandomStream random(seed, "noise");
  if (setting.noise_sigma > 0) ApplyCurve(image, [&](double v) { return v + random.Normal(0, setting.noise_sigma); });
  cv::Mat filmed;
  image.convertTo(filmed, CV_8U);
  if (setting.jpeg_quality > 0) {
    std::vector<uchar> bytes;
    cv::imencode(".jpg", filmed, bytes, {cv::IMWRITE_JPEG_QUALITY, setting.jpeg_quality});
    filmed = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  }
  return filmed;
}

void MatchCount::operator+=(const MatchCount& other) {
  matches += other.matches;
  correct += other.correct;
  fewest_points = std::min(fewest_points, other.fewest_points);
  errors_px.insert(errors_px.end(), other.errors_px.begin(), other.errors_px.end());
}

double MatchCount::MedianError() const {
  if (errors_px.empty()) return std::nan("");
  return UpperMedian(errors_px);
}

namespace {

/// Rows of floats that squared Euclidean distance compares; a bit string's Hamming distance is the squared distance of
/// its bits, so that one path serves both kinds.
Eigen::MatrixXf AsColumns(const cv::Mat& descriptors) {
  const bool bits = descriptors.type() == CV_8UC1;
  Eigen::MatrixXf columns(descriptors.cols * (bits ? 8 : 1), descriptors.rows);
  for (int i = 0; i < descriptors.rows; ++i)
    for (int k = 0; k < columns.rows(); ++k)
      columns(k, i) = bits ? float((descriptors.ptr<uchar>(i)[k / 8] >> (k % 8)) & 1) : descriptors.ptr<float>(i)[k];
  return columns;
}

struct Nearest {
  int b = -1;
  double ratio = 1;  ///< Of the nearest distance over the second nearest's.
};

std::vector<Nearest> FindNearest(const cv::Mat& a, const cv::Mat& b) {
  std::vector<Nearest> nearest(size_t(a.rows));
  if (a.empty() || b.rows < 2) return nearest;
  const bool bits = a.type() == CV_8UC1;
  const Eigen::MatrixXf A = AsColumns(a), B = AsColumns(b);
  const Eigen::VectorXf norms = B.colwise().squaredNorm();
  constexpr int kBlock = 256;
  for (int begin = 0; begin < a.rows; begin += kBlock) {
    const int n = std::min(kBlock, a.rows - begin);
    Eigen::MatrixXf D = -2 * (B.transpose() * A.middleCols(begin, n));
    for (int i = 0; i < n; ++i) {
      Eigen::VectorXf d = D.col(i) + norms;
      Nearest& best = nearest[size_t(begin + i)];
      const float own = A.col(begin + i).squaredNorm(), first = d.minCoeff(&best.b);
      d[best.b] = std::numeric_limits<float>::infinity();
      const double ratio = double(std::max(first + own, 0.f)) / double(std::max(d.minCoeff() + own, 1e-12f));
      best.ratio = bits ? ratio : std::sqrt(ratio);
    }
  }
  return nearest;
}

}  // namespace

std::vector<MatchCount> CountMatches(const Features& a, const Features& b, const TrueMap& map,
                                     const std::vector<double>& ratios) {
  std::vector<MatchCount> counts(ratios.size());
  const std::vector<Nearest> nearest = FindNearest(a.descriptors, b.descriptors);
  for (size_t r = 0; r < ratios.size(); ++r) {
    counts[r].fewest_points = std::min(a.size(), b.size());
    std::set<std::array<int, 4>> seen;  // one point with two orientations is one match
    for (size_t i = 0; i < nearest.size(); ++i) {
      if (nearest[i].b < 0 || nearest[i].ratio >= ratios[r]) continue;
      const cv::Point2f p = a.keypoints[i].pt, q = b.keypoints[size_t(nearest[i].b)].pt;
      if (!seen.insert({cvRound(p.x), cvRound(p.y), cvRound(q.x), cvRound(q.y)}).second) continue;
      const std::optional<Vector2d> truth = map({p.x, p.y});
      if (!truth) continue;
      const double error = (*truth - Vector2d(q.x, q.y)).norm();
      ++counts[r].matches;
      if (error > kCorrect_px) continue;
      ++counts[r].correct;
      counts[r].errors_px.push_back(error);
    }
  }
  return counts;
}

namespace {

/// OpenCV's SIFT without the points of its doubled octave (number -1, in the low byte).
Features WithoutDoubledOctave(const Features& all) {
  Features kept;
  kept.descriptors = cv::Mat(0, all.descriptors.cols, all.descriptors.type());
  for (int i = 0; i < all.size(); ++i) {
    if ((all.keypoints[size_t(i)].octave & 255) == 255) continue;
    kept.keypoints.push_back(all.keypoints[size_t(i)]);
    kept.descriptors.push_back(all.descriptors.row(i));
  }
  return kept;
}

Features SiftSingle(const cv::Mat& image, int max_features) {
  return WithoutDoubledOctave(DetectFeatures(*MakeFeature2d("sift"), image, max_features));
}

Features MobifDiscards(const cv::Mat& image, int max_features) {
  MobifOptions options;
  options.discard_low_entropy = true;
  return DetectFeatures(*MakeMobif(options), image, max_features);
}

Features MobifOfLight(const cv::Mat& image, int max_features) {
  MobifOptions options;
  options.psf = "spectral_light";
  return DetectFeatures(*MakeMobif(options), image, max_features);
}

Features MobifAdaptAll(const cv::Mat& image, int max_features) {
  MobifAdaptOptions options;
  options.discard_low_entropy = false;
  return DetectFeatures(*MakeMobifAdapt(options), image, max_features);
}

/// Detectors of this experiment alone.
const std::map<std::string, Features (*)(const cv::Mat& image, int max_features)>& OwnDetectors() {
  static const std::map<std::string, Features (*)(const cv::Mat&, int)> own{{"mobif_adapt_all", MobifAdaptAll},
                                                                            {"mobif_discards", MobifDiscards},
                                                                            {"mobif_of_light", MobifOfLight},
                                                                            {"sift_single", SiftSingle}};
  return own;
}

Features Extract(const std::string& detector, const cv::Mat& image, const FeatureExperimentOptions& options) {
  constexpr int kMost = 20000;
  constexpr double kSensitive = 200;
  if (options.strongest > 0) return DetectFeatures(*MakeFeature2d(detector, kSensitive), image, options.strongest);
  const auto own = OwnDetectors().find(detector);
  if (own != OwnDetectors().end()) return own->second(image, kMost);
  return DetectFeatures(*MakeFeature2d(detector), image, kMost);
}

/// The blur of one image of a pair: the same for every detector.
LineBlur DrawBlur(const ImagePair& pair, const std::string& which, double extent_px, uint64_t seed) {
  RandomStream random(seed, "blur " + which + " of " + pair.name + " " + std::to_string(int(extent_px)));
  return {extent_px, random.Uniform(0, M_PI)};
}

using CellKey = std::tuple<std::string, size_t, double, bool, size_t>;  // setting, detector, extent, both, ratio
using CellSums = std::map<CellKey, MatchCount>;

void operator+=(CellSums& sums, const CellSums& others) {
  for (const auto& [key, count] : others) sums[key] += count;
}

/// All detectors on one pair in one setting.
class PairExperiment {
 public:
  PairExperiment(const ImagePair& pair, const CameraSetting& setting, const FeatureExperimentOptions& options)
      : pair_(pair), setting_(setting), options_(options), map_(MapOfHomography(AfterCrop(pair.H_ba))) {}

  CellSums Run() {
    const cv::Mat sharp_a = FilmBlurred(pair_.a, {}, setting_, options_.seed);
    for (const std::string& name : options_.detectors) of_sharp_a_.push_back(Extract(name, sharp_a, options_));
    for (const double extent_px : options_.extents_px) RunExtent(extent_px);
    return sums_;
  }

 private:
  void RunExtent(double extent_px) {
    constexpr double kDifferent_rad = 0.35;  // directions closer than this are turned apart
    const LineBlur blur_b = DrawBlur(pair_, "b", extent_px, options_.seed);
    LineBlur blur_a = DrawBlur(pair_, "a", extent_px, options_.seed);
    if (blur_a.DirectionError(blur_b) < kDifferent_rad)
      blur_a = LineBlur::FromVector(Eigen::Rotation2Dd(2 * kDifferent_rad) * blur_a.Vector());
    const cv::Mat a = FilmBlurred(pair_.a, blur_a, setting_, options_.seed);
    const cv::Mat b = FilmBlurred(pair_.b, blur_b, setting_, options_.seed + 1);
    for (size_t d = 0; d < options_.detectors.size(); ++d) {
      const Features of_b = Extract(options_.detectors[d], b, options_);
      Add(d, extent_px, false, of_sharp_a_[d], of_b);
      if (extent_px > 0) Add(d, extent_px, true, Extract(options_.detectors[d], a, options_), of_b);
    }
  }

  void Add(size_t detector, double extent_px, bool both, const Features& a, const Features& b) {
    const std::vector<MatchCount> counts = CountMatches(a, b, map_, options_.ratios);
    for (size_t r = 0; r < counts.size(); ++r) sums_[{setting_.name, detector, extent_px, both, r}] += counts[r];
  }

  const ImagePair& pair_;
  const CameraSetting& setting_;
  const FeatureExperimentOptions& options_;
  const TrueMap map_;
  std::vector<Features> of_sharp_a_;
  CellSums sums_;
};

}  // namespace

std::vector<std::string> ExperimentDetectors(bool registered_alone) {
  std::vector<std::string> names;
  for (const FeatureInfo& info : ListFeatures()) names.push_back(info.name);
  if (registered_alone) return names;
  for (const auto& [name, extract] : OwnDetectors()) names.push_back(name);
  std::sort(names.begin(), names.end());
  return names;
}

void CheckDetectors(const FeatureExperimentOptions& options) {
  for (const std::string& name : options.detectors) {
    const bool own = OwnDetectors().contains(name);
    if (!own) MakeFeature2d(name);
    if (own && options.strongest > 0)
      throw BadInput(name + " cannot be asked for its strongest points at a lower threshold; leave it out");
  }
}

std::vector<FeatureCell> RunFeatureExperiment(const std::vector<ImagePair>& pairs,
                                              const FeatureExperimentOptions& options,
                                              const std::function<void(int done, int all)>& progress) {
  CheckDetectors(options);
  const std::vector<CameraSetting> settings = CameraSettings();
  const int jobs = int(pairs.size() * settings.size());
  std::vector<CellSums> parts(size_t(jobs), CellSums{});
  std::mutex mutex;
  int done = 0;
  InParallel(jobs, options.jobs, [&](int i) {
    const ImagePair& pair = pairs[size_t(i) / settings.size()];
    parts[size_t(i)] = PairExperiment(pair, settings[size_t(i) % settings.size()], options).Run();
    const std::lock_guard lock(mutex);
    progress(++done, jobs);
  });
  CellSums sums;
  for (const CellSums& part : parts) sums += part;
  std::vector<FeatureCell> cells;
  for (const auto& [key, count] : sums) {
    const auto& [setting, d, extent_px, both, r] = key;
    cells.push_back({options.detectors[d], setting, extent_px, options.ratios[r], both, count});
  }
  return cells;
}

std::vector<WalkCell> RunWalkExperiment(const std::vector<WalkPair>& pairs, const FeatureExperimentOptions& options,
                                        const std::function<void(int done, int all)>& progress) {
  const size_t detectors = options.detectors.size();
  std::vector<MatchCount> counts(pairs.size() * detectors);
  std::mutex mutex;
  int done = 0;
  InParallel(int(pairs.size()), options.jobs, [&](int i) {
    const WalkPair& pair = pairs[size_t(i)];
    for (size_t d = 0; d < detectors; ++d) {
      const std::string& name = options.detectors[d];
      counts[size_t(i) * detectors + d] = CountMatches(Extract(name, pair.a, options), Extract(name, pair.b, options),
                                                       pair.map, {options.ratios.front()})
                                              .front();
    }
    const std::lock_guard lock(mutex);
    progress(++done, int(pairs.size()));
  });
  const size_t sift = size_t(std::ranges::find(options.detectors, "sift") - options.detectors.begin());
  const std::vector<double> limits_px = {0, 3, 6, 10, 15, 1e9};
  std::vector<WalkCell> cells;
  for (size_t bin = 0; bin + 1 < limits_px.size(); ++bin) {
    for (size_t d = 0; d < detectors; ++d) {
      WalkCell cell{options.detectors[d], limits_px[bin], limits_px[bin + 1], 0, {}, {}};
      if (sift < detectors && d != sift) cell.more_than_sift = 0;
      for (size_t i = 0; i < pairs.size(); ++i) {
        if (pairs[i].blur_px < cell.from_px || pairs[i].blur_px >= cell.to_px) continue;
        const MatchCount& count = counts[i * detectors + d];
        cell.count += count;
        ++cell.pairs;
        if (cell.more_than_sift) *cell.more_than_sift += count.correct > counts[i * detectors + sift].correct;
      }
      if (cell.pairs > 0) cells.push_back(cell);
    }
  }
  return cells;
}

}  // namespace gaitcam
