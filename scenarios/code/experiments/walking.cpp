#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "results/scoring/statistics.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/experiments/walk_trial.h"
#include "scenarios/code/files/folders.h"

namespace gaitcam {
namespace {

constexpr int kSeeds = 5;

struct WalkingOptions {
  std::string robot, preset;  ///< Empty: all.
};

template <class Visitor>
void VisitFields(Visitor& visit, WalkingOptions& o) {
  visit("robot", o.robot, AnyText(), "only this humanoid (default: all)");
  visit("preset", o.preset, AnyText(), "only this gait preset (default: all)");
}

struct Row {
  std::string robot, preset, path_name;
  PathOptions path;
  std::vector<WalkTrialResult> trials = std::vector<WalkTrialResult>(kSeeds);
};

std::vector<Row> Rows(const std::string& robot_only, const std::string& preset_only) {
  PathOptions straight, circle;
  straight.kind = PathKind::kStraight;
  straight.length_m = 20;
  circle.kind = PathKind::kCircle;
  circle.diameter_m = 4;
  std::vector<Row> rows;
  for (const char* robot : {"khr1hv", "robovie_m", "nimbro"}) {
    for (const char* preset : {"slow", "normal", "brisk"}) {
      if (!robot_only.empty() && robot_only != robot) continue;
      if (!preset_only.empty() && preset_only != preset) continue;
      rows.push_back({robot, preset, "20 m straight", straight});
      rows.push_back({robot, preset, "circle, 4 m across", circle});
    }
  }
  return rows;
}

void Walk(Row& row, int seed) {
  const Robot robot = ReadRobot(row.robot, ModelsFolder());
  WalkTrialOptions options;
  options.path = row.path;
  options.physics.mass_noise_ratio = 0.1;
  options.physics.friction_noise_ratio = 0.1;
  options.seed = uint64_t(seed + 1);
  row.trials[size_t(seed)] = RunWalkTrial(robot, robot.gaits.at(row.preset), options);
  const WalkTrialResult& r = row.trials[size_t(seed)];
  std::fprintf(stderr, "%s %s, %s, seed %d: %s after %.2f m, %.0f s, %.0f x real time\n", row.robot.c_str(),
               row.preset.c_str(), row.path_name.c_str(), seed + 1,
               r.finished ? "finished"
               : r.fell   ? "FELL"
                          : "TOO LATE",
               r.distance_m, r.end_s, r.end_s / r.wall_s);
}

template <class Value>
std::vector<double> Each(const Row& row, Value value) {
  std::vector<double> values;
  for (const WalkTrialResult& trial : row.trials) values.push_back(value(trial));
  return values;
}

std::string Line(const Row& row) {
  const auto not_there = std::count_if(row.trials.begin(), row.trials.end(), [](const auto& t) { return !t.finished; });
  const auto speed = Each(row, [](const auto& t) { return 100 * t.speed_m_s; });
  const auto tilt = Each(row, [](const auto& t) { return kDegPerRad * t.max_tilt_rad; });
  const auto error = Each(row, [](const auto& t) { return 100 * QuantileOf(t.path_error_m, 0.5); });
  const auto worst = Each(row, [](const auto& t) { return 100 * QuantileOf(t.path_error_m, 1); });
  const auto rate = [&](int axis) {
    return QuantileOf(Each(row, [&](const auto& t) { return t.head_rate_rms[axis]; }), 0.5);
  };
  return fmt::format(
      "| {} | {} | {} | {} | {:.1f} ({:.1f}–{:.1f}) | {:.1f} | {:.1f} ({:.1f}–{:.1f}) | {:.1f} | {:.2f} {:.2f} {:.2f} "
      "|\n",
      row.robot, row.preset, row.path_name, not_there, QuantileOf(speed, 0.5), QuantileOf(speed, 0),
      QuantileOf(speed, 1), QuantileOf(tilt, 1), QuantileOf(error, 0.5), QuantileOf(error, 0), QuantileOf(error, 1),
      QuantileOf(worst, 1), rate(0), rate(1), rate(2));
}

std::string TableOf(const std::vector<Row>& rows, const std::string& command) {
  std::string text = fmt::format(
      "# Walking\n\n"
      "Made by `{}`. Each row is {} walks: every link's mass and the floor's friction off by up "
      "to\n"
      "10 % by seed; gyroscope, accelerometer and joint encoders noisy and biased; the true pose used for steering "
      "alone.\n"
      "Where a range stands in brackets, the figure before it is the median over the seeds. The path error is the\n"
      "distance of the root link from the path at each step; the head's rates are rms over the walk, of the camera's\n"
      "roll, pitch and yaw.\n\n"
      "| robot | preset | path | falls of {} | speed, cm/s | most tilt, ° | path error, median, cm | worst, cm | head "
      "rates, "
      "rad/s |\n|---|---|---|---|---|---|---|---|---|\n",
      command, kSeeds, kSeeds);
  for (const Row& row : rows) text += Line(row);
  return text;
}

/// Walks every humanoid with every preset along a straight and a circle, over several seeds of mass and friction noise
/// and with noisy sensors: who fell, how fast, how much tilt, how near to the path.
class Walking : public ExperimentOf<WalkingOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    command_ = setup.command;
    rows_ = Rows(options_.robot, options_.preset);
    if (rows_.empty()) throw BadInput("--robot " + options_.robot + " --preset " + options_.preset + ": there is none");
    InParallel(int(rows_.size()) * kSeeds, setup.jobs, [&](int i) { Walk(rows_[size_t(i / kSeeds)], i % kSeeds); });
  }
  std::string Table() const override { return TableOf(rows_, command_); }

 private:
  std::string command_;
  std::vector<Row> rows_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakeWalking() { return std::make_unique<Walking>(); }

}  // namespace gaitcam
