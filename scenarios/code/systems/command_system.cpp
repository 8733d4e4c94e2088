#include "scenarios/code/systems/command_system.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/io/dataset_writer.h"
#include "algorithms/io/trajectory_file.h"
#include "scenarios/code/systems/foreign_words.h"
#include "scenarios/code/systems/private_folder.h"
#include "scenarios/code/systems/sandbox.h"
#include "scenarios/code/systems/subprocess.h"

namespace gaitcam {
namespace fs = std::filesystem;

/// The folder that the program is given, and the one where its output is expected; both removed at the end.
class CommandSystem::Dataset {
 public:
  Dataset(DatasetFormat format, const Calibration& calibration) {
    DatasetWriterOptions options;
    options.format = format;
    writer_.emplace(DatasetFolders{sensors(), folder_.path() / "none"}, calibration, options);
    fs::create_directory(answers());
  }

  DatasetWriter& writer() { return *writer_; }
  fs::path sensors() const { return folder_.path() / "dataset"; }
  fs::path log() const {
    return folder_.path() / "log";
  }  // not beside the truth: its name is to be seen by the program
  fs::path answers() const { return folder_.path() / "answers"; }
  fs::path output() const { return answers() / "estimate.txt"; }
  /// After the last frame: gives the folder its name.
  void Finish() {
    writer_->Finish("finished");
    std::error_code ignored;
    fs::remove_all(folder_.path() / "none", ignored);
  }

 private:
  PrivateFolder folder_;
  std::optional<DatasetWriter> writer_;
};

namespace {

/// A link may lead to what the program itself could not see, as the truth; a pipe or a device may never end.
bool IsItsOwnFile(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(fs::symlink_status(file, ignored));
}

/// @throws BadInput.
void CheckDistances(const Trajectory& trajectory) {
  for (const StampedPose& pose : trajectory) {
    if (pose.pose.translation.norm() <= kMaxForeignDistance_m) continue;
    throw BadInput(fmt::format("the pose at {:.9f} s is further away than {:g} m", double(pose.stamp_ns) * 1e-9,
                               kMaxForeignDistance_m));
  }
}

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

DatasetFormat LayoutFor(const CommandChoice& command) {
  return command.interface == CommandInterface::kVslamlab ? DatasetFormat::kVslamlab : command.dataset;
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
      frame.pose_delay_ns = trajectory[at].stamp_ns - frame.stamp_ns;
      had_pose = true;
      ++at;  // a pose is of one frame
    } else {
      frame.status = had_pose ? TrackingStatus::kLost : TrackingStatus::kInitializing;
      frame.pose.reset();
    }
  }
}

CommandSystem::CommandSystem(const CommandChoice& command, const std::vector<fs::path>& readable,
                             const SystemSetup& setup, const fs::path& log)
    : command_(command),
      readable_(readable),
      seed_(setup.seed),
      log_(log),
      dataset_(std::make_unique<Dataset>(LayoutFor(command), setup.calibration)) {}

CommandSystem::~CommandSystem() = default;

FrameEstimate CommandSystem::Track(const Observation& observation) {
  dataset_->writer().Add(observation, std::nullopt);
  FrameEstimate answer;
  answer.stamp_ns = observation.stamp_ns;
  frames_.push_back(answer);
  return answer;
}

FinalEstimate CommandSystem::Finish() {
  dataset_->Finish();
  FinalEstimate answer;
  answer.frames = Run();
  answer.saw_all_first = true;
  answer.keyframes_only = command_.interface == CommandInterface::kVslamlab;
  answer.failure = failure_;
  answer.remarks = remarks_;
  dataset_.reset();
  return answer;
}

std::vector<std::string> CommandSystem::Words() const {
  std::vector<std::string> words = FillPlaceholders(command_.command, dataset_->sensors(), dataset_->output(), seed_);
  if (command_.interface == CommandInterface::kVslamlab) {
    words = AddVslamlabArguments(words, dataset_->sensors(), dataset_->answers(), command_.mode);
  }
  if (!WhyNoSandbox().empty()) return words;
  SandboxView view{readable_, {dataset_->answers()}, dataset_->answers()};
  view.readable.push_back(dataset_->sensors());
  return Sandboxed(words, view);
}

std::vector<FrameEstimate> CommandSystem::Run() {
  std::optional<Ending> ending;
  {
    Subprocess program(Words(), SubprocessStreams{.log = dataset_->log(),
                                                  .folder = dataset_->answers(),
                                                  .max_file_bytes = kMaxForeignFile_bytes,
                                                  .max_memory_mb = ForeignMemory_mb(command_.memory_mb),
                                                  .max_processes = kMaxForeignProcesses,
                                                  .max_folder_bytes = kMaxForeignFolder_bytes,
                                                  .max_folder_files = kMaxForeignFiles});
    ending = program.Wait(command_.time_limit_s);
  }
  std::error_code ignored;
  fs::copy_file(dataset_->log(), log_, fs::copy_options::overwrite_existing, ignored);
  const std::string said = LastLine(dataset_->log());
  if (!ending) {
    failure_ = fmt::format("did not end within {:g} s", command_.time_limit_s);
  } else if (!ending->ok()) {
    failure_ = EndingIn(*ending).ToText() + (said.empty() ? "" : ": " + said);
  } else {
    ReadAnswer();
  }
  return frames_;
}

void CommandSystem::ReadAnswer() {
  const bool key_frames = command_.interface == CommandInterface::kVslamlab;
  if (!key_frames && !IsItsOwnFile(dataset_->output())) {
    failure_ = "wrote no trajectory to {output}";
    return;
  }
  try {
    if (key_frames) {
      const TrajectoryFile keyframes = ReadKeyFrames(dataset_->answers());
      remarks_ = keyframes.remarks;
      CheckDistances(keyframes.trajectory);
      PlaceByStamp(keyframes.trajectory, HalfInterval(frames_), frames_);
      return;
    }
    TrajectoryFile written = ReadTrajectory(dataset_->output(), command_.format, {}, StampOrder::kRepaired);
    for (std::string& remark : written.remarks) Replace(remark, dataset_->output().string(), "{output}");
    remarks_ = std::move(written.remarks);
    CheckDistances(written.trajectory);
    if (command_.format == TrajectoryFormat::kKitti) {
      failure_ = PlaceByRow(written.trajectory, frames_);
    } else {
      PlaceByStamp(written.trajectory, HalfInterval(frames_), frames_);
    }
  } catch (const BadInput& e) {
    failure_ = std::string("wrote a malformed trajectory: ") + e.what();
    Replace(failure_, dataset_->output().string(), "{output}");
  }
}

std::vector<std::string> AddVslamlabArguments(std::vector<std::string> words, const fs::path& sequence,
                                              const fs::path& output, VslamlabMode mode) {
  const bool python = std::any_of(words.begin(), words.end(), [](const std::string& word) {
    return word.ends_with(".py") || fs::path(word).filename().string().starts_with("python");
  });
  const std::pair<std::string, std::string> arguments[] = {
      {"sequence_path", sequence.string()},
      {"calibration_yaml", (sequence / "calibration.yaml").string()},
      {"rgb_csv", (sequence / "rgb.csv").string()},
      {"exp_folder", output.string()},
      {"exp_id", "00000"},
      {"mode", std::string(ToWord(mode))}};
  for (const auto& [key, value] : arguments) {
    const std::string start = python ? "--" + key : key + ":";
    const auto says = [&](const std::string& word) { return word.starts_with(start); };
    if (std::any_of(words.begin(), words.end(), says)) continue;
    if (python) {
      words.insert(words.end(), {start, value});
    } else {
      words.push_back(start + value);
    }
  }
  return words;
}

namespace {

fs::path FindKeyFrames(const fs::path& output) {
  std::vector<fs::path> found;
  std::error_code ended;
  fs::recursive_directory_iterator entry(output, fs::directory_options::skip_permission_denied, ended);
  for (; !ended && entry != fs::recursive_directory_iterator(); entry.increment(ended)) {
    const bool is_named = entry->path().filename().string().find("KeyFrameTrajectory") != std::string::npos;
    if (is_named && IsItsOwnFile(entry->path())) found.push_back(entry->path());
  }
  if (found.size() == 1) return found.front();
  throw BadInput(fmt::format("{} files named ...KeyFrameTrajectory... in its exp_folder; expected one", found.size()));
}

/// The eight numbers of a row; none if it does not begin with one.
std::vector<double> RowNumbers(std::string row, std::string& stamp) {
  std::replace(row.begin(), row.end(), ',', ' ');
  std::istringstream fields(row);
  std::vector<double> numbers;
  stamp.clear();
  for (std::string field; fields >> field;) {
    char* end = nullptr;
    const double number = std::strtod(field.c_str(), &end);
    if (*end != 0) return numbers.empty() ? std::vector<double>() : std::vector<double>{0};
    if (numbers.empty()) stamp = field;
    numbers.push_back(number);
  }
  return numbers;
}

/// Whether it is a time that StampOf can tell: in seconds until the year 2255, in nanoseconds from 1970 on.
bool IsStamp(double number) {
  constexpr double kMaxSeconds = 9e9, kMinNanoseconds = 1e14, kMaxNanoseconds = 9e18;
  return std::abs(number) < kMaxSeconds || (number >= kMinNanoseconds && number < kMaxNanoseconds);
}

/// Of "1700000000.02" in seconds, or "1700000000020000000": whole numbers that long are nanoseconds.
int64_t StampOf(const std::string& text) {
  constexpr double kMinNanoseconds = 1e14;
  const double number = std::strtod(text.c_str(), nullptr);
  if (number >= kMinNanoseconds) return std::strtoll(text.c_str(), nullptr, 10);
  const int64_t seconds = int64_t(std::floor(number));
  const size_t dot = text.find('.');
  if (dot == std::string::npos || text.find_first_of("eE") != std::string::npos)
    return int64_t(std::llround(number * 1e9));
  std::string digits = text.substr(dot + 1, 9);
  digits.resize(9, '0');
  return seconds * 1000000000 + std::strtoll(digits.c_str(), nullptr, 10);
}

}  // namespace

TrajectoryFile ReadKeyFrames(const fs::path& output) {
  const fs::path file = FindKeyFrames(output);
  std::istringstream stream(FileContent(file));
  TrajectoryFile result;
  int line = 0;
  std::string stamp;
  for (std::string row; std::getline(stream, row);) {
    ++line;
    const std::vector<double> v = RowNumbers(row, stamp);
    if (v.empty()) continue;
    const bool is_pose =
        v.size() == 8 && IsStamp(v[0]) && std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
    const Eigen::Quaterniond q = is_pose ? Eigen::Quaterniond(v[7], v[4], v[5], v[6]) : Eigen::Quaterniond(0, 0, 0, 0);
    if (!(std::abs(q.norm() - 1) < 1e-2)) {
      throw BadInput(fmt::format("{}:{}: expected t x y z qx qy qz qw", file.filename().string(), line));
    }
    result.trajectory.push_back({StampOf(stamp), Pose(q.normalized(), {v[1], v[2], v[3]})});
  }
  result.remarks = RepairStamps(file.filename().string(), result.trajectory);
  return result;
}

}  // namespace gaitcam
