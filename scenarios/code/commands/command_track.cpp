#include <fmt/format.h>

#include "algorithms/core/errors.h"
#include "algorithms/io/covariance_file.h"
#include "algorithms/io/dataset_reader.h"
#include "algorithms/io/trajectory_file.h"
#include "models/code/yaml/yaml_reader.h"
#include "results/scoring/score.h"
#include "results/scoring/score_text.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/commands/summary.h"
#include "scenarios/code/files/scenario.h"
#include "scenarios/code/files/system_needs.h"
#include "scenarios/code/runs/interrupt.h"
#include "scenarios/code/runs/progress.h"
#include "scenarios/code/runs/tracking_thread.h"

namespace gaitcam {
namespace {

SystemSettings SettingsOf(const std::vector<std::string>& assignments) {
  OptionValue node = ParseYaml("", "settings");
  for (const std::string& assignment : assignments) SetOption(node, assignment);
  return ReadSettings(node);
}

/// Scores the estimate if the truth lies beside the dataset; else nothing.
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
  if (const auto lack = LackInDataset(InfoOfSystem(arguments.system), reader.calibration(), sensors))
    throw BadInput(*lack);
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
  WriteCovariances(CovarianceFileOf(out), estimate.frames);
  if (guard.Interrupted()) {
    fmt::print(stderr, "gaitcam: interrupted after {} of {} frames; their estimate: {}\n", frames, reader.frames(),
               out.string());
    return 130;
  }
  const std::optional<Scores> scores = ScoreAgainstTruthBeside(estimate, sensors);
  if (common.json) {
    fmt::print("{}", scores ? ScoresToJson(*scores) : "{}\n");
  } else if (!common.quiet) {
    if (scores) fmt::print("{}\n", SummaryText(*scores, {}, arguments.all));
    fmt::print("estimate: {} ({} of {} frames have a pose)\n", out.string(), estimate.ToTrajectory().size(), frames);
    if (!estimate.failure.empty()) fmt::print("\n{} FAILED: {}\n", arguments.system, estimate.failure);
  }
  return 0;
}

}  // namespace gaitcam
