#include "results/scoring/floor_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

Vector2d Turned(double yaw, const Vector2d& p) {
  const double c = std::cos(yaw), s = std::sin(yaw);
  return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
}

struct SeenCell {
  Vector2d p_V;
  float grey;
};

/// Seen cells of a map that was smoothed over its seen cells alone, no more than `max_cells`, evenly spread.
std::vector<SeenCell> SeenCells(const FloorPicture& map, double sigma_m, int max_cells) {
  cv::Mat seen, grey, weight;
  cv::Mat(map.sightings > 0).convertTo(seen, CV_32F, 1.0 / 255);
  map.intensity.convertTo(grey, CV_32F);
  grey = grey.mul(seen);
  weight = seen;
  if (const double sigma = sigma_m / map.cell_m; sigma > 0) {
    cv::GaussianBlur(grey, grey, {}, sigma);
    cv::GaussianBlur(seen, weight, {}, sigma);
  }
  std::vector<SeenCell> cells;
  const int64_t stride = std::max<int64_t>(1, cv::countNonZero(seen) / max_cells);
  int64_t index = 0;
  for (int v = 0; v < grey.rows; ++v) {
    for (int u = 0; u < grey.cols; ++u) {
      if (seen.at<float>(v, u) == 0 || index++ % stride != 0) continue;
      cells.push_back({CellMiddle(map, u, v), grey.at<float>(v, u) / weight.at<float>(v, u)});
    }
  }
  return cells;
}

/// What is searched: a shift along x and y, and a turn about a pivot.
struct Offset {
  double x = 0, y = 0, yaw = 0;
};

class Search {
 public:
  Search(const FloorPicture& map, const TrueFloor& truth, const FloorMotion& X_WV, const FloorAlignmentOptions& options)
      : map_(map), truth_(truth), X_WV_(X_WV), options_(options) {
    const std::vector<SeenCell> cells = SeenCells(map, 0, options.max_cells);
    for (const SeenCell& cell : cells) pivot_ += X_WV * cell.p_V / double(cells.size());
    double squares = 0;
    for (const SeenCell& cell : cells) squares += (X_WV * cell.p_V - pivot_).squaredNorm();
    reach_ = std::max(map.cell_m, std::sqrt(squares / double(cells.size())));
  }

  FloorMotion Best() {
    Smooth(options_.smoothing_m);
    Offset far = WholeRange(), near;
    double sigma = options_.smoothing_m;
    for (double step = options_.first_step_m / 2; step > options_.last_step_m / 2; step /= 2) {
      if (sigma > 0) Smooth(sigma = sigma > map_.cell_m ? sigma / 2 : 0);
      far = Climb(far, step);
      near = Climb(near, step);
    }
    const Offset best = Value(far) > Value(near) ? far : near;
    return Value(best) > Value({}) ? Moved(best) : X_WV_;
  }

 private:
  void Smooth(double sigma_m) {
    cells_ = SeenCells(map_, sigma_m, options_.max_cells);
    // The truth is averaged over cells too: a square's variance is that of a Gaussian of a cell over sqrt(12).
    smooth_truth_ = truth_.Smoothed(std::hypot(sigma_m, map_.cell_m / std::sqrt(12.0)));
  }

  FloorMotion Moved(const Offset& o) const {
    const FloorMotion about_pivot(o.yaw, pivot_ - Turned(o.yaw, pivot_) + Vector2d(o.x, o.y));
    return about_pivot * X_WV_;
  }

  bool Permitted(const Offset& o) const {
    return std::abs(o.x) <= options_.max_shift_m && std::abs(o.y) <= options_.max_shift_m &&
           std::abs(o.yaw) <= options_.max_turn_deg * std::numbers::pi / 180;
  }

  /// Correlation under an offset; -1 where there is none.
  double Value(const Offset& offset) const {
    const FloorMotion X = Moved(offset);
    Correlation correlation;
    for (const SeenCell& cell : cells_) {
      const float true_grey = smooth_truth_.Point(X * cell.p_V);
      if (!std::isnan(true_grey)) correlation.Add(cell.grey, true_grey);
    }
    // What slides off the floor must not look better for it.
    if (2 * correlation.count() < int64_t(cells_.size())) return -1;
    const double value = correlation.Value();
    return std::isnan(value) ? -1 : value;
  }

  /// All offsets of the permitted range at the first step; a turn's step moves the map's rim as far as a shift's.
  Offset WholeRange() const {
    const double step = options_.first_step_m, turn = step / reach_;
    const int shifts = int(options_.max_shift_m / step);
    const int turns = int(options_.max_turn_deg * std::numbers::pi / 180 / turn);
    Offset best;
    double best_value = Value(best);
    for (int k = -turns; k <= turns; ++k) {
      for (int j = -shifts; j <= shifts; ++j) {
        for (int i = -shifts; i <= shifts; ++i) {
          const Offset offset{i * step, j * step, k * turn};
          const double value = Value(offset);
          if (value > best_value) best = offset, best_value = value;
        }
      }
    }
    return best;
  }

  /// To the best neighbour, until none is better.
  Offset Climb(Offset at, double step) const {
    constexpr int kMaxSteps = 40;  // more than the whole range at the first step
    const std::array<Offset, 6> ways{
        {{step, 0, 0}, {-step, 0, 0}, {0, step, 0}, {0, -step, 0}, {0, 0, step / reach_}, {0, 0, -step / reach_}}};
    double value = Value(at);
    for (int n = 0; n < kMaxSteps; ++n) {
      Offset best = at;
      for (const Offset& way : ways) {
        const Offset next{at.x + way.x, at.y + way.y, at.yaw + way.yaw};
        if (!Permitted(next)) continue;
        const double next_value = Value(next);
        if (next_value > value) best = next, value = next_value;
      }
      if (best.x == at.x && best.y == at.y && best.yaw == at.yaw) break;
      at = best;
    }
    return at;
  }

  const FloorPicture& map_;
  const TrueFloor& truth_;
  FloorMotion X_WV_;
  FloorAlignmentOptions options_;
  Vector2d pivot_ = Vector2d::Zero();
  double reach_ = 0;  ///< Root mean square distance of the cells from the pivot, m.
  std::vector<SeenCell> cells_;
  TrueFloor smooth_truth_ = truth_;
};

}  // namespace

FloorMotion::FloorMotion(const Similarity& X) : translation(X.translation.head<2>()) {
  const Eigen::Vector3d forward = X.rotation * Eigen::Vector3d::UnitX(), left = X.rotation * Eigen::Vector3d::UnitY();
  yaw = std::atan2(forward.y() - left.x(), forward.x() + left.y());  // the planar rotation that is nearest
}

Vector2d FloorMotion::operator*(const Vector2d& p) const { return Turned(yaw, p) + translation; }

FloorMotion FloorMotion::Inverse() const { return {-yaw, -Turned(-yaw, translation)}; }

FloorMotion operator*(const FloorMotion& X_AB, const FloorMotion& X_BC) {
  return {X_AB.yaw + X_BC.yaw, X_AB * X_BC.translation};
}

Vector2d FloorTruth::Min() const { return corner_m + Vector2d(-0.5, 0.5 - double(grey.rows)) / px_per_m; }

Vector2d FloorTruth::Max() const { return corner_m + Vector2d(double(grey.cols) - 0.5, 0.5) / px_per_m; }

TrueFloor::TrueFloor(const FloorTruth& truth, double cell_m)
    : px_per_m_(truth.px_per_m), cell_m_(cell_m), corner_m_(truth.corner_m) {
  if (truth.grey.empty() || truth.grey.type() != CV_8UC1) throw BadOption("truth: expected a grey picture of 8 bits");
  if (!(px_per_m_ > 0)) throw BadOption("px_per_m: expected a number above 0");
  if (!(cell_m > 0)) throw BadOption("cell_m: expected a number above 0");
  truth.grey.convertTo(grey_, CV_32F);
}

float TrueFloor::Point(const Vector2d& p_W) const {
  const double u = (p_W.x() - corner_m_.x()) * px_per_m_, v = (corner_m_.y() - p_W.y()) * px_per_m_;
  if (!(u >= -0.5 && v >= -0.5 && u <= grey_.cols - 0.5 && v <= grey_.rows - 0.5)) return kBeyond;
  const double x = std::clamp(u, 0.0, double(grey_.cols - 1)), y = std::clamp(v, 0.0, double(grey_.rows - 1));
  const int x0 = std::min(int(x), std::max(0, grey_.cols - 2)), y0 = std::min(int(y), std::max(0, grey_.rows - 2));
  const int x1 = std::min(x0 + 1, grey_.cols - 1), y1 = std::min(y0 + 1, grey_.rows - 1);
  const float fx = float(x - x0), fy = float(y - y0);
  const float *above = grey_.ptr<float>(y0), *below = grey_.ptr<float>(y1);
  return (1 - fy) * ((1 - fx) * above[x0] + fx * above[x1]) + fy * ((1 - fx) * below[x0] + fx * below[x1]);
}

float TrueFloor::Mean(const Vector2d& p_W, double yaw) const {
  if (std::isnan(Point(p_W))) return kBeyond;
  const int samples = std::max(1, int(std::lround(cell_m_ * px_per_m_)));  // along a side
  const Vector2d right = Turned(yaw, {cell_m_ / samples, 0}), up = Turned(yaw, {0, cell_m_ / samples});
  double sum = 0;
  int count = 0;
  for (int j = 0; j < samples; ++j) {
    for (int i = 0; i < samples; ++i) {
      const float value = Point(p_W + (i - 0.5 * (samples - 1)) * right + (j - 0.5 * (samples - 1)) * up);
      if (!std::isnan(value)) sum += value, ++count;
    }
  }
  return count > 0 ? float(sum / count) : kBeyond;
}

TrueFloor TrueFloor::Smoothed(double sigma_m) const {
  TrueFloor smooth = *this;
  smooth.grey_ = cv::Mat();
  cv::GaussianBlur(grey_, smooth.grey_, {}, sigma_m * px_per_m_, 0, cv::BORDER_REPLICATE);
  return smooth;
}

void Correlation::Add(double a, double b) {
  ++n_;
  a_ += a;
  b_ += b;
  aa_ += a * a;
  bb_ += b * b;
  ab_ += a * b;
}

double Correlation::Value() const {
  const double n = double(n_), aa = aa_ - a_ * a_ / n, bb = bb_ - b_ * b_ / n;
  // What is left of sums of squares below their rounding is no variation.
  if (n_ < 2 || aa <= 1e-12 * aa_ || bb <= 1e-12 * bb_) return std::numeric_limits<double>::quiet_NaN();
  return std::clamp((ab_ - a_ * b_ / n) / std::sqrt(aa * bb), -1.0, 1.0);
}

double Correlation::Gain() const {
  if (std::isnan(Value())) return std::numeric_limits<double>::quiet_NaN();
  return (ab_ - a_ * b_ / double(n_)) / (aa_ - a_ * a_ / double(n_));
}

double Correlation::Offset() const { return (b_ - Gain() * a_) / double(n_); }

FloorMotion AlignFloor(const FloorPicture& map, const TrueFloor& truth, const FloorMotion& X_WV,
                       const FloorAlignmentOptions& options) {
  CheckFields(options, "map.");
  if (map.empty() || cv::countNonZero(map.sightings) == 0) return X_WV;
  return Search(map, truth, X_WV, options).Best();
}

Vector2d CellMiddle(const FloorPicture& map, double column, double row) {
  return map.corner_m + map.cell_m * Vector2d(column, -row);
}

}  // namespace gaitcam
