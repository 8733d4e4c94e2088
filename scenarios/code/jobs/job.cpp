#include "scenarios/code/jobs/job.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/core/median.h"
#include "algorithms/io/checksum.h"
#include "algorithms/io/covariance_file.h"
#include "algorithms/io/dataset_reader.h"
#include "algorithms/io/trajectory_file.h"
#include "results/scoring/score_text.h"
#include "scenarios/code/files/versions.h"
#include "scenarios/code/runs/calibration_error.h"
#include "scenarios/code/runs/output_folder.h"
#include "scenarios/code/runs/renderer_record.h"
#include "scenarios/code/runs/run_scores.h"
#include "scenarios/code/runs/runner.h"
#include "scenarios/code/runs/tracked_system.h"
#include "scenarios/code/runs/tracking.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr const char* kSchema = "gaitcam.job.1";

nlohmann::ordered_json ToJson(const JobRecord& record, const ResolvedScenario& resolved) {
  nlohmann::ordered_json json{{"schema", kSchema},
                              {"hash", record.hash},
                              {"program", ProgramsFingerprint(resolved.scenario)},
                              {"status", record.status},
                              {"failure", record.failure},
                              {"not_scored", record.not_scored},
                              {"frames", record.frames},
                              {"end_time_s", record.end_time_s},
                              {"blur_median_px", record.blur_median_px}};
  WriteRenderer(record.renderer, json);
  json["steered_by"] = std::string(ToWord(SteeredBy(resolved)));
  WriteDrawn(resolved, json);
  for (const auto& [name, value] : record.scores) json["scores"][name] = value;  // NaN becomes null
  for (const auto& [name, value] : record.timing) json["timing"][name] = value;
  return json;
}

std::map<std::string, double> NumbersOf(const nlohmann::json& json, const char* key) {
  std::map<std::string, double> numbers;
  if (!json.contains(key)) return numbers;
  for (const auto& [name, value] : json.at(key).items()) numbers[name] = value.is_null() ? NAN : value.get<double>();
  return numbers;
}

JobRecord FromJson(const nlohmann::json& json) {
  JobRecord record;
  record.hash = json.at("hash");
  record.status = json.at("status");
  record.failure = json.at("failure");
  record.not_scored = json.at("not_scored");
  record.frames = json.at("frames");
  record.end_time_s = json.at("end_time_s");
  record.blur_median_px = json.at("blur_median_px");
  record.renderer = ReadRenderer(json);
  record.scores = NumbersOf(json, "scores");
  record.timing = NumbersOf(json, "timing");
  return record;
}

/// A tracked walk: estimate and truth to be scored, and how the walk ended.
struct TrackedWalk {
  Estimate estimate;
  Trajectory truth;
  std::vector<int64_t> stamps;
  std::vector<double> blur_px;  ///< Median over the image, per frame.
  PeopleAt people;
  std::string status;
  double end_time_s = 0;
  RendererInfo renderer;
};

/// Frames from the cache. @returns nothing if interrupted.
std::optional<TrackedWalk> TrackCached(const ResolvedScenario& resolved, const fs::path& folder,
                                       const JobOptions& options) {
  const std::optional<CachedSequence> sequence =
      SequenceCache(options.cache).Get(resolved, options.quiet, options.interrupted);
  if (!sequence) return std::nullopt;
  TrackedWalk walk;
  DatasetReader reader(sequence->folders.sensors);
  TrackingThread tracker(MakeTrackedSystem(resolved, reader.calibration(), folder));
  walk.estimate = TrackRecorded(reader, tracker, options.interrupted);
  if (options.interrupted()) return std::nullopt;
  walk.truth = sequence->Truth();
  for (const FrameTruth& frame : sequence->ReadFrames()) {
    walk.stamps.push_back(frame.stamp_ns);
    walk.blur_px.push_back(frame.blur_median_px);
  }
  walk.status = sequence->status;
  walk.end_time_s = sequence->end_time_s;
  walk.renderer = sequence->renderer;
  const std::vector<PersonOptions>& people = resolved.scene.people;
  walk.people = WhereWalk(std::make_shared<const std::vector<PersonWalk>>(people.begin(), people.end()));
  return walk;
}

/// A live walk, for a system that acts on the body. @returns nothing if interrupted.
std::optional<TrackedWalk> TrackItsOwn(const ResolvedScenario& resolved, const fs::path& folder,
                                       const JobOptions& options) {
  const Scenario& scenario = resolved.scenario;
  Simulation simulation(resolved.robot, resolved.scene, SimulationOptionsOf(resolved), scenario.seed);
  TrackingThread tracker(MakeTrackedSystem(resolved, simulation.calibration(), folder), true);
  TrackedWalk walk;
  LiveTrackingOptions live{options.interrupted, [](int64_t) { return TruthOptions{false, false, false}; }};
  live.on_frame = [&](const SimulatedFrame& frame) {
    walk.truth.push_back({frame.truth.stamp_ns, frame.truth.X_WC});
    walk.stamps.push_back(frame.truth.stamp_ns);
    walk.blur_px.push_back(frame.truth.blur_median_px);
  };
  walk.estimate = TrackLive(simulation, tracker, live);
  if (simulation.status() == SimulationStatus::kWalking) return std::nullopt;
  walk.status = StatusText(EndOf(simulation));
  walk.end_time_s = simulation.end_time_s();
  walk.people = WhereWalk(simulation.world().people());
  walk.renderer = simulation.gl().info();
  return walk;
}

/// Scores the walk into the record, or records why it cannot be scored.
std::optional<Scores> ScoreInto(const TrackedWalk& walk, const ResolvedScenario& resolved, JobRecord& record) {
  if (!walk.blur_px.empty()) record.blur_median_px = UpperMedian(walk.blur_px);
  const double poses = double(walk.estimate.ToTrajectory().size());
  record.scores["coverage_ratio"] = walk.stamps.empty() ? 0 : poses / double(walk.stamps.size());
  const RunScores run = ScoreRun(walk.estimate, walk.truth, walk.stamps, resolved, walk.people);
  record.not_scored = run.not_scored;
  if (!run.scores) return std::nullopt;
  for (const Score& score : run.scores->scores) record.scores[score.name] = score.value;
  for (const Score& score : run.scores->timing) record.timing[score.name] = score.value;
  return run.scores;
}

std::string TrackingCsv(const Estimate& estimate) {
  std::string text = "stamp_ns,status,live_status,restarted,features,inliers,matches\n";
  for (size_t i = 0; i < estimate.frames.size(); ++i) {
    const FrameEstimate& frame = estimate.frames[i];
    const TrackingStatus live = estimate.live.empty() ? frame.status : estimate.live[i].status;
    text += fmt::format("{},{},{},{},{},{},{}\n", frame.stamp_ns, ToString(frame.status), ToString(live),
                        int(frame.restarted), frame.features, frame.inliers, frame.matches);
  }
  return text;
}

}  // namespace

std::string ProgramsFingerprint(const Scenario& scenario, const fs::path& program) {
  const std::string ours = program == "/proc/self/exe" ? ProgramFingerprint() : Sha256OfFile(program);
  const std::string theirs = FingerprintOf(scenario.system);
  return theirs.empty() ? ours : ours + "+" + theirs;
}

bool RunJob(const ResolvedScenario& resolved, const JobOptions& options) {
  const Scenario& scenario = resolved.scenario;
  JobRecord record;
  record.hash = HashOf(resolved);
  OutputFolder folder(options.runs / record.hash, "");
  const auto track = ActsOnBody(scenario) ? TrackItsOwn : TrackCached;
  const std::optional<TrackedWalk> walk = track(resolved, folder.path(), options);
  if (!walk) return false;
  record.status = walk->status;
  record.failure = walk->estimate.failure;
  record.frames = int64_t(walk->stamps.size());
  record.end_time_s = walk->end_time_s;
  record.renderer = walk->renderer;
  const std::optional<Scores> scores = ScoreInto(*walk, resolved, record);
  WriteTrajectory(folder.path() / "estimate.txt", walk->estimate.ToTrajectory(), TrajectoryFormat::kTum);
  if (!walk->estimate.live.empty()) {
    WriteTrajectory(folder.path() / "live.txt", PosesOf(walk->estimate.live), TrajectoryFormat::kTum);
  }
  WriteCovariances(folder.path() / "covariances.csv", walk->estimate.frames);
  WriteTrajectory(folder.path() / "truth.txt", walk->truth, TrajectoryFormat::kTum);
  folder.WriteText("tracking.csv", TrackingCsv(walk->estimate));
  folder.WriteText("scenario.yaml", resolved.ToYaml());
  if (scores) folder.WriteText("scores.json", ScoresToJson(*scores));
  folder.WriteText("job.json", ToJson(record, resolved).dump(2) + "\n");
  folder.Commit();
  return true;
}

std::optional<JobRecord> FindJob(const fs::path& runs, const ResolvedScenario& resolved) {
  return FindJob(runs, HashOf(resolved), ProgramsFingerprint(resolved.scenario));
}

std::optional<JobRecord> FindJob(const fs::path& runs, const std::string& hash,
                                 const std::string& program_fingerprint) {
  const fs::path file = runs / hash / "job.json";
  const std::optional<std::string> text = FindFileContent(file);
  if (!text) return std::nullopt;
  try {
    const nlohmann::json json = nlohmann::json::parse(*text);
    if (json.at("schema") != kSchema || json.at("program") != program_fingerprint) return std::nullopt;
    return FromJson(json);
  } catch (const nlohmann::json::exception& e) {
    throw BadInput(file.string() + ": damaged (" + e.what() + "); remove this folder");
  }
}

}  // namespace gaitcam
