#include "algorithms/places/panorama.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

constexpr double kMaxPitchSine = 0.9;  // of a camera that can make a panorama
constexpr double kMaxTan = 3;          // of a row's elevation
constexpr double kMinContrast = 3;     // grey levels, standard deviation; flatter overlaps do not tell a seam's error
constexpr double kMinCorrelation = 0.6;
constexpr double kTemplateRad = 6 * kPi / 180;  // half the width of the template
constexpr uchar kSaturated = 250;

double Rad(double deg) { return deg * kPi / 180; }

/// In [-pi, pi).
double Wrapped(double angle) { return angle - 2 * kPi * std::floor(angle / (2 * kPi) + 0.5); }

bool Sees(const CameraModel& camera, const Eigen::Vector3d& ray) {
  const auto pixel = camera.Project(ray);
  // Within the centres of the border pixels, so that no sample needs a pixel outside.
  return pixel && pixel->x() >= 0 && pixel->y() >= 0 && pixel->x() <= camera.width_px - 1 &&
         pixel->y() <= camera.height_px - 1;
}

/// Tangents of elevation seen at an azimuth: the interval about that of the optical axis.
struct Span {
  double low = 0, high = 0;
};

Span SeenSpan(const CameraModel& camera, const LevelAxes& axes, double azimuth) {
  const double middle = axes.up.z() / std::sqrt(1 - axes.up.z() * axes.up.z()), step = 0.002;
  Span span{middle, middle};
  if (!Sees(camera, axes.Ray(azimuth, middle))) return span;
  while (span.low > -kMaxTan && Sees(camera, axes.Ray(azimuth, span.low - step))) span.low -= step;
  while (span.high < kMaxTan && Sees(camera, axes.Ray(azimuth, span.high + step))) span.high += step;
  return span;
}

cv::Mat Grey(const cv::Mat& image) {
  if (image.type() == CV_8UC1) return image;
  if (image.type() != CV_8UC3) throw BadInput("panorama: images must be 8 bit grey or BGR");
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

/// The camera whose pixels are means of fx x fy pixels of another one. (The first one's centre lies at (f - 1) / 2.)
CameraModel Shrunk(CameraModel camera, int factor_x, int factor_y) {
  camera.width_px /= factor_x;
  camera.height_px /= factor_y;
  camera.fx /= factor_x;
  camera.fy /= factor_y;
  camera.cx = (camera.cx - 0.5 * (factor_x - 1)) / factor_x;
  camera.cy = (camera.cy - 0.5 * (factor_y - 1)) / factor_y;
  return camera;
}

/// Vertex of the parabola through three neighbouring values, relative to the middle one.
double PeakOffset(double before, double peak, double after) {
  const double curvature = before - 2 * peak + after;
  return curvature < 0 ? std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5) : 0.0;
}

}  // namespace

double PanoramaLayout::px_per_rad() const { return width_px / (2 * kPi); }
double PanoramaLayout::AzimuthOf(double column) const { return (0.5 * (width_px - 1) - column) / px_per_rad(); }
double PanoramaLayout::ColumnOf(double azimuth_rad) const { return 0.5 * (width_px - 1) - azimuth_rad * px_per_rad(); }
double PanoramaLayout::TanElevationOf(double row) const {
  return tan_high - (row + 0.5) / height_px * (tan_high - tan_low);
}

void PanoramaLayout::Check() const {
  const auto whole = [](const char* name, int value) {
    if (value < 1 || value > 100000) {
      throw BadOption(std::string("panorama.") + name + " = " + std::to_string(value) + ": must be in [1, 100000]");
    }
  };
  whole("width_px", width_px);
  whole("height_px", height_px);
  if (!(tan_low < tan_high && tan_low >= -kMaxTan && tan_high <= kMaxTan)) {
    throw BadOption("panorama: rows from tangent " + std::to_string(tan_low) + " to " + std::to_string(tan_high) +
                    " of the elevation: must rise within [-3, 3]");
  }
}

PanoramaLayout LayoutFor(const CameraModel& camera, const Eigen::Vector3d& up_C, int width_px, int height_px) {
  camera.Check();
  const LevelAxes axes(up_C);
  PanoramaLayout layout{width_px, height_px, -0.1, 0.1};
  layout.Check();
  // The wider the section, the fewer rows all of its columns see: the largest area is taken.
  double best_area = 0;
  Span all{-kMaxTan, kMaxTan};
  const double step = 0.005;
  for (double azimuth = 0; azimuth < 0.45 * kPi; azimuth += step) {
    for (const double side : {azimuth, -azimuth}) {
      const Span span = SeenSpan(camera, axes, side);
      all = {std::max(all.low, span.low), std::min(all.high, span.high)};
    }
    const double area = azimuth * (all.high - all.low);
    if (!(all.high > all.low)) break;
    if (area > best_area) {
      best_area = area;
      layout.tan_low = all.low;
      layout.tan_high = all.high;
    }
  }
  if (best_area == 0) throw BadInput("panorama: the camera sees nothing along its own optical axis");
  return layout;
}

// ---------------------------------------------------------------------------------------------------------------------

LevelAxes::LevelAxes(const Eigen::Vector3d& up_C) : up(up_C.normalized()) {
  const double sine = up.z();
  if (!(std::abs(sine) < kMaxPitchSine)) {
    throw BadInput("panorama: the camera looks up or down by " + std::to_string(std::asin(sine) * 180 / kPi) +
                   " deg, which is too steep for a panorama");
  }
  forward = (Eigen::Vector3d::UnitZ() - sine * up).normalized();
  left = up.cross(forward);
}

Eigen::Vector3d LevelAxes::Ray(double azimuth_rad, double tan_elevation) const {
  return std::cos(azimuth_rad) * forward + std::sin(azimuth_rad) * left + tan_elevation * up;
}

CylinderProjection::CylinderProjection(const CameraModel& camera, const Eigen::Vector3d& up_C,
                                       const PanoramaLayout& layout)
    : layout_(layout), camera_(camera), axes_(up_C) {
  camera.Check();
  layout.Check();
  // Pixels much finer than the panorama's are averaged first.
  const double rows_per_tan = layout.height_px / (layout.tan_high - layout.tan_low);
  prepared_ =
      Shrunk(camera, std::max(1, int(camera.fx / layout.px_per_rad())), std::max(1, int(camera.fy / rows_per_tan)));
  const double step = 0.1 / layout.px_per_rad();
  while (half_width_rad_ < 0.5 * kPi && IsSeen(half_width_rad_ + step) && IsSeen(-half_width_rad_ - step))
    half_width_rad_ += step;
  const int columns = int(2 * half_width_rad_ * layout.px_per_rad());
  if (columns < 1) {
    throw BadInput("panorama: a view of this camera does not reach from elevation " +
                   std::to_string(std::atan(layout.tan_low) * 180 / kPi) + " to " +
                   std::to_string(std::atan(layout.tan_high) * 180 / kPi) + " deg, which the panorama's rows show");
  }
  view_ = MapOf(axes_, 0.5 * (columns - 1) / layout.px_per_rad(), columns);
}

bool CylinderProjection::IsSeen(double azimuth_rad) const {
  for (int row = 0; row < layout_.height_px; ++row) {
    if (!Sees(prepared_, axes_.Ray(azimuth_rad, layout_.TanElevationOf(row)))) return false;
  }
  return true;
}

CylinderProjection::Map CylinderProjection::MapOf(const LevelAxes& axes, double azimuth_rad, int columns) const {
  Map map{cv::Mat(layout_.height_px, columns, CV_32FC1), cv::Mat(layout_.height_px, columns, CV_32FC1)};
  for (int column = 0; column < columns; ++column) {
    const double azimuth = azimuth_rad - column / layout_.px_per_rad();
    const Eigen::Vector3d level = axes.Ray(azimuth, 0);
    for (int row = 0; row < layout_.height_px; ++row) {
      const auto pixel = prepared_.Project(level + layout_.TanElevationOf(row) * axes.up);
      map.x.at<float>(row, column) = pixel ? float(pixel->x()) : -1e4f;
      map.y.at<float>(row, column) = pixel ? float(pixel->y()) : -1e4f;
    }
  }
  return map;
}

cv::Mat CylinderProjection::Prepare(const cv::Mat& image) const {
  if (image.cols != camera_.width_px || image.rows != camera_.height_px) {
    throw BadInput("panorama: an image of " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
                   " px, but the camera's are " + std::to_string(camera_.width_px) + " x " +
                   std::to_string(camera_.height_px) + " px");
  }
  const cv::Mat grey = Grey(image);
  if (prepared_.width_px == camera_.width_px && prepared_.height_px == camera_.height_px) return grey;
  const int factor_x = camera_.width_px / prepared_.width_px, factor_y = camera_.height_px / prepared_.height_px;
  cv::Mat shrunk;
  cv::resize(grey(cv::Rect(0, 0, prepared_.width_px * factor_x, prepared_.height_px * factor_y)), shrunk,
             {prepared_.width_px, prepared_.height_px}, 0, 0, cv::INTER_AREA);
  return shrunk;
}

cv::Mat CylinderProjection::Strip(const cv::Mat& prepared, double azimuth_rad, int columns) const {
  const Map map = MapOf(axes_, azimuth_rad, columns);
  cv::Mat strip;
  cv::remap(prepared, strip, map.x, map.y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return strip;
}

cv::Mat CylinderProjection::ProjectView(const cv::Mat& image) const {
  cv::Mat view;
  cv::remap(Prepare(image), view, view_.x, view_.y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return view;
}

cv::Mat CylinderProjection::ProjectView(const cv::Mat& image, const Eigen::Vector3d& up_C) const {
  const Map map = MapOf(LevelAxes(up_C), 0.5 * (width_px() - 1) / layout_.px_per_rad(), width_px());
  cv::Mat view;
  cv::remap(Prepare(image), view, map.x, map.y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return view;
}

// ---------------------------------------------------------------------------------------------------------------------

PanoramaBuilder::PanoramaBuilder(const CylinderProjection& projection, const PanoramaLayout& layout,
                                 const PanoramaOptions& options)
    : projection_(projection), layout_(layout), options_(options) {
  CheckFields(options, "panorama.");
}

void PanoramaBuilder::Add(const cv::Mat& image, double yaw_rad) {
  const double yaw = Wrapped(yaw_rad);
  const auto after = std::find_if(frames_.begin(), frames_.end(), [&](const Frame& f) { return f.yaw_rad < yaw; });
  if (!frames_.empty()) {
    const Frame& right = after == frames_.end() ? frames_.front() : *after;
    const Frame& left = after == frames_.begin() ? frames_.back() : *(after - 1);
    const double to_left = std::abs(Wrapped(left.yaw_rad - yaw)), to_right = std::abs(Wrapped(yaw - right.yaw_rad));
    const bool between = frames_.size() > 1 && to_left + to_right <= 2 * Rad(options_.blend_deg);
    if (between || std::min(to_left, to_right) < Rad(options_.min_step_deg)) return;
  }
  cv::Mat prepared = projection_.Prepare(image);
  if (prepared.data == image.data) prepared = prepared.clone();
  frames_.insert(after, {yaw, prepared});
}

double PanoramaBuilder::Gap(size_t i) const {
  if (frames_.size() == 1) return 2 * kPi;
  const double gap = frames_[i].yaw_rad - frames_[Next(i)].yaw_rad;
  return gap > 0 ? gap : gap + 2 * kPi;
}

double PanoramaBuilder::missing_deg() const {
  if (frames_.empty()) return 360;
  double missing = 0;
  for (size_t i = 0; i < frames_.size(); ++i) missing += std::max(0.0, Gap(i) - 2 * projection_.half_width_rad());
  return missing * 180 / kPi;
}

PanoramaBuilder::Seam PanoramaBuilder::Judge(size_t i) const {
  // Both see +-(half width - gap / 2) about the middle between them. A template of the left frame is searched for in
  // the right one.
  const double px = layout_.px_per_rad(), both = projection_.half_width_rad() - 0.5 * Gap(i);
  const int search = int(std::min(Rad(options_.search_deg), 0.5 * both) * px);
  const int half = int(std::min(kTemplateRad, both - search / px) * px);
  Seam seam;
  if (search < 1 || half < 4) return seam;
  const double to_left = 0.5 * Gap(i), to_right = -0.5 * Gap(i);  // the middle, as the right and the left frame see it
  const cv::Mat left_patch = projection_.Strip(frames_[i].image, to_right + (half - 0.5) / px, 2 * half);
  const cv::Mat other =
      projection_.Strip(frames_[Next(i)].image, to_left + (half + search - 0.5) / px, 2 * (half + search));
  const cv::Mat same = other.colRange(search, search + 2 * half);
  cv::Scalar mean, deviation;
  const cv::Mat usable = (left_patch < kSaturated) & (same < kSaturated);
  const double left_mean = cv::mean(left_patch, usable)[0], right_mean = cv::mean(same, usable)[0];
  if (left_mean < 1 || right_mean < 1) return seam;
  seam.log_ratio = std::log(left_mean / right_mean);
  cv::meanStdDev(left_patch, mean, deviation);
  if (deviation[0] < kMinContrast) return seam;
  cv::Mat scores;
  cv::matchTemplate(other, left_patch, scores, cv::TM_CCOEFF_NORMED);
  double peak = 0;
  cv::Point at;
  cv::minMaxLoc(scores, nullptr, &peak, nullptr, &at);
  if (peak < kMinCorrelation || at.x == 0 || at.x == scores.cols - 1) return seam;
  seam.known = true;
  seam.error_px = at.x - search + PeakOffset(scores.at<float>(0, at.x - 1), peak, scores.at<float>(0, at.x + 1));
  return seam;
}

std::vector<double> PanoramaBuilder::Gains(const std::vector<Seam>& seams) const {
  // log gain_i + log brightness_i = log gain_{i+1} + log brightness_{i+1} at each seam, by least squares, as the ratios
  // around the circle need not multiply to 1; regularised towards gains of 1.
  const auto n = Eigen::Index(frames_.size());
  const double regularisation = 1e-3;
  Eigen::MatrixXd A = regularisation * Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index next = (i + 1) % n;
    const double ratio = seams[size_t(i)].log_ratio;
    A(i, i) += 1;
    A(next, next) += 1;
    A(i, next) -= 1;
    A(next, i) -= 1;
    b(i) -= ratio;
    b(next) += ratio;
  }
  const Eigen::VectorXd logs = A.ldlt().solve(b);
  std::vector<double> gains;
  for (Eigen::Index i = 0; i < n; ++i) gains.push_back(std::exp(logs(i) - logs.mean()));
  return gains;
}

void PanoramaBuilder::Draw(size_t i, double gain, cv::Mat& sum, cv::Mat& weights) const {
  // Its strip extends beyond the middle between it and each neighbour by half of the blended width.
  const size_t n = frames_.size(), before = (i + n - 1) % n;
  const auto blend = [&](double gap) {
    return std::min({gap, Rad(options_.blend_deg), 2 * projection_.half_width_rad() - gap});
  };
  const double left_gap = Gap(before), right_gap = Gap(i), left_blend = blend(left_gap), right_blend = blend(right_gap);
  const double left = 0.5 * (left_gap + left_blend), right = 0.5 * (right_gap + right_blend);  // from its axis
  const double axis = layout_.ColumnOf(frames_[i].yaw_rad), px = layout_.px_per_rad();
  const int first = int(std::ceil(axis - left * px)), last = int(std::floor(axis + right * px));
  if (last < first) return;
  const cv::Mat strip = projection_.Strip(frames_[i].image, (axis - first) / px, last - first + 1);
  for (int column = first; column <= last; ++column) {
    const double azimuth = (axis - column) / px;  // left of the axis is positive
    const double ramp =
        azimuth > 0 ? (left - azimuth) / std::max(left_blend, 1e-9) : (right + azimuth) / std::max(right_blend, 1e-9);
    const double weight = std::clamp(ramp, 0.0, 1.0) + 1e-9;
    const int to = ((column % layout_.width_px) + layout_.width_px) % layout_.width_px;
    for (int row = 0; row < layout_.height_px; ++row) {
      sum.at<float>(row, to) += float(weight * gain * strip.at<uchar>(row, column - first));
    }
    weights.at<float>(0, to) += float(weight);
  }
}

Panorama PanoramaBuilder::Finish() const {
  const double missing = missing_deg();
  if (missing > 0) {
    throw TooLittleData("panorama: " + std::to_string(frames_.size()) + " frames of the scan leave " +
                        std::to_string(missing) + " of 360 deg unseen");
  }
  std::vector<Seam> seams;
  Panorama panorama;
  panorama.frames = int(frames_.size());
  for (size_t i = 0; i < frames_.size(); ++i) {
    seams.push_back(Judge(i));
    if (!seams.back().known) continue;
    const double error = std::abs(seams.back().error_px);
    panorama.seams_px.push_back(seams.back().error_px);
    panorama.mean_seam_error_px += error;
    panorama.max_seam_error_px = std::max(panorama.max_seam_error_px, error);
  }
  if (!panorama.seams_px.empty()) panorama.mean_seam_error_px /= double(panorama.seams_px.size());
  const std::vector<double> gains = Gains(seams);
  panorama.gain_spread = *std::max_element(gains.begin(), gains.end()) / *std::min_element(gains.begin(), gains.end());
  cv::Mat sum = cv::Mat::zeros(layout_.height_px, layout_.width_px, CV_32FC1);
  cv::Mat weights = cv::Mat::zeros(1, layout_.width_px, CV_32FC1);
  for (size_t i = 0; i < frames_.size(); ++i) Draw(i, gains[i], sum, weights);
  cv::divide(sum, cv::repeat(weights, layout_.height_px, 1), sum);
  sum.convertTo(panorama.image, CV_8UC1);
  return panorama;
}

}  // namespace gaitcam
