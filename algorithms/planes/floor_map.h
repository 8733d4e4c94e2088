/// A bird's-eye picture of a floor: per cell the mean of what was seen there and how often (thesis 6.5.2: map and
/// mask). Copies share their tiles until one of them writes, so that a thousand particles cost little more than what
/// they differ in.

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "algorithms/core/floor_picture.h"

namespace gaitcam {

class FloorMap {
 public:
  static constexpr int kTileCells = 64;  ///< Cells along a tile's side.
  static constexpr uint16_t kAnyTime = std::numeric_limits<uint16_t>::max();

  /// @param cell_m side of a cell, > 0.
  explicit FloorMap(double cell_m = 0.005);

  double cell_m() const { return cell_m_; }

  /// Adds one sighting of the cell that holds a point. From the 255th on, a cell follows what is new slowly.
  /// @param intensity 0..255. @param when any count that does not fall: a cell remembers that of its first sighting.
  void Add(const Eigen::Vector2d& p_m, float intensity, uint16_t when = 0);

  struct Sample {
    float intensity = 0;   ///< 0..255
    float dx = 0, dy = 0;  ///< Per metre.
  };
  /// Bilinear between the four nearest cells' centres; nothing unless all four were seen first at `until` or before.
  std::optional<Sample> At(const Eigen::Vector2d& p_m, uint16_t until = kAnyTime) const;
  /// How often the cell that holds a point was seen, at most 255.
  int Sightings(const Eigen::Vector2d& p_m) const;

  /// All tiles that hold anything; empty if there is none.
  FloorPicture Draw() const;

  size_t tiles() const;
  /// Memory of the tiles that this map shares with no other one.
  size_t own_bytes() const;
  /// Memory of all its tiles, shared ones counted by their share, and of its directory.
  double shared_bytes() const;

 private:
  static constexpr int kCells = kTileCells * kTileCells;
  struct Tile {
    std::array<uint16_t, kCells> mean{};   ///< 1/256 grey levels.
    std::array<uint16_t, kCells> first{};  ///< When it was first seen.
    std::array<uint8_t, kCells> count{};
  };
  struct Cell {
    int x, y;
  };

  Cell CellOf(const Eigen::Vector2d& p_m) const;
  const Tile* FindTile(int tile_x, int tile_y) const;
  Tile& WritableTile(int tile_x, int tile_y);
  void Enlarge(int tile_x, int tile_y);

  double cell_m_;
  int left_ = 0, bottom_ = 0, across_ = 0, up_ = 0;  ///< The directory's rectangle of tiles.
  std::vector<std::shared_ptr<Tile>> directory_;
};

}  // namespace gaitcam
