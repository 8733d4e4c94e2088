/// Somebody else's SLAM as a command: frames are written to a dataset folder as they come; after the last one the
/// program runs on it, and the trajectory file that it leaves is what the system says.

#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "algorithms/io/trajectory_file.h"
#include "algorithms/slam/system.h"
#include "scenarios/code/systems/system_choice.h"

namespace gaitcam {

class CommandSystem : public System {
 public:
  /// The dataset lies in a folder of its own under $TMPDIR, no truth anywhere near it. The program runs in a sandbox
  /// where there can be one (sandbox.h).
  /// @param readable what it may see of the user's files
  /// @param log file that receives what the program prints.
  /// @throws MissingResource if the folder cannot be made.
  CommandSystem(const CommandChoice& command, const std::vector<std::filesystem::path>& readable,
                const SystemSetup& setup, const std::filesystem::path& log);
  ~CommandSystem() override;

  /// No frame has a pose until the end.
  FrameEstimate Track(const Observation& observation) override;
  /// Runs the program. Poses are taken for the frames whose stamps they are nearest to, within half a frame's interval
  /// (KITTI: row by row, one per frame; VSLAM-LAB: key frames only, the other frames have no pose).
  /// It failed if it exited with an error, was killed by the time limit, wrote no trajectory, or a malformed one.
  FinalEstimate Finish() override;

 private:
  class Dataset;
  std::vector<FrameEstimate> Run();
  std::vector<std::string> Words() const;
  void ReadAnswer();

  CommandChoice command_;
  std::vector<std::filesystem::path> readable_;
  uint64_t seed_;
  std::filesystem::path log_;
  std::unique_ptr<Dataset> dataset_;
  std::vector<FrameEstimate> frames_;
  std::string failure_;
  std::vector<std::string> remarks_;
};

/// The arguments of VSLAM-LAB's interface, added where `words` do not have them: "key:value", or "--key value" for a
/// Python program.
/// @param sequence folder of the dataset, `output` the folder for what it writes
std::vector<std::string> AddVslamlabArguments(std::vector<std::string> words, const std::filesystem::path& sequence,
                                              const std::filesystem::path& output, VslamlabMode mode);

/// The poses of the key-frame trajectory in `output`: the one file there whose name says KeyFrameTrajectory. Fields
/// stand between commas or blanks: t x y z qx qy qz qw; t in seconds or nanoseconds; rows that do not begin with a
/// number are skipped, stamps are repaired (RepairStamps).
/// @throws BadInput: no such file, or a row that is no pose.
TrajectoryFile ReadKeyFrames(const std::filesystem::path& output);

/// Command words with their placeholders filled in. Pure.
std::vector<std::string> FillPlaceholders(std::vector<std::string> words, const std::filesystem::path& dataset,
                                          const std::filesystem::path& output, uint64_t seed);

/// Gives every frame the pose whose stamp is nearest to its own, within `max_difference_ns`; a frame without one is
/// initializing before the first pose and lost after it.
void PlaceByStamp(const Trajectory& trajectory, int64_t max_difference_ns, std::vector<FrameEstimate>& frames);

}  // namespace gaitcam
