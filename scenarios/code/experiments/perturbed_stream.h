/// What may go wrong between sensors and a system, by a level that can be turned up: recordings whose frames are lost,
/// repeated, exchanged or spoilt, whose stamps stray, whose IMU is silent now and then, whose calibration is wrong.
///
/// Each is a function of recording, level and seed alone, and a stronger one of the same seed contains the weaker one:
/// what a level does to a frame, every higher level does too. Level 0 changes nothing.

#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/enum_words.h"
#include "algorithms/core/observation.h"

namespace gaitcam {

enum class PerturbationKind {
  kDropped,
  kDoubled,
  kSwapped,
  kFrozen,
  kBlack,
  kOverExposed,
  kStampJitter,
  kImuGaps,
  kFocalLength
};
constexpr auto WordsOf(PerturbationKind) {
  return std::array{EnumWord{PerturbationKind::kDropped, "dropped"},
                    EnumWord{PerturbationKind::kDoubled, "doubled"},
                    EnumWord{PerturbationKind::kSwapped, "swapped"},
                    EnumWord{PerturbationKind::kFrozen, "frozen"},
                    EnumWord{PerturbationKind::kBlack, "black"},
                    EnumWord{PerturbationKind::kOverExposed, "over_exposed"},
                    EnumWord{PerturbationKind::kStampJitter, "stamp_jitter"},
                    EnumWord{PerturbationKind::kImuGaps, "imu_gaps"},
                    EnumWord{PerturbationKind::kFocalLength, "focal_length"}};
}

struct PerturbationInfo {
  PerturbationKind kind;
  std::string_view unit;     ///< Of the level.
  double largest = 0;        ///< Level.
  std::string_view meaning;  ///< What a level does, one line.
};

/// In the order of PerturbationKind.
const std::vector<PerturbationInfo>& ListPerturbations();
const PerturbationInfo& InfoOf(PerturbationKind kind);

/// An observation as a system is given it.
struct HandedOver {
  Observation observation;
  /// When its image was truly taken, by which the answer to it is scored; nothing if it shows nothing, or what an
  /// earlier observation has shown.
  std::optional<int64_t> shown_ns;
};

/// All that a system is given of a recording.
struct RecordedStream {
  Calibration calibration;
  std::vector<HandedOver> frames;  ///< Stamps increase strictly.
};

/// Whether a recording has what is perturbed: IMU gaps need an IMU.
bool HasStreamOf(PerturbationKind kind, const RecordedStream& stream);

/// The recording with that much wrong. Images are shared with `clean`, not copied, where they are not changed.
/// @param level from 0 to PerturbationInfo::largest
/// @pre HasStreamOf(kind, clean); stamps of `clean` increase.
RecordedStream Perturbed(const RecordedStream& clean, PerturbationKind kind, double level, uint64_t seed);

}  // namespace gaitcam
