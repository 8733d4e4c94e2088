#include "algorithms/planes/floor_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int kSide = FloorMap::kTileCells;

/// Rounds towards minus infinity, as tiles must.
int FloorDiv(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

std::pair<int, int> TileOf(const std::pair<int, int>& cell) {
  return {FloorDiv(cell.first, kSide), FloorDiv(cell.second, kSide)};
}

size_t IndexIn(const std::pair<int, int>& cell) {
  const auto [tx, ty] = TileOf(cell);
  return size_t(cell.second - ty * kSide) * kSide + size_t(cell.first - tx * kSide);
}

}  // namespace

FloorMap::FloorMap(double cell_m) : cell_m_(cell_m) { GAITCAM_ASSERT(cell_m > 0); }

FloorMap::Cell FloorMap::CellOf(const Eigen::Vector2d& p_m) const {
  return {int(std::floor(p_m.x() / cell_m_)), int(std::floor(p_m.y() / cell_m_))};
}

const FloorMap::Tile* FloorMap::FindTile(const Cell& cell) const {
  const auto there = tiles_.find(TileOf(cell));
  return there == tiles_.end() ? nullptr : there->second.get();
}

FloorMap::Tile& FloorMap::WritableTile(const Cell& cell) {
  std::shared_ptr<Tile>& tile = tiles_[TileOf(cell)];
  if (!tile) {
    tile = std::make_shared<Tile>();
  } else if (tile.use_count() > 1) {
    tile = std::make_shared<Tile>(*tile);
  }
  return *tile;
}

void FloorMap::Add(const Eigen::Vector2d& p_m, float intensity) {
  const Cell cell = CellOf(p_m);
  Tile& tile = WritableTile(cell);
  const size_t i = IndexIn(cell);
  if (tile.count[i] == std::numeric_limits<uint16_t>::max()) {  // the mean stays, the newest weighs a little
    tile.sum[i] *= 0.5F;
    tile.count[i] /= 2;
  }
  tile.sum[i] += intensity;
  ++tile.count[i];
}

std::optional<float> FloorMap::Mean(const Cell& cell) const {
  const Tile* tile = FindTile(cell);
  if (tile == nullptr) return std::nullopt;
  const size_t i = IndexIn(cell);
  if (tile->count[i] == 0) return std::nullopt;
  return tile->sum[i] / float(tile->count[i]);
}

std::optional<float> FloorMap::At(const Eigen::Vector2d& p_m) const { return Mean(CellOf(p_m)); }

int FloorMap::Sightings(const Eigen::Vector2d& p_m) const {
  const Cell cell = CellOf(p_m);
  const Tile* tile = FindTile(cell);
  return tile == nullptr ? 0 : tile->count[IndexIn(cell)];
}

std::optional<float> FloorMap::Between(const Eigen::Vector2d& p_m) const {
  const Eigen::Vector2d from_centre = p_m / cell_m_ - Eigen::Vector2d(0.5, 0.5);
  const Cell corner{int(std::floor(from_centre.x())), int(std::floor(from_centre.y()))};
  const float a = float(from_centre.x() - corner.first), b = float(from_centre.y() - corner.second);
  float sum = 0;
  for (const int dy : {0, 1}) {
    for (const int dx : {0, 1}) {
      const std::optional<float> mean = Mean({corner.first + dx, corner.second + dy});
      if (!mean) return std::nullopt;
      sum += (dx == 0 ? 1 - a : a) * (dy == 0 ? 1 - b : b) * *mean;
    }
  }
  return sum;
}

FloorPicture FloorMap::Draw() const {
  FloorPicture picture;
  picture.cell_m = cell_m_;
  if (tiles_.empty()) return picture;
  int min_x = std::numeric_limits<int>::max(), min_y = min_x, max_x = std::numeric_limits<int>::min(), max_y = max_x;
  for (const auto& [tile, content] : tiles_) {
    min_x = std::min(min_x, tile.first);
    max_x = std::max(max_x, tile.first);
    min_y = std::min(min_y, tile.second);
    max_y = std::max(max_y, tile.second);
  }
  const int width = (max_x - min_x + 1) * kSide, height = (max_y - min_y + 1) * kSide;
  picture.intensity = cv::Mat(height, width, CV_8UC1, cv::Scalar(0));
  picture.sightings = cv::Mat(height, width, CV_16UC1, cv::Scalar(0));
  picture.corner_m = {(min_x * kSide + 0.5) * cell_m_, ((max_y + 1) * kSide - 0.5) * cell_m_};
  for (const auto& [tile, content] : tiles_) {
    for (int i = 0; i < kSide * kSide; ++i) {
      const uint16_t count = content->count[size_t(i)];
      if (count == 0) continue;
      const int column = (tile.first - min_x) * kSide + i % kSide;
      const int row = height - 1 - ((tile.second - min_y) * kSide + i / kSide);
      picture.intensity.at<uchar>(row, column) = cv::saturate_cast<uchar>(content->sum[size_t(i)] / float(count));
      picture.sightings.at<uint16_t>(row, column) = count;
    }
  }
  return picture;
}

size_t FloorMap::own_bytes() const {
  return sizeof(Tile) * size_t(std::count_if(tiles_.begin(), tiles_.end(),
                                             [](const auto& entry) { return entry.second.use_count() == 1; }));
}

double FloorMap::shared_bytes() const {
  double bytes = 0;
  for (const auto& [tile, content] : tiles_) bytes += double(sizeof(Tile)) / double(content.use_count());
  return bytes;
}

}  // namespace gaitcam
