/// Furniture made of a few boxes each, for things that stand in scenes.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "algorithms/core/random.h"

namespace gaitcam {

/// One box of a piece of furniture. Frame: origin on the floor in the middle of the footprint, x to the front, z up.
struct FurniturePart {
  Eigen::Vector3d center, size;
  std::string texture;                   ///< A kind of texture, "main" for the piece's own, or empty for plain colour.
  Eigen::Vector2d texture_size_m{0, 0};  ///< One repeat; 0: stretched over each face.
  Eigen::Vector3d rgb{0.3, 0.3, 0.32};
};

/// Defaults of a kind of furniture.
struct FurnitureKind {
  std::string name;
  Eigen::Vector3d size;  ///< Depth, width, height, m.
  std::string texture;   ///< Kind of its main texture.
  bool own_texture;      ///< Each piece looks different; otherwise all share one picture.
  double seat;           ///< Where one sits on it, of its height; 0: one does not.
  std::vector<FurniturePart> (*make)(const Eigen::Vector3d& size, RandomStream& random);
};

/// All kinds, sorted by name.
const std::vector<FurnitureKind>& AllFurniture();

}  // namespace gaitcam
