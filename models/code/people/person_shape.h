/// Appearance of a person: closed surfaces on the rigid parts that a walk moves.

#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "models/code/people/people.h"
#include "models/code/people/person_walk.h"

namespace gaitcam {

/// Two elliptical discs and all between them; empty if their axes are zero.
struct SolidCore {
  struct Disc {
    Eigen::Vector3d center{0, 0, 0}, a{0, 0, 0}, b{0, 0, 0};  ///< Half axes, m.
  };
  std::array<Disc, 2> ends;
};

/// A closed triangle mesh of one colour in the frame of its part; faces are counter-clockwise seen from outside.
struct PersonSurface {
  PersonPart part = PersonPart::kHips;
  Eigen::Vector3d rgb{0.5, 0.5, 0.5};  ///< Display values; of cloth, its mean.
  bool cloth = false;                  ///< Shows the cloth's texture.
  std::vector<Eigen::Vector3d> vertices, normals;
  std::vector<Eigen::Vector2d> texcoords;  ///< In repeats of the cloth, whose row 0 is at 0.
  std::vector<std::array<int, 3>> faces;
  SolidCore core;  ///< Lies within the surface: whatever it hides, the surface hides.
};

/// @param cloth_size_m size of one repeat of the cloth's texture.
std::vector<PersonSurface> PersonSurfaces(const PersonOptions& person, const Eigen::Vector2d& cloth_size_m);

}  // namespace gaitcam
