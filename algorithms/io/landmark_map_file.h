/// A map of landmarks as a CSV table, one row per point:
///
///   #id,x,y,z,cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz,descriptor
///
/// Position and covariance as in algorithms/core/landmark_map.h (the unit of the system's poses). The six covariances
/// are empty where none is known. A descriptor is "u8:" or "f32:" and its bytes in hexadecimal, floats little-endian;
/// empty where there is none.

#pragma once

#include <filesystem>

#include "algorithms/core/landmark_map.h"

namespace gaitcam {

/// Numbers read back to the same bits. @throws MissingResource if the file cannot be written.
void WriteLandmarkMap(const std::filesystem::path& file, const LandmarkMap& map);

/// @throws BadInput naming file, line and what is wrong: not a number, an id that stands twice, a malformed descriptor.
LandmarkMap ReadLandmarkMap(const std::filesystem::path& file);

}  // namespace gaitcam
