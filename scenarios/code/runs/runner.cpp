#include "scenarios/code/runs/runner.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <queue>

#include "algorithms/core/clock.h"
#include "algorithms/core/errors.h"
#include "algorithms/io/covariance_file.h"
#include "algorithms/io/trajectory_file.h"
#include "results/reports/video.h"
#include "results/scoring/score_text.h"
#include "results/scoring/statistics.h"
#include "scenarios/code/files/versions.h"
#include "scenarios/code/runs/calibration_error.h"
#include "scenarios/code/runs/output_folder.h"
#include "scenarios/code/runs/place_views.h"
#include "scenarios/code/runs/progress.h"
#include "scenarios/code/runs/renderer_record.h"
#include "scenarios/code/runs/run_log.h"
#include "scenarios/code/runs/run_scores.h"
#include "scenarios/code/runs/tracked_system.h"
#include "scenarios/code/runs/tracking.h"
#include "scenarios/code/systems/chosen_system.h"

namespace gaitcam {
namespace {

/// The report's film: a frame of it whenever the simulated time has come round to it.
class Film {
 public:
  Film(const ReportFilmOptions& options, const std::filesystem::path& file) : options_(options) {
    if (options.enabled) writer_.emplace(file, VideoOptions{options.rate_hz, options.height_px});
  }

  /// Sees the robot from beside, if the frame just filmed is one for the film.
  void Look(int64_t stamp_ns, Simulation& simulation) {
    if (!writer_ || SecondsIntoWalk(stamp_ns) * options_.rate_hz < double(looks_)) return;
    const int height = options_.height_px, width = height * 4 / 3 / 2 * 2;
    bystander_.push({stamp_ns, simulation.ThirdPersonView(width, height)});
    ++looks_;
  }

  void Add(const SimulatedFrame& frame) {
    if (bystander_.empty() || bystander_.front().stamp_ns != frame.truth.stamp_ns) return;
    VideoFrame picture;
    picture.camera = frame.observation.image.pixels;
    picture.bystander = bystander_.front().pixels;
    bystander_.pop();
    picture.time_s = SecondsIntoWalk(frame.truth.stamp_ns);
    picture.exposure_ms = frame.observation.exposure_ms;
    picture.status = fmt::format("blur {:.1f} px", frame.truth.blur_median_px);
    writer_->Add(picture);
    if (poster_.empty()) poster_ = ComposeVideoFrame(picture, options_.height_px);
  }

  /// @returns the film's first picture; empty if there is no film.
  cv::Mat Finish() {
    if (writer_) writer_->Finish();
    return poster_;
  }

 private:
  ReportFilmOptions options_;
  std::optional<VideoWriter> writer_;
  int64_t looks_ = 0;
  std::queue<Image> bystander_;  ///< Of frames that are not developed yet.
  cv::Mat poster_;
};

std::string Subtitle(const ResolvedScenario& resolved) {
  const Scenario& s = resolved.scenario;
  const std::string gait = resolved.robot.kind == Robot::Kind::kHumanoid ? s.gait.preset + " gait, " : "";
  const std::string exposure =
      s.camera.ExposesItself() ? "auto exposure" : fmt::format("{:g} ms exposure", s.camera.exposure.exposure_ms);
  return fmt::format("{} in {}, {} path, {}, {}{} x {} px at {:g} Hz, {}, {}", resolved.robot.name, resolved.scene.name,
                     ToWord(s.path.kind), SteeringText(resolved), gait, s.camera.width_px, s.camera.height_px,
                     s.camera.rate_hz, exposure, s.system.name);
}

/// Over the frames' medians.
std::vector<Score> BlurScores(const std::vector<ReportFrame>& frames) {
  std::vector<double> blur_px;
  for (const ReportFrame& frame : frames) blur_px.push_back(frame.blur_median_px);
  if (blur_px.empty()) return {};
  return {{"blur_median_px", QuantileOf(blur_px, 0.5), "px", "motion blur of a frame, median over the walk"},
          {"blur_p95_px", QuantileOf(blur_px, 0.95), "px", "motion blur of a frame, 95th percentile over the walk"}};
}

/// scores.json says how the run ended beside what the scores are: a fall is never silent.
std::string ScoresFile(const ReportInput& report, const Estimate& estimate, const Simulation& simulation,
                       const ResolvedScenario& resolved) {
  const Scores* scores = report.scores;
  nlohmann::ordered_json json =
      scores ? nlohmann::ordered_json::parse(ScoresToJson(*scores)) : nlohmann::ordered_json();
  nlohmann::ordered_json run;
  run["status"] = StatusText(report.end);
  run["end_time_s"] = report.end_time_s;
  run["frames"] = report.frames.size();
  run["distance_m"] = simulation.distance_m();
  run["seed"] = resolved.scenario.seed;
  run["steered_by"] = std::string(ToWord(SteeredBy(resolved)));
  WriteRenderer(simulation.gl().info(), run);
  WriteDrawn(resolved, run);
  if (!estimate.failure.empty()) run["system_failed"] = estimate.failure;
  if (!scores) run["not_scored"] = report.no_scores_reason;
  json["run"] = run;
  return json.dump(2) + "\n";
}

}  // namespace

std::string StatusText(RunEnd end) {
  switch (end) {
    case RunEnd::kFinished: return "finished";
    case RunEnd::kFell: return "fell";
    case RunEnd::kInterrupted: return "interrupted";
  }
  GAITCAM_ASSERT(false);
  return {};
}

RunEnd EndOf(const Simulation& simulation) {
  switch (simulation.status()) {
    case SimulationStatus::kWalking: return RunEnd::kInterrupted;
    case SimulationStatus::kFinished: return RunEnd::kFinished;
    case SimulationStatus::kFell: return RunEnd::kFell;
  }
  GAITCAM_ASSERT(false);
  return {};
}

PathFeedback SteeredBy(const ResolvedScenario& resolved) {
  const bool drives = resolved.robot.kind == Robot::Kind::kOmniBase;
  return drives ? PathFeedback::kTruth : resolved.scenario.path.feedback;
}

std::string SteeringText(const ResolvedScenario& resolved) {
  const std::string until = ActsOnBody(resolved.scenario) ? " until its system commands otherwise" : "";
  switch (SteeredBy(resolved)) {
    case PathFeedback::kTruth: return "steered by its true pose" + until;
    case PathFeedback::kOdometry: return "steered by its own odometry" + until;
    case PathFeedback::kNone: return "not steered" + until;
  }
  GAITCAM_ASSERT(false);
  return {};
}

SimulationOptions SimulationOptionsOf(const ResolvedScenario& resolved) {
  const Scenario& scenario = resolved.scenario;
  SimulationOptions options;
  options.gait = scenario.gait.options;
  options.path = scenario.path;
  options.physics = Varied(scenario.physics, scenario.variation);
  options.drive = scenario.drive;
  options.camera = scenario.camera;
  options.sensors = scenario.sensors;
  options.scan = scenario.scan.value_or(HeadScanOptions());
  options.duration_s = scenario.duration_s;
  options.start = resolved.start;
  options.kidnap = scenario.kidnap;
  if (ActsOnBody(scenario)) options.crowd = resolved.crowd;
  return options;
}

void CheckPlan(const ResolvedScenario& resolved) {
  if (resolved.scenario.localisation) {
    CheckPlaceViews(resolved);
    return;
  }
  const SimulationOptions options = SimulationOptionsOf(resolved);
  CheckSimulation(resolved.robot, resolved.scene, options, resolved.scenario.seed);
  // What somebody else's system will ask for is known when it asks.
  const bool may_scan = ActsOnBody(resolved.scenario) && !resolved.scenario.system.IsForeign();
  if (may_scan) CheckHeadScan(resolved.robot, options);
}

/// The whole data flow: models ▸ simulation ▸ observations ▸ system ▸ estimate ▸ scores ▸ report.
RunOutcome RunScenario(const ResolvedScenario& resolved, const RunOptions& options) {
  const Scenario& scenario = resolved.scenario;
  OutputFolder folder(options.out, "scores.json");
  Simulation simulation(resolved.robot, resolved.scene, SimulationOptionsOf(resolved), scenario.seed);
  TrackingThread tracker(MakeTrackedSystem(resolved, simulation.calibration(), folder.path()), ActsOnBody(scenario));
  Film film(scenario.video, folder.path() / "walk.mp4");
  RunLog log;
  Progress progress(scenario.name, simulation.ExpectedFrames(), options.quiet);
  LiveTrackingOptions live{options.interrupted, [&](int64_t frame) { return log.WantedTruth(frame); }};
  live.on_filmed = [&](int64_t stamp_ns) { film.Look(stamp_ns, simulation); };
  live.on_frame = [&](const SimulatedFrame& frame) {
    log.Add(frame);
    film.Add(frame);
    progress.Update(int64_t(log.frames()), simulation.ExpectedFrames());  // scans make the walk longer
  };
  const Estimate estimate = TrackLive(simulation, tracker, live);
  progress.Finish();

  const RunScores run = ScoreRun(estimate, log.truth(), log.stamps(), resolved, WhereWalk(simulation.world().people()));
  ReportInput report;
  report.scores = run.scores ? &*run.scores : nullptr;
  report.no_scores_reason = run.not_scored;
  for (const MapResult& map : run.maps) report.sections.push_back(map.section());
  if (!estimate.failure.empty()) report.no_scores_reason = scenario.system.name + " failed: " + estimate.failure;
  report.title = scenario.name;
  report.subtitle = Subtitle(resolved);
  report.end = EndOf(simulation);
  report.end_time_s = simulation.end_time_s();
  report.renderer = simulation.gl().info().ToText();
  report.software_renderer = simulation.gl().info().is_software;
  report.truth = log.truth();
  report.frames = log.ReportFrames(estimate);
  report.twins = log.Twins();
  report.video_poster = film.Finish();
  report.video_file = report.video_poster.empty() ? "" : "walk.mp4";
  report.resolved_scenario = resolved.ToYaml();
  report.facts = RunFacts(scenario.seed);
  for (const auto& [name, value] : VariationFacts(resolved))
    report.facts.emplace_back("variation drawn: " + name, value);
  for (const auto& [name, value] : CalibrationErrorFacts(resolved))
    report.facts.emplace_back("calibration error drawn: " + name, value);
  if (const std::string sandbox = SandboxOf(scenario.system); !sandbox.empty()) {
    report.facts.emplace_back("sandbox of the system", sandbox);
  }

  WriteTrajectory(folder.path() / "estimate.txt", estimate.ToTrajectory(), TrajectoryFormat::kTum);
  if (!estimate.live.empty()) {
    WriteTrajectory(folder.path() / "live.txt", PosesOf(estimate.live), TrajectoryFormat::kTum);
  }
  WriteCovariances(folder.path() / "covariances.csv", estimate.frames);
  WriteTrajectory(folder.path() / "truth.txt", log.truth(), TrajectoryFormat::kTum);
  folder.WriteText("frames.csv", log.ToCsv(estimate));
  folder.WriteText("scenario.yaml", report.resolved_scenario);
  folder.WriteText("scores.json", ScoresFile(report, estimate, simulation, resolved));
  WriteMaps(run, folder.path());
  WriteReport(folder.path() / "report.html", report);
  folder.Commit();
  return {options.out,      StatusText(report.end),   report.end_time_s, run.scores, report.no_scores_reason,
          estimate.failure, BlurScores(report.frames)};
}

}  // namespace gaitcam
