// How far odometry goes wrong on recorded walks: every scenario with several seeds, tracked by every system, scored
// against the truth. Writes a table, and a picture of the paths of the first scenario's first seed.
//
//   gaitcam_odometry_table OUT.md PICTURE.png [--seeds N] [--scenario FILE[:SEEDS]]... [--system NAME]...
//                          [--set KEY=VALUE]... [--keep FOLDER] [--jobs N]
//
// --set changes the scenarios; FILE:SEEDS is a scenario with a number of seeds of its own. In --keep lie
// FOLDER/NAME-seedN/{NAME,NAME-truth} and the estimates: a finished recording of the same scenario is used again, and
// so is an estimate that this very build has written.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/io/dataset_reader.h"
#include "algorithms/io/text_table.h"
#include "algorithms/io/trajectory_file.h"
#include "results/metrics.h"
#include "results/score.h"
#include "scenarios/recorder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string table, picture, keep;
  int seeds = 1, jobs = 2;
  std::vector<std::string> scenarios, systems, sets;
  std::string command;  ///< As it can be typed again, without --keep and --jobs.
};

/// One film on disk and what is true of it.
struct Recording {
  ResolvedScenario resolved;
  fs::path folder;
  DatasetFolders folders;
  Trajectory truth;
  std::vector<int64_t> stamps;
  std::vector<double> blur_px;  ///< Median over each frame.
};

/// One system on one film.
struct Track {
  Estimate estimate;  ///< Frames with a pose.
  double ms_per_frame = NAN, coverage = 0;
  std::optional<Scores> scores;  ///< Absent if too little was covered.
};

// ---------------------------------------------------------------------------------------------------- recording

/// The column of frames.csv that holds each frame's median blur, found by its name in the header.
size_t BlurColumn(const fs::path& file) {
  std::ifstream stream(file);
  std::string header, name;
  std::getline(stream, header);
  std::istringstream names(header);
  for (size_t column = 0; std::getline(names, name, ','); ++column) {
    if (name == "blur_median_px") return column;
  }
  throw BadInput(file.string() + ":1: no column blur_median_px");
}

void ReadTruth(Recording& recording) {
  const fs::path frames = recording.folders.truth / "frames.csv";
  const size_t blur_column = BlurColumn(frames);
  TextTable table(frames, ',');
  while (table.Next()) {
    recording.stamps.push_back(table.Integer(0, "stamp_ns"));
    recording.blur_px.push_back(table.Number(blur_column, "blur_median_px"));
  }
  recording.truth = ReadTrajectory(recording.folders.truth / "groundtruth.txt").trajectory;
}

/// The scenario file lies in the truth's folder once a recording is finished. @throws BadInput if it tells of another
/// walk or camera than `now`; what tracks and scores may differ.
bool IsRecorded(const Recording& now) {
  const fs::path file = now.folders.truth / "scenario.yaml";
  if (!fs::exists(file)) return false;
  ResolvedScenario then = ReadScenario(file, {});
  then.scenario.description = now.resolved.scenario.description;
  then.scenario.system = now.resolved.scenario.system;
  then.scenario.score = now.resolved.scenario.score;
  then.scenario.video = now.resolved.scenario.video;
  if (then.ToYaml() == now.resolved.ToYaml()) return true;
  throw BadInput(file.string() + ": a recording of another scenario; name another --keep folder, or --set name=...");
}

Recording Record(const std::string& file, std::vector<std::string> sets, int seed, const fs::path& keep) {
  sets.push_back(fmt::format("seed={}", seed));
  Recording recording{ReadScenario(file, sets), {}, {}, {}, {}, {}};
  const std::string name = recording.resolved.scenario.name;
  recording.folder = keep / fmt::format("{}-seed{}", name, seed);
  recording.folders = DatasetFolders::In(recording.folder, name);
  if (!IsRecorded(recording)) {
    RecordScenario(recording.resolved, recording.folders, {});
  }
  ReadTruth(recording);
  return recording;
}

// ----------------------------------------------------------------------------------------------------- tracking

Track TrackNow(const Recording& recording, const std::string& system_name) {
  DatasetReader reader(recording.folders.sensors);
  const auto system = MakeSystem(system_name, {reader.calibration(), recording.resolved.scenario.seed, {}});
  Track track;
  double total_ms = 0;
  while (const std::optional<Observation> observation = reader.Next()) {
    const auto begin = std::chrono::steady_clock::now();
    track.estimate.frames.push_back(system->Track(*observation));
    total_ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  }
  track.ms_per_frame = total_ms / double(std::max<size_t>(1, track.estimate.frames.size()));
  if (auto last_word = system->Finish(); !last_word.empty()) track.estimate.frames = std::move(last_word);
  return track;
}

void Keep(const Track& track, const fs::path& trajectory_file, const fs::path& facts_file) {
  nlohmann::ordered_json facts{{"ms_per_frame", track.ms_per_frame},
                               {"poses", track.estimate.ToTrajectory().size()},
                               {"restarted_ns", nlohmann::ordered_json::array()}};
  for (const FrameEstimate& frame : track.estimate.frames) {
    if (frame.restarted) facts["restarted_ns"].push_back(frame.stamp_ns);
  }
  WriteTrajectory(trajectory_file, track.estimate.ToTrajectory(), TrajectoryFormat::kTum);
  WriteWholeFile(facts_file, facts.dump(2) + "\n");
}

Track Kept(const fs::path& trajectory_file, const fs::path& facts_file) {
  std::ifstream stream(facts_file);
  const nlohmann::json facts = nlohmann::json::parse(stream);
  Track track;
  track.ms_per_frame = facts.at("ms_per_frame");
  if (facts.at("poses") == 0) return track;
  track.estimate = EstimateFromTrajectory(ReadTrajectory(trajectory_file).trajectory);
  const std::vector<int64_t> restarted = facts.at("restarted_ns");
  for (FrameEstimate& frame : track.estimate.frames) {
    frame.restarted = std::find(restarted.begin(), restarted.end(), frame.stamp_ns) != restarted.end();
  }
  return track;
}

/// Another build may track differently.
bool WrittenByThisBuild(const fs::path& file) {
  return fs::exists(file) && fs::last_write_time(file) > fs::last_write_time(fs::canonical("/proc/self/exe"));
}

Track TrackAndScore(const Recording& recording, const std::string& system) {
  const fs::path trajectory = recording.folder / ("estimate-" + system + ".txt");
  const fs::path facts = recording.folder / ("estimate-" + system + ".json");
  if (!WrittenByThisBuild(facts)) Keep(TrackNow(recording, system), trajectory, facts);
  Track track = Kept(trajectory, facts);
  track.coverage = double(track.estimate.frames.size()) / double(std::max<size_t>(1, recording.stamps.size()));
  const std::string who = recording.folder.filename().string() + ", " + system;
  try {
    track.scores = ScoreEstimate(track.estimate, recording.truth, recording.stamps, recording.resolved.scenario.score);
    std::fprintf(stderr, "%s: coverage %.3f, %.0f ms\n", who.c_str(), track.coverage, track.ms_per_frame);
  } catch (const TooLittleData& e) {
    std::fprintf(stderr, "%s: %s\n", who.c_str(), e.what());
  }
  return track;
}

/// tracks[recording][system]
using Tracks = std::vector<std::vector<Track>>;

Tracks TrackAll(const std::vector<Recording>& recordings, const Arguments& arguments) {
  const size_t systems = arguments.systems.size();
  Tracks tracks(recordings.size(), std::vector<Track>(systems));
  std::atomic<size_t> next{0};
  std::mutex failure_mutex;
  std::exception_ptr failure;
  const auto work = [&] {
    try {
      for (size_t job = next++; job < recordings.size() * systems; job = next++)
        tracks[job / systems][job % systems] =
            TrackAndScore(recordings[job / systems], arguments.systems[job % systems]);
    } catch (...) {
      const std::lock_guard lock(failure_mutex);
      failure = std::current_exception();
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < arguments.jobs; ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
  return tracks;
}

// -------------------------------------------------------------------------------------------------------- table

/// "median (min..max)", the median alone for one value, "-" for none.
std::string Spread(std::vector<double> values, int digits) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return "-";
  const std::string median = fmt::format("{:.{}f}", Quantile(values, 0.5), digits);
  if (values.size() == 1) return median;
  return fmt::format("{} ({:.{}f}..{:.{}f})", median, Quantile(values, 0), digits, Quantile(values, 1), digits);
}

/// One scenario's recordings: [begin, end) of the list.
struct Group {
  size_t begin, end;
};

std::string Cells(const std::vector<Recording>& recordings, const Tracks& tracks, Group group, size_t system) {
  std::vector<double> coverage, ate, end_error, gain, restarts, ms;
  for (size_t i = group.begin; i < group.end; ++i) {
    const Track& t = tracks[i][system];
    coverage.push_back(100 * t.coverage);
    ms.push_back(t.ms_per_frame);
    if (!t.scores) continue;
    ate.push_back(100 * t.scores->Value("ate_sim3_rmse_m") / PathLength(recordings[i].truth));
    end_error.push_back(t.scores->Value("end_drift_sim3_pct"));
    gain.push_back(t.scores->Value("rotation_gain"));
    restarts.push_back(t.scores->Value("restarts"));
  }
  return fmt::format("{} of {} | {} | {} | {} | {} | {} | {}", ate.size(), group.end - group.begin, Spread(coverage, 1),
                     Spread(ate, 2), Spread(end_error, 2), Spread(gain, 3), Spread(restarts, 0), Spread(ms, 0));
}

std::string Rows(const std::vector<Recording>& recordings, const Tracks& tracks, const Arguments& arguments,
                 Group group) {
  std::vector<double> blur, length;
  for (size_t i = group.begin; i < group.end; ++i) {
    blur.push_back(Quantile(recordings[i].blur_px, 0.5));
    length.push_back(PathLength(recordings[i].truth));
  }
  const Scenario& scenario = recordings[group.begin].resolved.scenario;
  std::string rows;
  for (size_t s = 0; s < arguments.systems.size(); ++s) {
    rows += fmt::format("| {} | {:g} ms | {} | {} | {} | {} |\n", scenario.name, scenario.camera.exposure.exposure_ms,
                        Spread(blur, 1), Spread(length, 1), arguments.systems[s], Cells(recordings, tracks, group, s));
  }
  return rows;
}

std::string Table(const std::vector<Recording>& recordings, const std::vector<Group>& groups, const Tracks& tracks,
                  const Arguments& arguments) {
  std::string text = fmt::format(
      "# Odometry on recorded walks\n\nMade by `{}`.\n\n"
      "Every scenario is recorded once per seed (the seeds count from 1) and tracked by every system; the system sees\n"
      "the sensors' folder alone. Where there are several seeds, a figure is the median over them, (min..max) in\n"
      "brackets. Blur is the median over the frames of each frame's median blur; the path is the camera's, its sway\n"
      "included, and so are the percentages of it. Coverage is the part of the recorded frames that got a pose. The\n"
      "absolute error (ATE, rmse) and the end error, which is the error between the first and the last pose, stand\n"
      "under one Sim(3) alignment of the whole run: after a restart nothing is forgiven. Rotation gain is the turning\n"
      "about the vertical, estimated over true; what a restart did counts as no turn. \"-\": a run that covers less\n"
      "than 10 % of the frames is not scored; how many runs were, says the column \"scored\". Errors say nothing of\n"
      "frames without a pose: read them together with the coverage. Wall time per frame is rough, for it counts "
      "whatever\n"
      "else the machine was doing; {} runs at once are the program's own part of that.\n\n"
      "| scenario | exposure | blur, px | path, m | system | scored | coverage, % | ATE, % of path | end error, % of "
      "path | rotation gain | restarts | ms per frame |\n|---|---:|---:|---:|---|---:|---:|---:|---:|---:|---:|---:|\n",
      arguments.command, arguments.jobs);
  for (const Group& group : groups) text += Rows(recordings, tracks, arguments, group);
  const fs::path beside = fs::absolute(arguments.table).parent_path();
  text += fmt::format(
      "\n![Paths from above]({})\n\nThe paths of the first scenario's first seed from above, each estimate under its "
      "Sim(3)\nalignment; where frames have no pose, or a system chose its world anew, the line is broken.\n",
      fs::absolute(arguments.picture).lexically_relative(beside).generic_string());
  return text;
}

// ------------------------------------------------------------------------------------------------------ picture

/// One line of the picture, broken where `pieces` says so.
struct Curve {
  std::string label;
  cv::Scalar color;
  int width = 1;
  std::vector<std::vector<Eigen::Vector2d>> pieces;
};

std::vector<std::vector<Eigen::Vector2d>> Pieces(const Estimate& estimate, const Similarity& X_WV, double rate_hz) {
  std::vector<std::vector<Eigen::Vector2d>> pieces;
  int64_t last_ns = 0;
  for (const FrameEstimate& frame : estimate.frames) {
    if (!frame.pose) continue;
    const bool gap = double(frame.stamp_ns - last_ns) > 1.5e9 / rate_hz;
    if (pieces.empty() || gap || frame.restarted) pieces.emplace_back();
    pieces.back().push_back((X_WV * frame.pose->translation).head<2>());
    last_ns = frame.stamp_ns;
  }
  return pieces;
}

std::vector<Curve> Curves(const Recording& recording, const std::vector<Track>& tracks, const Arguments& arguments) {
  const double rate_hz = recording.resolved.scenario.camera.rate_hz;
  std::vector<Curve> curves;
  curves.push_back({"truth", {150, 150, 150}, 5, Pieces(EstimateFromTrajectory(recording.truth), {}, rate_hz)});
  for (size_t s = 0; s < tracks.size(); ++s) {
    const std::string& name = arguments.systems[s];
    if (name != "sift_vo" && name != "mobif_vo_plus") continue;
    const auto pairs = AssociatePoses(tracks[s].estimate, recording.truth, {});
    if (pairs.size() < 3) continue;
    const cv::Scalar color = name == "sift_vo" ? cv::Scalar(40, 40, 220) : cv::Scalar(200, 110, 0);
    curves.push_back({fmt::format("{}, {:.1f} % of the frames", name, 100 * tracks[s].coverage), color, 2,
                      Pieces(tracks[s].estimate, Align(pairs, Alignment::kSim3).X_WV, rate_hz)});
  }
  return curves;
}

/// What part of the world is drawn where: x to the right, y up, the same scale for both.
struct View {
  static constexpr int kWidth = 900, kHeight = 700, kLeft = 70, kRight = 20, kTop = 95, kBottom = 60;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double px_per_m = 1;

  static cv::Rect Area() { return {kLeft, kTop, kWidth - kLeft - kRight, kHeight - kTop - kBottom}; }
  /// In the area's own coordinates.
  cv::Point2d operator()(const Eigen::Vector2d& p) const {
    return {Area().width / 2.0 + px_per_m * (p.x() - middle.x()),
            Area().height / 2.0 - px_per_m * (p.y() - middle.y())};
  }
};

/// All of the truth, and of the estimates what is not further off than half the truth's extent.
View ViewOf(const std::vector<Curve>& curves) {
  Eigen::AlignedBox2d box, all;
  for (const auto& piece : curves.front().pieces) {
    for (const auto& p : piece) box.extend(p);
  }
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(std::max(0.5, 0.5 * box.sizes().maxCoeff()));
  for (const Curve& curve : curves) {
    for (const auto& piece : curve.pieces) {
      for (const auto& p : piece) all.extend(p);
    }
  }
  all = all.intersection(Eigen::AlignedBox2d(box.min() - margin, box.max() + margin));
  View view;
  view.middle = all.center();
  view.px_per_m = 0.92 * std::min(View::Area().width / std::max(0.1, all.sizes().x()),
                                  View::Area().height / std::max(0.1, all.sizes().y()));
  return view;
}

void Write(cv::Mat& image, const std::string& text, cv::Point at, double size = 0.55) {
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, size, {30, 30, 30}, 1, cv::LINE_AA);
}

/// Lines at multiples of 1, 2 or 5 times a power of ten, at least 60 px apart.
void DrawGrid(cv::Mat& image, const View& view) {
  const double least = 60 / view.px_per_m, power = std::pow(10, std::floor(std::log10(least)));
  const double step = power * (least <= power ? 1 : least <= 2 * power ? 2 : least <= 5 * power ? 5 : 10);
  const cv::Rect area = View::Area();
  for (const int axis : {0, 1}) {
    const double half = 0.5 * (axis == 0 ? area.width : area.height) / view.px_per_m;
    for (double k = std::ceil((view.middle[axis] - half) / step); k * step <= view.middle[axis] + half; ++k) {
      Eigen::Vector2d p = view.middle;
      p[axis] = k * step;
      const cv::Point at = cv::Point(view(p)) + area.tl();
      const std::string text = fmt::format("{:g}", std::abs(k) < 0.5 ? 0 : k * step);
      if (axis == 0) {
        cv::line(image, {at.x, area.y}, {at.x, area.br().y}, {225, 225, 225});
        Write(image, text, {at.x - 4 * int(text.size()), area.br().y + 20}, 0.5);
      } else {
        cv::line(image, {area.x, at.y}, {area.br().x, at.y}, {225, 225, 225});
        Write(image, text, {area.x - 10 - 9 * int(text.size()), at.y + 5}, 0.5);
      }
    }
  }
  Write(image, "x, m", {area.x + area.width / 2 - 15, area.br().y + 45});
  Write(image, "y, m", {8, area.y - 12});
}

void DrawCurve(cv::Mat area, const View& view, const Curve& curve) {
  constexpr int kShift = 4;
  for (const auto& piece : curve.pieces) {
    std::vector<cv::Point> points;
    for (const auto& p : piece) points.emplace_back(view(p) * double(1 << kShift));
    if (points.size() == 1) points.push_back(points.front());  // a lone pose is a dot
    cv::polylines(area, points, false, curve.color, curve.width, cv::LINE_AA, kShift);
  }
}

/// In a row above the drawing, so that it hides nothing.
void DrawLegend(cv::Mat& image, const std::vector<Curve>& curves) {
  int x = View::kLeft;
  for (const Curve& curve : curves) {
    const int y = View::kTop - 42;
    cv::line(image, {x, y}, {x + 35, y}, curve.color, curve.width, cv::LINE_AA);
    Write(image, curve.label, {x + 43, y + 5}, 0.5);
    x += 43 + cv::getTextSize(curve.label, cv::FONT_HERSHEY_SIMPLEX, 0.5, 1, nullptr).width + 30;
  }
}

void DrawPaths(const Recording& recording, const std::vector<Track>& tracks, const Arguments& arguments) {
  const std::vector<Curve> curves = Curves(recording, tracks, arguments);
  const View view = ViewOf(curves);
  cv::Mat image(View::kHeight, View::kWidth, CV_8UC3, cv::Scalar::all(255));
  DrawGrid(image, view);
  for (const Curve& curve : curves) DrawCurve(image(View::Area()), view, curve);
  cv::rectangle(image, View::Area(), {90, 90, 90});
  DrawLegend(image, curves);
  const Scenario& scenario = recording.resolved.scenario;
  Write(image,
        fmt::format("{}, seed {}, {:g} ms: paths from above", scenario.name, scenario.seed,
                    scenario.camera.exposure.exposure_ms),
        {View::kLeft, 30}, 0.65);
  if (!cv::imwrite(arguments.picture, image)) throw MissingResource("cannot write " + arguments.picture);
}

// --------------------------------------------------------------------------------------------------------- main

std::string CommandText(const Arguments& a) {
  std::string text = fmt::format("gaitcam_odometry_table {} {} --seeds {}", a.table, a.picture, a.seeds);
  for (const std::string& file : a.scenarios) text += " --scenario " + fs::path(file).lexically_normal().string();
  for (const std::string& system : a.systems) text += " --system " + system;
  for (const std::string& set : a.sets) text += " --set " + set;
  return text;
}

/// "FILE:SEEDS" or "FILE".
std::pair<std::string, int> FileAndSeeds(const std::string& text, int seeds) {
  const size_t colon = text.rfind(':');
  if (colon == std::string::npos) return {text, seeds};
  const std::string count = text.substr(colon + 1);
  int own = 0;
  const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), own);
  if (error != std::errc() || end != count.data() + count.size() || own < 1)
    throw BadInput("--scenario " + text + ": after the colon stands a number of seeds, 1 or more");
  return {text.substr(0, colon), own};
}

void Run(const Arguments& arguments, const fs::path& keep) {
  std::vector<Recording> recordings;
  std::vector<Group> groups;
  for (const std::string& scenario : arguments.scenarios) {
    const auto [file, seeds] = FileAndSeeds(scenario, arguments.seeds);
    groups.push_back({recordings.size(), recordings.size()});
    for (int seed = 1; seed <= seeds; ++seed) recordings.push_back(Record(file, arguments.sets, seed, keep));
    groups.back().end = recordings.size();
  }
  const Tracks tracks = TrackAll(recordings, arguments);
  DrawPaths(recordings.front(), tracks.front(), arguments);
  WriteWholeFile(arguments.table, Table(recordings, groups, tracks, arguments));
}

int Main(int argc, char** argv) {
  Arguments a;
  CLI::App app("Odometry of several systems on recorded walks, as a table and a picture");
  app.add_option("table", a.table, "Markdown file to write")->required();
  app.add_option("picture", a.picture, "PNG file to write")->required();
  app.add_option("--seeds", a.seeds, "walks per scenario, seeds 1 to N")->check(CLI::Range(1, 1000));
  app.add_option("--scenario", a.scenarios, "scenario file, or FILE:SEEDS; may be given again")
      ->allow_extra_args(false);
  app.add_option("--system", a.systems, "system to track with; may be given again")->allow_extra_args(false);
  app.add_option("--set", a.sets, "KEY=VALUE of the scenarios; may be given again")->allow_extra_args(false);
  app.add_option("--keep", a.keep, "folder in which recordings and estimates stay");
  app.add_option("--jobs", a.jobs, "systems that track at once")->check(CLI::Range(1, 64));
  CLI11_PARSE(app, argc, argv);
  if (a.systems.empty()) a.systems = {"sift_vo", "akaze_vo", "mobif_vo", "mobif_vo_plus"};
  const std::string shipped = GAITCAM_SOURCE_DIR "/scenarios/";
  if (a.scenarios.empty()) {
    for (const char* name : {"lab_loop_brisk", "lab_loop", "corridor_there_and_back"})
      a.scenarios.push_back(shipped + name + ".yaml");
  }
  a.command = CommandText(a);
  const bool temporary = a.keep.empty();
  const fs::path keep =
      temporary ? fs::temp_directory_path() / fmt::format("gaitcam_odometry_table-{}", getpid()) : fs::path(a.keep);
  int code = 0;
  try {
    Run(a, keep);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "gaitcam_odometry_table: %s\n", e.what());
    code = 1;
  }
  std::error_code ignored;
  if (temporary) fs::remove_all(keep, ignored);
  return code;
}

}  // namespace
}  // namespace gaitcam

int main(int argc, char** argv) { return gaitcam::Main(argc, argv); }
