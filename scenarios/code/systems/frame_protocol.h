/// The lines that we exchange with a running program that is a SLAM system: JSON, one line each way per step, ours on
/// its standard input, its answers on its standard output. What it prints elsewhere goes to a log.
///
///   us    {"event": "start", "protocol": 1, "seed": 1, "frames": FILE, "settings": {...}, "calibration": {...}}
///   it    {"ready": true}, or {"error": "what is wrong with its settings"}
///   us    {"event": "frame", "stamp_ns": 1700000000020000000, "exposure_ms": 20, "image": IMAGE, "right": IMAGE,
///          "depth": IMAGE, "imu": [[stamp_ns, wx, wy, wz, ax, ay, az], ...],
///          "joints": [{"stamp_ns": 0, "position": [...], "left_contact": true, "right_contact": false}, ...],
///          "odometry": [[stamp_ns, x, y, heading], ...], "scan": {"pan_rad": 0, "body_turn_rad": 0}}
///   it    {"status": "tracking", "pose": [x, y, z, qx, qy, qz, qw], "covariance": [36 numbers, row by row],
///          "own_covariance": [36 numbers, where it is known what of it no other frame shares],
///          "common_errors": [[6 numbers of each error that is the same in all frames], ...],
///          "restarted": false, "features": 412, "inliers": 203, "matches": 260, "command": COMMAND},
///          or, without a pose, {"status": "lost", "predicted": [x, y, z, qx, qy, qz, qw]}
///   us    {"event": "finish"}
///   it    {"frames": [{"stamp_ns": 0, "status": "tracking", "pose": [...]}, ...], "maps": [MAP, ...], "failure": ""}
///
///   IMAGE    {"offset": 0, "height": 240, "width": 320, "channels": 3, "type": "uint8"}: rows from the top, packed,
///            channels blue, green, red; depth has one channel of "float32", metres. They lie at that offset in FILE,
///            which is in shared memory and stays as it is until the answer.
///   COMMAND  "follow_path", "scan", "end_walk", {"velocity": [forward m/s, left m/s, turn rad/s]} or {"go_to": [x m,
///            y m, rad]}; of a system that acts
///   MAP      {"landmarks": [[x, y, z], ...]}, or {"occupancy": {"cell_m": 0.05, "corner_m": [x, y],
///            "log_odds": [[...], ...]}} with one list per row
///
/// Of an answer only "status" is required, with "pose" where that is "tracking"; keys that are not listed are ignored.
/// Poses are X_WC as in Observation and Estimate. Numbers are written with as many digits as they have: what goes both
/// ways is the same to the bit.

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "algorithms/core/estimate.h"
#include "algorithms/slam/system.h"

namespace gaitcam {

/// The file that both sides share. One frame at a time: left image, right image, depth.
class SharedFrames {
 public:
  /// Makes the file, large enough for any frame of the rig. @throws MissingResource.
  SharedFrames(const std::filesystem::path& file, const Calibration& calibration);
  /// Opens it for reading. @throws MissingResource.
  explicit SharedFrames(const std::filesystem::path& file);
  ~SharedFrames();
  SharedFrames(const SharedFrames&) = delete;
  SharedFrames& operator=(const SharedFrames&) = delete;

  const std::filesystem::path& file() const { return file_; }
  uint8_t* data() const { return data_; }
  size_t size() const { return size_; }

 private:
  void Map(int descriptor, bool writes);

  std::filesystem::path file_;
  uint8_t* data_ = nullptr;
  size_t size_ = 0;
};

/// An answer to a frame.
struct FrameAnswer {
  FrameEstimate frame;
  BodyCommand command;  ///< FollowPath unless the answer has one.
};

/// Messages, each one line without its end. FrameMessage puts the pixels into `frames`.
std::string StartMessage(const SystemSetup& setup, const std::filesystem::path& frames);
std::string FrameMessage(const Observation& observation, SharedFrames& frames);
std::string FinishMessage();
std::string AnswerMessage(const FrameAnswer& answer);
/// Landmark maps and occupancy grids; there are no words for other kinds.
std::string FinalMessage(const FinalEstimate& final_estimate);

enum class FrameEvent { kStart, kFrame, kFinish };

/// What a line of ours says. @throws BadInput: none of the events.
FrameEvent EventOf(const std::string& line);
/// @param frames receives the name of the shared file
SystemSetup ReadStart(const std::string& line, std::filesystem::path& frames);
/// The pixels are copied.
Observation ReadFrame(const std::string& line, const SharedFrames& frames);

/// What is wrong with the start, as the program says; empty if it is ready.
/// @throws BadInput, in a few words: the line is not JSON or says neither.
std::string ReadReady(const std::string& line);
/// @throws BadInput, in a few words: not JSON, no status, a pose that is none.
FrameAnswer ReadAnswer(const std::string& line, int64_t stamp_ns);
/// @throws BadInput likewise.
FinalEstimate ReadFinal(const std::string& line);

}  // namespace gaitcam
