/// A bird's-eye picture of a floor: per cell the sum of what was seen there and how often (thesis 6.5.2). Copies share
/// their tiles until one of them writes, so that a thousand particles cost little more than what they differ in.

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "algorithms/core/floor_picture.h"

namespace gaitcam {

class FloorMap {
 public:
  static constexpr int kTileCells = 64;  ///< Cells along a tile's side.

  /// @param cell_m side of a cell, > 0.
  explicit FloorMap(double cell_m = 0.005);

  double cell_m() const { return cell_m_; }

  /// Adds one sighting of the cell that holds a point. @param intensity 0..255.
  void Add(const Eigen::Vector2d& p_m, float intensity);
  /// Mean of what was seen in the cell that holds a point; nothing if it was never seen.
  std::optional<float> At(const Eigen::Vector2d& p_m) const;
  /// Bilinear between the four nearest cells' centres; nothing unless all four were seen.
  std::optional<float> Between(const Eigen::Vector2d& p_m) const;
  /// How often the cell that holds a point was seen.
  int Sightings(const Eigen::Vector2d& p_m) const;

  /// All tiles that hold anything; an empty picture if there is none.
  FloorPicture Draw() const;

  size_t tiles() const { return tiles_.size(); }
  /// Memory of the tiles that this map shares with no other one.
  size_t own_bytes() const;
  /// Memory of all its tiles, shared ones counted by their share.
  double shared_bytes() const;

 private:
  struct Tile {
    std::array<float, size_t(kTileCells) * kTileCells> sum{};
    std::array<uint16_t, size_t(kTileCells) * kTileCells> count{};
  };
  using Cell = std::pair<int, int>;

  Cell CellOf(const Eigen::Vector2d& p_m) const;
  const Tile* FindTile(const Cell& cell) const;
  Tile& WritableTile(const Cell& cell);
  std::optional<float> Mean(const Cell& cell) const;

  double cell_m_;
  std::map<Cell, std::shared_ptr<Tile>> tiles_;  ///< By tile indices.
};

}  // namespace gaitcam
