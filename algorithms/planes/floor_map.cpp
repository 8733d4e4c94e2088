#include "algorithms/planes/floor_map.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int kSide = FloorMap::kTileCells;
constexpr int kShift = 6, kMask = kSide - 1;  // arithmetic shifts round towards minus infinity, as tiles must
static_assert(1 << kShift == kSide);

size_t IndexIn(int x, int y) { return size_t((y & kMask) << kShift | (x & kMask)); }

constexpr float kMeanScale = 256;

}  // namespace

FloorMap::FloorMap(double cell_m) : cell_m_(cell_m) { GAITCAM_ASSERT(cell_m > 0); }

FloorMap::Cell FloorMap::CellOf(const Eigen::Vector2d& p_m) const {
  return {int(std::floor(p_m.x() / cell_m_)), int(std::floor(p_m.y() / cell_m_))};
}

const FloorMap::Tile* FloorMap::FindTile(int tile_x, int tile_y) const {
  const int column = tile_x - left_, row = tile_y - bottom_;
  if (column < 0 || row < 0 || column >= across_ || row >= up_) return nullptr;
  return directory_[size_t(row * across_ + column)].get();
}

/// Makes the directory hold a tile's place, with room to spare so that this happens seldom.
void FloorMap::Enlarge(int tile_x, int tile_y) {
  constexpr int kRoom = 4;
  const bool first = directory_.empty();
  const int left = std::min(first ? tile_x : left_, tile_x - kRoom);
  const int bottom = std::min(first ? tile_y : bottom_, tile_y - kRoom);
  const int right = std::max(first ? tile_x : left_ + across_, tile_x + kRoom + 1);
  const int top = std::max(first ? tile_y : bottom_ + up_, tile_y + kRoom + 1);
  std::vector<std::shared_ptr<Tile>> larger(size_t(right - left) * size_t(top - bottom));
  for (int row = 0; row < up_; ++row) {
    for (int column = 0; column < across_; ++column) {
      larger[size_t((row + bottom_ - bottom) * (right - left) + column + left_ - left)] =
          std::move(directory_[size_t(row * across_ + column)]);
    }
  }
  directory_ = std::move(larger);
  left_ = left, bottom_ = bottom, across_ = right - left, up_ = top - bottom;
}

FloorMap::Tile& FloorMap::WritableTile(int tile_x, int tile_y) {
  if (tile_x < left_ || tile_y < bottom_ || tile_x >= left_ + across_ || tile_y >= bottom_ + up_) {
    Enlarge(tile_x, tile_y);
  }
  std::shared_ptr<Tile>& tile = directory_[size_t((tile_y - bottom_) * across_ + tile_x - left_)];
  if (!tile) {
    tile = std::make_shared<Tile>();
  } else if (tile.use_count() > 1) {
    tile = std::make_shared<Tile>(*tile);
  }
  return *tile;
}

void FloorMap::Add(const Eigen::Vector2d& p_m, float intensity, uint16_t when) {
  const Cell cell = CellOf(p_m);
  Tile& tile = WritableTile(cell.x >> kShift, cell.y >> kShift);
  const size_t i = IndexIn(cell.x, cell.y);
  if (tile.count[i] == 0) tile.first[i] = when;
  if (tile.count[i] < std::numeric_limits<uint8_t>::max()) ++tile.count[i];
  const float mean = float(tile.mean[i]);
  tile.mean[i] = uint16_t(std::lround(mean + (kMeanScale * intensity - mean) / float(tile.count[i])));
}

std::optional<FloorMap::Sample> FloorMap::At(const Eigen::Vector2d& p_m, uint16_t until) const {
  const double cells_x = p_m.x() / cell_m_ - 0.5, cells_y = p_m.y() / cell_m_ - 0.5;
  const int x = int(std::floor(cells_x)), y = int(std::floor(cells_y));
  float corner[2][2];
  const Tile* tile = nullptr;
  for (int dy = 0; dy < 2; ++dy) {
    for (int dx = 0; dx < 2; ++dx) {
      if (dx == 0 || ((x + 1) & kMask) == 0) tile = FindTile((x + dx) >> kShift, (y + dy) >> kShift);
      if (tile == nullptr) return std::nullopt;
      const size_t i = IndexIn(x + dx, y + dy);
      if (tile->count[i] == 0 || tile->first[i] > until) return std::nullopt;
      corner[dy][dx] = float(tile->mean[i]) / kMeanScale;
    }
  }
  const float a = float(cells_x - x), b = float(cells_y - y);
  const float low = corner[0][0] + a * (corner[0][1] - corner[0][0]);
  const float high = corner[1][0] + a * (corner[1][1] - corner[1][0]);
  const float per_m = float(1 / cell_m_);
  return Sample{low + b * (high - low),
                per_m * ((1 - b) * (corner[0][1] - corner[0][0]) + b * (corner[1][1] - corner[1][0])),
                per_m * (high - low)};
}

int FloorMap::Sightings(const Eigen::Vector2d& p_m) const {
  const Cell cell = CellOf(p_m);
  const Tile* tile = FindTile(cell.x >> kShift, cell.y >> kShift);
  return tile == nullptr ? 0 : tile->count[IndexIn(cell.x, cell.y)];
}

FloorPicture FloorMap::Draw() const {
  FloorPicture picture;
  picture.cell_m = cell_m_;
  int left = std::numeric_limits<int>::max(), bottom = left, right = std::numeric_limits<int>::min(), top = right;
  for (int row = 0; row < up_; ++row) {
    for (int column = 0; column < across_; ++column) {
      if (!directory_[size_t(row * across_ + column)]) continue;
      left = std::min(left, column), right = std::max(right, column);
      bottom = std::min(bottom, row), top = std::max(top, row);
    }
  }
  if (left > right) return picture;
  const int width = (right - left + 1) * kSide, height = (top - bottom + 1) * kSide;
  picture.intensity = cv::Mat(height, width, CV_8UC1, cv::Scalar(0));
  picture.sightings = cv::Mat(height, width, CV_16UC1, cv::Scalar(0));
  picture.corner_m = {((left_ + left) * kSide + 0.5) * cell_m_, ((bottom_ + top + 1) * kSide - 0.5) * cell_m_};
  for (int v = 0; v < height; ++v) {
    const int y = height - 1 - v;  // row 0 lies towards +y
    for (int x = 0; x < width; ++x) {
      const Tile* tile = FindTile(left_ + left + x / kSide, bottom_ + bottom + y / kSide);
      const size_t i = IndexIn(x, y);
      if (tile == nullptr || tile->count[i] == 0) continue;
      picture.intensity.at<uchar>(v, x) = cv::saturate_cast<uchar>(float(tile->mean[i]) / kMeanScale);
      picture.sightings.at<uint16_t>(v, x) = tile->count[i];
    }
  }
  return picture;
}

size_t FloorMap::tiles() const {
  return size_t(std::count_if(directory_.begin(), directory_.end(), [](const auto& tile) { return bool(tile); }));
}

size_t FloorMap::own_bytes() const {
  return sizeof(Tile) *
         size_t(std::count_if(directory_.begin(), directory_.end(), [](const auto& t) { return t.use_count() == 1; }));
}

double FloorMap::shared_bytes() const {
  double bytes = double(directory_.size() * sizeof(directory_[0]));
  for (const auto& tile : directory_) {
    if (tile) bytes += double(sizeof(Tile)) / double(tile.use_count());
  }
  return bytes;
}

}  // namespace gaitcam
