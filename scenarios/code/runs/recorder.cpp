#include "scenarios/code/runs/recorder.h"

#include <fmt/format.h>

#include "algorithms/core/errors.h"
#include "algorithms/io/calibration_file.h"
#include "algorithms/io/whole_file.h"
#include "scenarios/code/runs/calibration_error.h"
#include "scenarios/code/runs/filmed_walk.h"
#include "scenarios/code/runs/progress.h"

namespace gaitcam {
namespace {

/// What the recording was made from.
/// @param truth null: the calibration that the sensors' folder has is the true one
void WriteRecipe(const ResolvedScenario& resolved, const Calibration* truth, const DatasetFolders& folders,
                 DatasetWriter& writer) {
  writer.AddToTruth("scenario.yaml", resolved.ToYaml());
  if (!truth) return;
  writer.AddToTruth(TrueCalibrationFileOf(folders).filename().string(), CalibrationText(*truth));
  std::string drawn;
  for (const auto& [name, value] : CalibrationErrorFacts(resolved)) drawn += name + ": " + value + "\n";
  writer.AddToTruth("calibration_error.yaml", drawn);
}

}  // namespace

void RemoveRecording(const DatasetFolders& folders) {
  std::error_code ignored;
  std::filesystem::remove_all(folders.sensors, ignored);
  std::filesystem::remove_all(folders.truth, ignored);
}

RecordOutcome RecordScenario(const ResolvedScenario& resolved, const DatasetFolders& folders,
                             const RecordOptions& options) {
  const Scenario& scenario = resolved.scenario;
  if (scenario.localisation)
    throw BadInput(scenario.name + ": `localisation` has no walk to record; it is done by `gaitcam run` alone");
  Simulation simulation(resolved.robot, resolved.scene, SimulationOptionsOf(resolved), scenario.seed);
  const CalibrationError error = DrawCalibrationError(scenario.calibration_error, resolved.robot, scenario.seed);
  const bool errs = !SaysNothing(scenario.calibration_error);
  const double odometry_hz = simulation.calibration().odometry.rate_hz;
  MiscalibratedSensors sensors(error, resolved.robot, scenario.seed, odometry_hz);
  DatasetWriter writer(folders, Miscalibrated(simulation.calibration(), error), options.format);
  const int64_t expected = simulation.ExpectedFrames();
  Progress bar("recording " + scenario.name, expected, options.quiet || options.progress);
  const TruthOptions wanted{options.truth_images, options.truth_images, options.truth_images};
  FilmedWalk walk(simulation, [&](int64_t) { return wanted; });
  while (std::optional<SimulatedFrame> frame = walk.Next(!options.interrupted())) {
    if (errs) sensors.Apply(frame->observation);
    writer.Add(frame->observation, frame->truth);
    bar.Update(writer.frames());
    if (options.progress) options.progress(writer.frames(), expected);
  }
  bar.Finish();
  RecordOutcome outcome;
  outcome.folders = folders;
  outcome.status = StatusText(EndOf(simulation));
  outcome.end_time_s = simulation.end_time_s();
  outcome.distance_m = simulation.distance_m();
  outcome.frames = writer.frames();
  outcome.renderer = simulation.gl().info();
  WriteRecipe(resolved, errs ? &simulation.calibration() : nullptr, folders, writer);
  writer.Finish(fmt::format("{} at {:.3f} s", outcome.status, outcome.end_time_s));
  return outcome;
}

}  // namespace gaitcam
