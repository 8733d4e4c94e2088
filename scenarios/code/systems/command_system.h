/// Somebody else's SLAM behind our interface: frames are written to a dataset folder as they come; after the last one
/// the executable runs on it, and the trajectory file that it leaves is what the system says.

#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "algorithms/slam/system.h"
#include "scenarios/code/files/scenario.h"

namespace gaitcam {

class ExternalSystem : public System {
 public:
  /// The dataset lies in a folder of its own under $TMPDIR, no truth anywhere near it.
  /// @param log file that receives what the executable prints.
  /// @throws MissingResource if the folder cannot be made.
  ExternalSystem(const ExternalCommand& command, const SystemSetup& setup, const std::filesystem::path& log);
  ~ExternalSystem() override;

  /// No frame has a pose until the end.
  FrameEstimate Track(const Observation& observation) override;
  /// Runs the executable. Poses are taken for the frames whose stamps they are nearest to, within half a frame's
  /// interval (KITTI: row by row, one per frame).
  /// It failed if it exited with an error, was killed by the time limit, wrote no trajectory, or a malformed one.
  FinalEstimate Finish() override;

 private:
  class Dataset;
  std::vector<FrameEstimate> Run();

  ExternalCommand command_;
  uint64_t seed_;
  std::filesystem::path log_;
  std::unique_ptr<Dataset> dataset_;
  std::vector<FrameEstimate> frames_;
  std::string failure_;
};

/// Command words with their placeholders filled in. Pure.
std::vector<std::string> FillPlaceholders(std::vector<std::string> words, const std::filesystem::path& dataset,
                                          const std::filesystem::path& output, uint64_t seed);

/// Gives every frame the pose whose stamp is nearest to its own, within `max_difference_ns`; a frame without one is
/// initializing before the first pose and lost after it.
void PlaceByStamp(const Trajectory& trajectory, int64_t max_difference_ns, std::vector<FrameEstimate>& frames);

}  // namespace gaitcam
