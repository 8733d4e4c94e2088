#include "scenarios/code/runs/external_system.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "algorithms/core/errors.h"
#include "algorithms/io/dataset_writer.h"
#include "algorithms/io/trajectory_file.h"
#include "scenarios/code/systems/subprocess.h"

namespace gaitcam {
namespace fs = std::filesystem;

/// The folder that the executable is given, and where its output is expected; removed at the end.
class ExternalSystem::Dataset {
 public:
  Dataset(DatasetFormat format, const Calibration& calibration) : format_(format), folder_(MakeFolder()) {
    DatasetWriterOptions options;
    options.format = format;
    writer_.emplace(DatasetFolders{sensors(), folder_ / "none"}, calibration, options);
  }
  ~Dataset() {
    writer_.reset();
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  DatasetWriter& writer() { return *writer_; }
  fs::path sensors() const { return folder_ / "dataset"; }
  fs::path output() const { return folder_ / "estimate.txt"; }
  /// After the last frame: gives the folder its name.
  void Finish() {
    writer_->Finish("finished");
    std::error_code ignored;
    fs::remove_all(folder_ / "none", ignored);
  }

 private:
  static fs::path MakeFolder() {
    std::string name = (fs::temp_directory_path() / "gaitcam-system-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw MissingResource("cannot make a folder " + name);
    return name;
  }

  DatasetFormat format_;
  fs::path folder_;
  std::optional<DatasetWriter> writer_;
};

namespace {

void Replace(std::string& text, const std::string& what, const std::string& with) {
  for (size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += with.size()) {
    text.replace(at, what.size(), with);
  }
}

/// Row by row: KITTI's files have no stamps.
std::string PlaceByRow(const Trajectory& trajectory, std::vector<FrameEstimate>& frames) {
  if (trajectory.size() != frames.size()) {
    return fmt::format("wrote {} poses for {} frames; a KITTI file has one row for each", trajectory.size(),
                       frames.size());
  }
  for (size_t i = 0; i < frames.size(); ++i) {
    frames[i].status = TrackingStatus::kTracking;
    frames[i].pose = trajectory[i].pose;
  }
  return {};
}

int64_t HalfInterval(const std::vector<FrameEstimate>& frames) {
  int64_t least = 1000000000;
  for (size_t i = 1; i < frames.size(); ++i) least = std::min(least, frames[i].stamp_ns - frames[i - 1].stamp_ns);
  return least / 2;
}

}  // namespace

std::vector<std::string> FillPlaceholders(std::vector<std::string> words, const fs::path& dataset,
                                          const fs::path& output, uint64_t seed) {
  for (std::string& word : words) {
    Replace(word, "{dataset}", dataset.string());
    Replace(word, "{output}", output.string());
    Replace(word, "{calibration}", (dataset / "calibration.yaml").string());
    Replace(word, "{seed}", std::to_string(seed));
  }
  return words;
}

void PlaceByStamp(const Trajectory& trajectory, int64_t max_difference_ns, std::vector<FrameEstimate>& frames) {
  bool had_pose = false;
  size_t at = 0;
  for (FrameEstimate& frame : frames) {
    const auto distance = [&](size_t i) { return std::abs(trajectory[i].stamp_ns - frame.stamp_ns); };
    while (at + 1 < trajectory.size() && distance(at + 1) <= distance(at)) ++at;
    if (at < trajectory.size() && distance(at) <= max_difference_ns) {
      frame.status = TrackingStatus::kTracking;
      frame.pose = trajectory[at].pose;
      had_pose = true;
    } else {
      frame.status = had_pose ? TrackingStatus::kLost : TrackingStatus::kInitializing;
      frame.pose.reset();
    }
  }
}

ExternalSystem::ExternalSystem(const ExternalCommand& command, const SystemSetup& setup, const fs::path& log)
    : command_(command),
      seed_(setup.seed),
      log_(log),
      dataset_(std::make_unique<Dataset>(command.dataset, setup.calibration)) {}

ExternalSystem::~ExternalSystem() = default;

FrameEstimate ExternalSystem::Track(const Observation& observation) {
  dataset_->writer().Add(observation, std::nullopt);
  FrameEstimate answer;
  answer.stamp_ns = observation.stamp_ns;
  frames_.push_back(answer);
  return answer;
}

FinalEstimate ExternalSystem::Finish() {
  dataset_->Finish();
  FinalEstimate answer;
  answer.frames = Run();
  answer.failure = failure_;
  dataset_.reset();
  return answer;
}

std::vector<FrameEstimate> ExternalSystem::Run() {
  Subprocess program(FillPlaceholders(command_.command, dataset_->sensors(), dataset_->output(), seed_), log_);
  const std::optional<Ending> ending = program.Wait(command_.time_limit_s);
  if (!ending) {
    failure_ = fmt::format("did not end within {:g} s", command_.time_limit_s);
    return frames_;
  }
  if (!ending->ok()) {
    const std::string said = LastLine(log_);
    failure_ = ending->ToText() + (said.empty() ? "" : ": " + said);
    return frames_;
  }
  if (!fs::exists(dataset_->output())) {
    failure_ = "wrote no trajectory to {output}";
    return frames_;
  }
  try {
    const TrajectoryFormat format = command_.format;
    const Trajectory trajectory = ReadTrajectory(dataset_->output(), format).trajectory;
    if (format == TrajectoryFormat::kKitti) {
      failure_ = PlaceByRow(trajectory, frames_);
    } else {
      PlaceByStamp(trajectory, HalfInterval(frames_), frames_);
    }
  } catch (const BadInput& e) {
    failure_ = std::string("wrote a malformed trajectory: ") + e.what();
    Replace(failure_, dataset_->output().string(), "{output}");
  }
  return frames_;
}

}  // namespace gaitcam
