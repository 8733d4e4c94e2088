#include "scenarios/recorder.h"

#include <fmt/format.h>

#include "scenarios/output_folder.h"
#include "scenarios/progress.h"

namespace gaitcam {
namespace {

FrameTruthRecord RecordOf(const FrameTruth& truth) {
  FrameTruthRecord record;
  record.X_WC = truth.camera.X_WC;
  record.X_WC_open = truth.camera.X_WC_open;
  record.X_WC_close = truth.camera.X_WC_close;
  record.X_WI = truth.X_WI;
  record.X_WB = truth.X_WB;
  for (const Subframe& s : truth.camera.subframes) record.subposes.push_back({s.stamp_ns, s.weight, s.X_WC});
  record.sharp = truth.camera.sharp;
  record.depth = truth.camera.depth;
  record.blur = truth.camera.blur;
  record.blur_median_px = truth.camera.blur_median_px;
  record.blur_p90_px = truth.camera.blur_p90_px;
  record.blur_max_px = truth.camera.blur_max_px;
  record.step = truth.gait.step;
  record.step_phase = truth.gait.phase;
  record.left_contact = truth.left_contact;
  record.right_contact = truth.right_contact;
  return record;
}

}  // namespace

RecordOutcome RecordScenario(const ResolvedScenario& resolved, const DatasetWriterOptions& format,
                             const RunOptions& options) {
  const Scenario& scenario = resolved.scenario;
  const DatasetFolders folders = DatasetFolders::In(options.out, scenario.name);
  Simulation simulation(resolved.robot, resolved.place, SimulationOptionsOf(scenario), scenario.seed);
  DatasetWriter writer(folders, simulation.calibration(), format);
  Progress progress("recording " + scenario.name, simulation.ExpectedFrames(), options.quiet);
  while (!options.interrupted()) {
    const std::optional<SimulatedFrame> frame = simulation.Next();
    if (!frame) break;
    writer.Add(frame->observation, RecordOf(frame->truth));
    progress.Update(writer.frames());
  }
  progress.Finish();
  RecordOutcome outcome{folders, StatusText(EndOf(simulation)), simulation.end_time_s(), writer.frames()};
  writer.Finish(fmt::format("{} at {:.3f} s", outcome.status, outcome.end_time_s));
  WriteTextFile(folders.truth / "scenario.yaml", resolved.ToYaml());
  return outcome;
}

}  // namespace gaitcam
