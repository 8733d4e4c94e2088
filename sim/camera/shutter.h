/// Sampling times of an exposure.
///
/// The exposure is divided into slots; one sub-frame stands for each, at its middle, with the slot's duration as
/// weight (the midpoint rule). The slots are short while the image moves fast and long while it moves slowly, so that
/// no image point moves further than a given step from one sub-frame to the next.
///
/// Rolling shutter: row r of H is open during the frame's interval shifted by readout * (r / (H - 1) - 1/2). One set of
/// slots covers all rows; each row weighs a slot by how much of it lies within the row's own interval.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/camera/exposure_options.h"

namespace gaitcam {

/// From the first row's opening to the last row's close.
struct ShutterInterval {
  int64_t open_ns = 0, close_ns = 0;
};

/// @param stamp_ns middle of the middle row's exposure.
ShutterInterval WholeShutter(const ExposureOptions& options, int64_t stamp_ns);
/// Of the middle row alone; the same for a global shutter.
ShutterInterval MiddleRowShutter(const ExposureOptions& options, int64_t stamp_ns);
/// Of any row of an image of `rows` rows.
ShutterInterval RowShutter(const ExposureOptions& options, int64_t stamp_ns, double row, int rows);

/// Travel of the fastest image point since the shutter opened; piecewise linear between the stamps.
struct MotionProfile {
  std::vector<int64_t> stamps_ns;  ///< Increasing, from the whole shutter's opening to its close.
  std::vector<double> travel_px;   ///< Starts at 0, never decreases.
  Eigen::Vector2d axis{1, 0};      ///< Unit vector: principal direction of the image motion.
  double typical_px = 0;           ///< Median motion of the image points, from open to close.

  /// @pre there are two stamps at least.
  double TravelAt(int64_t stamp_ns) const;
};

struct ShutterSlot {
  int64_t open_ns = 0, close_ns = 0;
  int64_t stamp_ns = 0;            ///< The middle.
  double weight = 0;               ///< Part of the whole shutter's time; the weights add up to 1.
  Eigen::Vector2d shift_px{0, 0};  ///< Sub-pixel offset of the render; of weighted mean zero.
};

using ShutterPlan = std::vector<ShutterSlot>;

/// @param antialias the minimum number of slots unless options.fixed_subframes is set.
/// @param motion may be empty if options.fixed_subframes is set; the slots are then equally long in any case.
ShutterPlan PlanShutter(const ExposureOptions& options, int64_t stamp_ns, int antialias, const MotionProfile& motion);

/// Weight of each slot in one row; adds up to 1. Equal to the slots' own weights for a global shutter.
std::vector<float> RowWeights(const ExposureOptions& options, int64_t stamp_ns, const ShutterPlan& plan, int row,
                              int rows);
/// The same by slot, then row.
std::vector<std::vector<float>> SlotWeights(const ExposureOptions& options, int64_t stamp_ns, const ShutterPlan& plan,
                                            int rows);

/// Which sub-frames a key picture serves (key_picture.h).
struct KeySlot {
  int64_t stamp_ns = 0;    ///< Of the key; that of a sub-frame, or mid-exposure.
  int first = 0, end = 0;  ///< The sub-frames [first, end) lie nearest to it.
};

/// @param keys how many; odd. One of them is at `stamp_ns`, mid-exposure, the others divide the sub-frames evenly.
std::vector<KeySlot> PlanKeys(const ShutterPlan& plan, int64_t stamp_ns, int keys);

/// The furthest that any image point moves between a key and a sub-frame that it serves, px.
double LongestReach(const std::vector<KeySlot>& keys, const ShutterPlan& plan, const MotionProfile& motion);

}  // namespace gaitcam
