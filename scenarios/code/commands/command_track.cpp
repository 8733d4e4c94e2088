#include <fmt/format.h>

#include "algorithms/core/errors.h"
#include "algorithms/io/covariance_file.h"
#include "algorithms/io/dataset_reader.h"
#include "algorithms/io/trajectory_file.h"
#include "algorithms/io/whole_file.h"
#include "results/scoring/score_text.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/commands/summary.h"
#include "scenarios/code/files/system_needs.h"
#include "scenarios/code/runs/interrupt.h"
#include "scenarios/code/runs/progress.h"
#include "scenarios/code/runs/run_scores.h"
#include "scenarios/code/runs/tracking.h"
#include "scenarios/code/systems/chosen_system.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

void PrintOutcome(const TrackArguments& arguments, const Estimate& estimate, const std::optional<Scores>& scores,
                  const fs::path& out, const std::string& system) {
  if (scores) {
    fmt::print("{}\n", SummaryText(*scores, {}, arguments.all));
  } else {
    for (const std::string& remark : estimate.remarks) fmt::print("note: {}\n", remark);
  }
  fmt::print("estimate: {} ({} of {} frames have a pose)\n", out.string(), estimate.ToTrajectory().size(),
             estimate.frames.size());
  if (!estimate.failure.empty()) fmt::print("\n{} FAILED: {}\n", system, estimate.failure);
}

}  // namespace

int TrackCommand(const TrackArguments& arguments, const CommonOptions& common) {
  const fs::path sensors = FindDataset(arguments.dataset);
  const SystemChoice choice = ParseSystemChoice(arguments.system, arguments.sets);
  DatasetReader reader(sensors);
  if (const auto lack = LackInDataset(InfoOf(choice), reader.calibration(), sensors)) throw BadInput(*lack);
  const fs::path out = arguments.out.empty() ? fs::path("estimate-" + choice.name + ".txt") : arguments.out;
  if (const std::string sandbox = SandboxOf(choice); sandbox.starts_with("none")) {
    fmt::print(stderr, "gaitcam: sandbox of {}: {}; it could read the truth\n", choice.name, sandbox);
  }
  CheckWritable(out);
  const InterruptGuard guard;
  TrackingThread tracker(
      MakeSystem(choice, {reader.calibration(), arguments.seed, choice.settings}, fs::absolute(out).parent_path()));
  Progress progress("tracking " + sensors.filename().string(), reader.frames(), common.quiet);
  const Estimate estimate = TrackRecorded(
      reader, tracker, [&] { return guard.Interrupted(); }, [&](int64_t frames) { progress.Update(frames); });
  progress.Finish();
  WriteTrajectory(out, estimate.ToTrajectory(), TrajectoryFormat::kTum);
  WriteCovariances(CovarianceFileOf(out), estimate.frames);
  if (guard.Interrupted()) {
    fmt::print(stderr, "gaitcam: interrupted after {} of {} frames; their estimate: {}\n", estimate.frames.size(),
               reader.frames(), out.string());
    return 130;
  }
  std::optional<Scores> scores;
  if (HasTruthBeside(sensors)) scores = ScoreAgainstTruthBeside(estimate, sensors, choice.name);
  if (common.json) {
    fmt::print("{}", scores ? ScoresToJson(*scores) : "{}\n");
  } else if (!common.quiet) {
    PrintOutcome(arguments, estimate, scores, out, choice.name);
  }
  return 0;
}

}  // namespace gaitcam
