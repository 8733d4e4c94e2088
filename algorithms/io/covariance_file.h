/// Covariances of estimated poses, beside the trajectory that they belong to: one row per frame that has one,
///
///   #stamp_ns,c11,c12,...,c16,c22,...,c66
///
/// the upper triangle row by row (21 numbers) of the covariance of tau = (rho_x, rho_y, rho_z, phi_x, phi_y, phi_z) in
/// X_WC Exp(tau): rho in the unit of the trajectory, phi in rad, both along the camera's axes. Where a system says it,
/// 21 more follow, o11 to o66: the part of it that is the frame's own (FrameEstimate::own_covariance). After
/// these come six for each error that is the same in all frames, g11 to g16, g21 to ... (FrameEstimate::common_errors).

#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "algorithms/core/estimate.h"

namespace gaitcam {

/// "covariances.csv" for "estimate.txt", "covariances-NAME.csv" for "estimate-NAME.txt", else "NAME-covariances.csv"
/// for "NAME.txt"; in the same folder.
std::filesystem::path CovarianceFileOf(const std::filesystem::path& trajectory);

/// Numbers read back to the same bits. @returns false, having written nothing, if no frame has a covariance.
/// @throws MissingResource if the file cannot be written.
bool WriteCovariances(const std::filesystem::path& file, const std::vector<FrameEstimate>& frames);

struct StampedCovariance {
  int64_t stamp_ns = 0;
  Matrix6d covariance = Matrix6d::Zero();
  std::optional<Matrix6d> own_covariance;
  CommonErrors common_errors;
};

/// @throws BadInput naming file, line and what is wrong: not a number, stamps that do not increase, a row of
/// fewer than 22, or of 23 to 42 fields, or of another number beyond 43 than six per error.
std::vector<StampedCovariance> ReadCovariances(const std::filesystem::path& file);

}  // namespace gaitcam
