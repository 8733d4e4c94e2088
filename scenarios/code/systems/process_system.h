/// Somebody else's SLAM as a running process: it answers frame by frame (frame_protocol.h), and so do shared libraries,
/// which a process of ours hosts (served_system.h).
///
/// What goes wrong in it is its own failure and is scored as such: a crash, an answer that is none, silence beyond the
/// limit. It is killed then, and no later frame has a pose.

#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "algorithms/slam/system.h"

namespace gaitcam {

struct ProcessOptions {
  std::vector<std::string> command;             ///< Its first word is a path.
  std::vector<std::filesystem::path> readable;  ///< What it may see of the user's files (sandbox.h).
  double start_limit_s = 60;                    ///< For its answer to the start,
  double frame_limit_s = 10;                    ///< to a frame,
  double finish_limit_s = 600;                  ///< and at the end.
  double memory_mb = 0;                         ///< As ForeignMemory_mb has it.
};

class ProcessSystem : public System {
 public:
  /// Starts it; it lives in a sandbox where there can be one.
  /// @param log file that receives what it prints to standard error.
  /// @throws BadInput with its own words if it refuses its settings; MissingResource.
  ProcessSystem(const ProcessOptions& options, const SystemSetup& setup, const std::filesystem::path& log);
  ~ProcessSystem() override;

  FrameEstimate Track(const Observation& observation) override;
  FinalEstimate Finish() override;
  BodyCommand Command() const override { return command_; }

 private:
  class Conversation;
  void Fail(const std::string& when, const std::string& what);

  ProcessOptions options_;
  std::unique_ptr<Conversation> conversation_;  ///< None once it has failed.
  std::string failure_;
  BodyCommand command_;
  int64_t frames_ = 0;
  bool had_pose_ = false;
};

}  // namespace gaitcam
