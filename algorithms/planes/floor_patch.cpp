#include "algorithms/planes/floor_patch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// The floor's rectangle that an image shows, in the frame below the camera.
struct Rectangle {
  double x0 = 1e9, x1 = -1e9, y0 = 1e9, y1 = -1e9;

  void Add(const Eigen::Vector2d& p) {
    x0 = std::min(x0, p.x()), x1 = std::max(x1, p.x());
    y0 = std::min(y0, p.y()), y1 = std::max(y1, p.y());
  }
};

Rectangle VisibleFloor(const CameraModel& camera, const Pose& X_PC, double radius_m) {
  constexpr int kSteps = 16;
  Rectangle rectangle;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      if (i % kSteps != 0 && j % kSteps != 0) continue;
      const double u = i * (camera.width_px - 1.0) / kSteps, v = j * (camera.height_px - 1.0) / kSteps;
      const Eigen::Vector3d ray = X_PC.rotation * camera.Unproject({u, v});
      const Eigen::Vector2d flat = ray.head<2>();
      const double reach = ray.z() < 0 ? -X_PC.translation.z() / ray.z() * flat.norm() : radius_m;
      rectangle.Add(std::min(reach, radius_m) * flat.normalized());
    }
  }
  return rectangle;
}

/// The cells of largest gradient, the best one of each block first.
std::vector<FloorPatch::Point> ChooseMatchPoints(const FloorPatch::Level& patch, int block, size_t max_points) {
  constexpr float kMinGradient_grey = 3;  // per cell
  struct Candidate {
    float strength;
    FloorPatch::Point point;
  };
  std::vector<Candidate> candidates;
  for (int top = 1; top + 1 < patch.intensity.rows; top += block) {
    for (int left = 1; left + 1 < patch.intensity.cols; left += block) {
      Candidate best{kMinGradient_grey * kMinGradient_grey, {}};
      for (int j = top; j < std::min(top + block, patch.intensity.rows - 1); ++j) {
        for (int i = left; i < std::min(left + block, patch.intensity.cols - 1); ++i) {
          const uchar* at = patch.intensity.ptr<uchar>(j) + i;
          const long step = long(patch.intensity.step);
          if (at[0] == 0 || at[-1] == 0 || at[1] == 0 || at[-step] == 0 || at[step] == 0) continue;
          const float dx = 0.5F * float(at[1] - at[-1]), dy = 0.5F * float(at[step] - at[-step]);
          const float strength = dx * dx + dy * dy;
          const Eigen::Vector2d p(patch.x0 + i * patch.cell_m, patch.y0 + j * patch.cell_m);
          if (strength > best.strength) best = {strength, {p, float(at[0])}};
        }
      }
      if (best.point.intensity > 0) candidates.push_back(best);
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.strength > b.strength; });
  std::vector<FloorPatch::Point> points;
  for (size_t i = 0; i < std::min(max_points, candidates.size()); ++i) points.push_back(candidates[i].point);
  return points;
}

}  // namespace

std::optional<FloorPatch::Sample> FloorPatch::Level::At(const Eigen::Vector2d& p) const {
  const double x = (p.x() - x0) / cell_m, y = (p.y() - y0) / cell_m;
  if (!(x >= 0 && y >= 0 && x < intensity.cols - 1 && y < intensity.rows - 1)) return std::nullopt;
  const int i = int(x), j = int(y);
  const uchar* low = intensity.ptr<uchar>(j) + i;
  const uchar* high = intensity.ptr<uchar>(j + 1) + i;
  if (low[0] == 0 || low[1] == 0 || high[0] == 0 || high[1] == 0) return std::nullopt;
  const float a = float(x - i), b = float(y - j), per_m = float(1 / cell_m);
  const float below = float(low[0]) + a * float(low[1] - low[0]), above = float(high[0]) + a * float(high[1] - high[0]);
  return Sample{
      below + b * (above - below),
      per_m * Eigen::Vector2f((1 - b) * float(low[1] - low[0]) + b * float(high[1] - high[0]), above - below)};
}

double FloorPatch::width_m() const {
  if (empty()) return 0;
  return levels[0].cell_m * std::max(levels[0].intensity.cols, levels[0].intensity.rows);
}

double FloorPatch::bytes() const {
  double bytes = sizeof(FloorPatch);
  for (const Level& level : levels) {
    bytes += double(sizeof(Level) + level.intensity.total() + level.match.capacity() * sizeof(Point));
  }
  return bytes;
}

namespace {

/// Means of 2 x 2 cells, where all are visible.
FloorPatch::Level Halved(const FloorPatch::Level& fine) {
  FloorPatch::Level coarse;
  coarse.cell_m = 2 * fine.cell_m;
  coarse.x0 = fine.x0 + 0.5 * fine.cell_m, coarse.y0 = fine.y0 + 0.5 * fine.cell_m;
  coarse.intensity = cv::Mat(fine.intensity.rows / 2, fine.intensity.cols / 2, CV_8UC1, cv::Scalar(0));
  for (int j = 0; j < coarse.intensity.rows; ++j) {
    const uchar* low = fine.intensity.ptr<uchar>(2 * j);
    const uchar* high = fine.intensity.ptr<uchar>(2 * j + 1);
    for (int i = 0; i < coarse.intensity.cols; ++i) {
      const int a = low[2 * i], b = low[2 * i + 1], c = high[2 * i], d = high[2 * i + 1];
      if (a > 0 && b > 0 && c > 0 && d > 0) coarse.intensity.at<uchar>(j, i) = uchar((a + b + c + d + 2) / 4);
    }
  }
  return coarse;
}

/// What an image shows at a point of the floor, its pixels averaged to cells; 0 if it does not show it.
uchar Rectified(const ImagePyramid& image, const cv::Mat& mask, const CameraModel& camera, const Eigen::Vector3d& p_C,
                double cell_m) {
  const double u = camera.fx * p_C.x() / p_C.z() + camera.cx, v = camera.fy * p_C.y() / p_C.z() + camera.cy;
  if (!image.levels[0].Contains({u, v}) || mask.at<uchar>(int(v + 0.5), int(u + 0.5)) == 0) return 0;
  const double cell_px = camera.fx * cell_m / p_C.z();
  const size_t level = std::min(size_t(std::max(0.0, std::log2(cell_px))), image.levels.size() - 1);
  const Eigen::Vector2d pixel = Eigen::Vector2d(u, v) / double(1 << level);
  if (!image.levels[level].Contains(pixel)) return 0;
  return uchar(std::clamp(image.levels[level].At(pixel).intensity + 0.5F, 1.0F, 255.0F));
}

}  // namespace

FloorPatch FloorPatch::Of(const ImagePyramid& image, const cv::Mat& mask, const CameraModel& camera, const Pose& X_WC,
                          double cell_m, double range_m, int match_points) {
  const Pose X_PC = BelowCamera(X_WC).Inverse().Lifted() * X_WC, X_CP = X_PC.Inverse();
  const double height = X_PC.translation.z();
  GAITCAM_ASSERT(height > 0 && cell_m > 0);
  FloorPatch patch;
  if (range_m <= height) return patch;
  const Rectangle floor = VisibleFloor(camera, X_PC, std::sqrt(range_m * range_m - height * height));
  const int columns = int((floor.x1 - floor.x0) / cell_m) + 1, rows = int((floor.y1 - floor.y0) / cell_m) + 1;
  constexpr int kMinCells = 16;
  if (columns < kMinCells || rows < kMinCells) return patch;
  Level finest{cv::Mat(rows, columns, CV_8UC1, cv::Scalar(0)), cell_m, floor.x0, floor.y0, {}};
  const Eigen::Vector3d along = X_CP.rotation * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d across = X_CP.rotation * Eigen::Vector3d::UnitY();
  int seen = 0;
  for (int j = 0; j < rows; ++j) {
    const Eigen::Vector3d row = X_CP.translation + (floor.y0 + j * cell_m) * across;
    for (int i = 0; i < columns; ++i) {
      const Eigen::Vector3d p = row + (floor.x0 + i * cell_m) * along;
      if (p.z() <= 0 || p.squaredNorm() > range_m * range_m) continue;
      uchar& cell = finest.intensity.at<uchar>(j, i) = Rectified(image, mask, camera, p, cell_m);
      if (cell == 0) continue;
      patch.middle += Eigen::Vector2d(floor.x0 + i * cell_m, floor.y0 + j * cell_m);
      ++seen;
    }
  }
  if (seen == 0) return patch;
  patch.middle /= seen;
  patch.levels.push_back(std::move(finest));
  while (int(patch.levels.size()) < kLevels) patch.levels.push_back(Halved(patch.levels.back()));
  for (size_t k = 0; k < patch.levels.size(); ++k) {  // about as many points of every level
    constexpr int kBlocks[kLevels] = {6, 4, 2};
    patch.levels[k].match = ChooseMatchPoints(patch.levels[k], kBlocks[k], size_t(match_points) >> k);
  }
  return patch;
}

namespace {

/// The cells that a patch covers: columns and rows of a grid whose cell (i, j) has its centre at (i + 1/2, j + 1/2)
/// cells.
Eigen::AlignedBox2i CellsOf(const FloorPatch::Level& patch, const PlanarPose& pose, double cell_m) {
  Eigen::AlignedBox2i cells;
  for (const double x : {patch.x0, patch.x0 + patch.cell_m * patch.intensity.cols}) {
    for (const double y : {patch.y0, patch.y0 + patch.cell_m * patch.intensity.rows}) {
      const Eigen::Vector2d corner = pose * Eigen::Vector2d(x, y) / cell_m;
      cells.extend(Eigen::Vector2i(corner.array().floor().cast<int>()));
    }
  }
  return cells;
}

}  // namespace

FloorPicture DrawFloor(const std::vector<FloorPatch>& patches, const std::vector<PlanarPose>& poses, double cell_m) {
  GAITCAM_ASSERT(patches.size() == poses.size() && cell_m > 0);
  FloorPicture picture;
  picture.cell_m = cell_m;
  Eigen::AlignedBox2i all;
  for (size_t k = 0; k < patches.size(); ++k) {
    if (!patches[k].empty()) all.extend(CellsOf(patches[k].levels[0], poses[k], cell_m));
  }
  if (all.isEmpty()) return picture;
  const Eigen::Vector2i size = all.sizes() + Eigen::Vector2i(1, 1);
  cv::Mat sum(size.y(), size.x(), CV_32FC1, cv::Scalar(0));
  picture.sightings = cv::Mat(size.y(), size.x(), CV_16UC1, cv::Scalar(0));
  for (size_t k = 0; k < patches.size(); ++k) {
    if (patches[k].empty()) continue;
    const FloorPatch::Level& patch = patches[k].levels[0];
    const Eigen::AlignedBox2i cells = CellsOf(patch, poses[k], cell_m);
    const PlanarMotion inverse(poses[k].Inverse());
    for (int y = cells.min().y(); y <= cells.max().y(); ++y) {
      const int row = all.max().y() - y;  // row 0 lies towards +y
      for (int x = cells.min().x(); x <= cells.max().x(); ++x) {
        const auto sample = patch.At(inverse * (cell_m * Eigen::Vector2d(x + 0.5, y + 0.5)));
        if (!sample) continue;
        sum.at<float>(row, x - all.min().x()) += sample->intensity;
        ++picture.sightings.at<uint16_t>(row, x - all.min().x());
      }
    }
  }
  cv::Mat count, mean;
  picture.sightings.convertTo(count, CV_32F);
  cv::divide(sum, cv::max(count, 1), mean);
  mean.convertTo(picture.intensity, CV_8U);
  picture.corner_m = cell_m * Eigen::Vector2d(all.min().x() + 0.5, all.max().y() + 0.5);
  return picture;
}

}  // namespace gaitcam
