/// Of the frames between two tests the one that the walk blurs and tilts least.

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>

#include "algorithms/core/enum_words.h"
#include "algorithms/core/observation.h"

namespace gaitcam {

/// What makes a frame steady.
enum class Steadiness {
  kGyro,           ///< The least angular rate while the shutter was open.
  kDoubleSupport,  ///< The most time on both feet since the frame before.
  kLast,           ///< Nothing: the last frame is taken.
};

constexpr auto WordsOf(Steadiness) {
  return std::array{EnumWord{Steadiness::kGyro, "gyro"}, EnumWord{Steadiness::kDoubleSupport, "double_support"},
                    EnumWord{Steadiness::kLast, "last"}};
}

/// A frame, and how its camera was oriented.
struct SteadyView {
  cv::Mat image;
  Eigen::Vector3d up_C = Eigen::Vector3d::UnitY();
  int64_t stamp_ns = 0;
  double heading_rad = 0;
};

class SteadyViewPicker {
 public:
  /// @param interval_s between two views.
  SteadyViewPicker(Steadiness steadiness, double interval_s) : steadiness_(steadiness), interval_s_(interval_s) {}

  /// @returns the steadiest frame since the last one returned, where the interval is over; of equals the later one.
  std::optional<SteadyView> Add(const Observation& observation, const Eigen::Vector3d& up_C, double heading_rad);
  /// Drops what was collected; the interval begins with the next frame.
  void Reset();

 private:
  Steadiness steadiness_;
  double interval_s_;
  std::optional<SteadyView> best_;
  double best_unrest_ = 0;
  int64_t returned_ns_ = -1;
};

}  // namespace gaitcam
