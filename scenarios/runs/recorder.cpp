#include "scenarios/runs/recorder.h"

#include <fmt/format.h>

#include "algorithms/core/errors.h"
#include "scenarios/runs/output_folder.h"
#include "scenarios/runs/progress.h"

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

RecordOutcome RecordScenario(const ResolvedScenario& resolved, const DatasetFolders& folders,
                             const RecordOptions& options) {
  const Scenario& scenario = resolved.scenario;
  if (scenario.localisation)
    throw BadInput(scenario.name + ": `localisation` has no walk to record; it is done by `gaitcam run` alone");
  Simulation simulation(resolved.robot, resolved.place, SimulationOptionsOf(scenario), scenario.seed);
  DatasetWriter writer(folders, simulation.calibration(), options.format);
  const int64_t expected = simulation.ExpectedFrames();
  Progress bar("recording " + scenario.name, expected, options.quiet || options.progress);
  const TruthOptions wanted{options.truth_images, options.truth_images,
                            true};  // the blur's numbers come from its vectors
  while (!options.interrupted()) {
    const std::optional<SimulatedFrame> frame = simulation.Next(wanted);
    if (!frame) break;
    FrameTruthRecord truth = RecordOf(frame->truth);
    if (!options.truth_images) truth.sharp = truth.depth = truth.blur = cv::Mat();
    writer.Add(frame->observation, truth);
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
  outcome.renderer = simulation.gl().renderer();
  outcome.software_renderer = simulation.gl().is_software();
  writer.Finish(fmt::format("{} at {:.3f} s", outcome.status, outcome.end_time_s));
  WriteTextFile(folders.truth / "scenario.yaml", resolved.ToYaml());
  return outcome;
}

}  // namespace gaitcam
