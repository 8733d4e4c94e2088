#include <fmt/format.h>

#include "algorithms/core/errors.h"
#include "algorithms/io/dataset_reader.h"
#include "algorithms/io/trajectory_file.h"
#include "models/yaml_fields.h"
#include "results/score.h"
#include "scenarios/commands/commands.h"
#include "scenarios/runs/interrupt.h"
#include "scenarios/runs/progress.h"
#include "scenarios/runs/tracking_thread.h"
#include "scenarios/scenario.h"

namespace gaitcam {
namespace {

SystemSettings SettingsOf(const std::vector<std::string>& assignments) {
  YamlNode node = YamlNode::FromText("", "settings");
  for (const std::string& assignment : assignments) node.Set(assignment);
  SystemSettings settings;
  ReadYaml(node, settings, "");
  return settings;
}

/// What score says of the estimate, if the truth lies beside the dataset; else nothing.
std::optional<Scores> ScoreAgainstTruthBeside(const Estimate& estimate, const std::filesystem::path& sensors) {
  const std::filesystem::path truth = sensors.string() + "-truth/groundtruth.txt";
  if (!std::filesystem::exists(truth)) return std::nullopt;
  std::vector<int64_t> stamps;
  for (const FrameEstimate& frame : estimate.frames) stamps.push_back(frame.stamp_ns);
  return ScoreEstimate(estimate, ReadTrajectory(truth).trajectory, stamps, {});
}

}  // namespace

int TrackCommand(const TrackArguments& arguments, const CommonOptions& common) {
  const std::filesystem::path sensors = FindDataset(arguments.dataset);
  DatasetReader reader(sensors);
  const InterruptGuard guard;
  TrackingThread tracker(
      MakeSystem(arguments.system, {reader.calibration(), arguments.seed, SettingsOf(arguments.sets)}));
  Progress progress("tracking " + sensors.filename().string(), reader.frames(), common.quiet);
  int64_t frames = 0;
  while (!guard.Interrupted()) {
    std::optional<Observation> observation = reader.Next();
    if (!observation) break;
    tracker.Push(std::move(*observation));
    progress.Update(++frames);
  }
  const Estimate estimate = tracker.Finish();
  progress.Finish();
  const std::filesystem::path out =
      arguments.out.empty() ? std::filesystem::path("estimate-" + arguments.system + ".txt") : arguments.out;
  WriteTrajectory(out, estimate.ToTrajectory(), TrajectoryFormat::kTum);
  if (guard.Interrupted()) {
    fmt::print(stderr, "gaitcam: interrupted after {} of {} frames; their estimate: {}\n", frames, reader.frames(),
               out.string());
    return 130;
  }
  const std::optional<Scores> scores = ScoreAgainstTruthBeside(estimate, sensors);
  if (common.json) {
    fmt::print("{}", scores ? ScoresToJson(*scores) : "{}\n");
  } else if (!common.quiet) {
    if (scores) fmt::print("{}\n", ScoresToTable(*scores));
    fmt::print("estimate: {} ({} of {} frames have a pose)\n", out.string(), estimate.ToTrajectory().size(), frames);
  }
  return 0;
}

}  // namespace gaitcam
