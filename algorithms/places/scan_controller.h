/// When a robot with a camera that pans asks for a scan of its surroundings, and the panorama that comes of it.
///
/// | state     | next        | when                                                                              |
/// |-----------|-------------|-----------------------------------------------------------------------------------|
/// | kAsking   | kScanning   | the first frame of a scan                                                         |
/// | kScanning | kSettling   | a frame outside the scan with 360 degrees seen; between two half scans, while     |
/// |           |             | the body turns, half of them is missing                                           |
/// | kSettling | kWalking    | `settle_s` after the scan's last frame, once a foot is lifted                     |
/// | kWalking  | kAsking     | Ask()                                                                             |
///
/// It begins in kAsking. More frames of a scan that has shown all, or of one that nobody asked for, lead to kSettling.

#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "algorithms/core/observation.h"
#include "algorithms/places/panorama.h"

namespace gaitcam {

class ScanController {
 public:
  enum class State { kAsking, kScanning, kSettling, kWalking };

  struct Options {
    PanoramaOptions panorama;
    double settle_s = 2;      ///< The head looks ahead again.
    double patience_s = 120;  ///< A scan that takes longer than this since it was asked for has failed.
  };

  /// What a finished scan has shown.
  struct Scan {
    Panorama panorama;
    int64_t began_ns = 0;  ///< Its first frame.
    double ahead_rad = 0;  ///< Heading of the body then, and of the panorama's middle.
  };

  /// @param projection must outlive the controller.
  ScanController(const CylinderProjection& projection, const PanoramaLayout& layout, const Options& options);

  /// Every frame. @param heading_rad the camera's, by gyroscope. @returns the scan that this frame ends.
  std::optional<Scan> Add(const Observation& observation, double heading_rad);
  /// After the last frame: the scan that ended with it.
  std::optional<Scan> Finish();
  /// @pre state() is kWalking.
  void Ask();

  State state() const { return state_; }
  /// A scan is asked for, or under way. Never again once one has failed: the body is free to walk on.
  bool wants_scan() const { return !failed_ && (state_ == State::kAsking || state_ == State::kScanning); }
  /// A scan has taken longer than it may; nothing more is done.
  bool failed() const { return failed_; }
  /// One line: what is missing of a scan that has begun, or that none came.
  std::string MissingText() const;

 private:
  void AddScanFrame(const Observation& observation, double heading_rad);
  double BodyHeading(double heading_rad, double pan_rad) const;
  bool Settled(const Observation& observation) const;
  Scan End();

  const CylinderProjection& projection_;
  PanoramaLayout layout_;
  Options options_;
  State state_ = State::kAsking;
  int64_t asked_ns_ = -1, began_ns_ = -1, ended_ns_ = -1;
  double asked_heading_rad_ = 0;  ///< At asked_ns_, ...
  double ahead_rad_ = 0;          ///< ... and of the body at began_ns_.
  std::optional<PanoramaBuilder> builder_;
  bool failed_ = false;
};

}  // namespace gaitcam
