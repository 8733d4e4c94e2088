#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "algorithms/core/errors.h"
#include "results/scoring/statistics.h"
#include "scenarios/code/experiments/light_cost.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/systems/private_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

struct SpeedOptions {
  InputPaths scenarios;
  std::vector<std::string> only;
  int frames = 8;
  double longest_s = 20;
  int people = 70;
  std::string before;
  int runs = 3;
};

template <class Visitor>
void VisitFields(Visitor& visit, SpeedOptions& o) {
  visit("scenarios", o.scenarios, Nested(), "whose walks are filmed (default: all shipped ones)");
  visit("only", o.only, Nested(), "a section of the table: light, crowd, tracking or quick_start (default: all)");
  visit("frames", o.frames, Between(1, 1000), "of each walk, those with the longest blur");
  visit("longest_s", o.longest_s, Between(1, 3600), "only so much of a walk is looked at");
  visit("people", o.people, Between(1, 200), "how many stand in the crowd");
  visit("before", o.before, AnyText(), "an older gaitcam program, whose quick start is timed in turn with this one's");
  visit("runs", o.runs, Between(1, 100), "of the quick start, by each program");
}

/// Only the walk is looked at: any system that needs no map of an earlier walk will do.
const std::vector<std::string> kWithoutMap{"system=sift_vo"};

std::vector<std::string> ShippedWalks() {
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(DataFolder() / "scenarios")) {
    if (entry.path().extension() != ".yaml") continue;
    if (!ReadScenario(entry.path(), kWithoutMap).scenario.localisation) files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// People in rows before the robot, some three steps away and more, all within its view.
std::string Crowd(int count, const Eigen::Vector3d& start) {
  std::string list;
  const double yaw = start.z() * std::numbers::pi / 180;
  for (int i = 0; i < count; ++i) {
    const int abreast = 10, rank = i / abreast, file = i % abreast;
    const double ahead = 1.5 + 0.45 * rank, aside = (file - 0.5 * (abreast - 1)) * (0.14 + 0.04 * rank);
    const double x = start.x() + ahead * std::cos(yaw) - aside * std::sin(yaw);
    const double y = start.y() + ahead * std::sin(yaw) + aside * std::cos(yaw);
    // Marching on the spot would be a walk without a way: they walk a metre to and fro.
    list += fmt::format("{}{{name: person {}, path: [[{:.3f}, {:.3f}], [{:.3f}, {:.3f}]], repeat: true, seed: {}}}",
                        i > 0 ? ", " : "", i + 1, x, y, x + std::cos(yaw), y + std::sin(yaw), i);
  }
  return "people=[" + list + "]";
}

double TimeOfQuickStart(const std::string& program, const fs::path& folder) {
  const auto begin = std::chrono::steady_clock::now();
  const fs::path out = folder / "run";
  fs::remove_all(out);
  const std::string command =
      fmt::format("'{}' run quickstart --quiet --out '{}' >/dev/null 2>&1", program, out.string());
  if (std::system(command.c_str()) != 0) throw BadInput(program + ": run quickstart failed");
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// What a blurred frame, a tracked frame and the whole quick start cost, each beside something measured in turn with
/// it.
class Speed : public ExperimentOf<SpeedOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    command_ = setup.command;
    CheckSections();
    if (Wants("light")) MeasureWalks(setup);
    if (Wants("crowd")) MeasureCrowd(setup);
    if (Wants("tracking")) MeasureTracking(setup);
    if (Wants("quick_start") && !options_.before.empty()) CompareQuickStarts(setup);
  }

  std::string Table() const override {
    return Introduction() + LightTable() + CrowdTable() + tracking_ + QuickStartTable();
  }

 private:
  bool Wants(const std::string& section) const {
    return options_.only.empty() ||
           std::find(options_.only.begin(), options_.only.end(), section) != options_.only.end();
  }

  /// Before anything is measured.
  void CheckSections() const {
    const Words sections = OneOf({"light", "crowd", "tracking", "quick_start"});
    for (const std::string& section : options_.only) {
      if (!sections.Contains(section)) throw BadOption("--only: " + sections.Refusal(section));
    }
    if (!options_.only.empty() && Wants("quick_start") && options_.before.empty()) {
      throw BadOption("--only quick_start: expected --before PROGRAM, whose quick start is timed in turn");
    }
  }

  void MeasureWalks(const ExperimentSetup& setup) {
    for (const std::string& file : options_.scenarios.paths) AddLight(setup, light_, file, {}, "");
    if (light_.empty()) {
      for (const std::string& file : ShippedWalks()) AddLight(setup, light_, file, kWithoutMap, "");
    }
    const std::string brisk = (DataFolder() / "scenarios/lab_loop_brisk.yaml").string();
    AddLight(setup, light_, brisk, {"camera.width_px=640", "camera.height_px=480"}, ", 640 x 480");
  }

  void AddLight(const ExperimentSetup& setup, std::vector<LightRow>& rows, const std::string& file,
                const std::vector<std::string>& sets, const std::string& suffix, bool convergence = true) {
    const ResolvedScenario resolved = ReadScenario(UsersOrShipped(file, {"scenarios"}), sets);
    rows.push_back(MeasureLight(resolved, {options_.frames, options_.longest_s, convergence}));
    rows.back().name += suffix;
    const LightRow& row = rows.back();
    if (!setup.quiet) {
      fmt::print(stderr, "{}: {:.1f} px, {:.2f} of the bare loop, {:.2f} levels rms\n", row.name, row.blur_px,
                 row.ratio, row.sheared.rms());
    }
  }

  void MeasureCrowd(const ExperimentSetup& setup) {
    const std::string file = (DataFolder() / "scenarios/lab_loop.yaml").string();
    const ResolvedScenario empty = ReadScenario(file, {});
    const std::string people = Crowd(options_.people, empty.scene.start);
    const std::vector<std::string> brief{"duration_s=3"};
    AddLight(setup, crowd_, file, brief, "", false);
    AddLight(setup, crowd_, file, {brief[0], people}, fmt::format(", {} people", options_.people), false);
  }

  /// The experiment tracking_time, as a section of this one's table.
  void MeasureTracking(const ExperimentSetup& setup) {
    const std::unique_ptr<TableExperiment> tracking = MakeTrackingTime();
    for (const ExperimentOption& option : tracking->Options().options) {
      if (option.key == "system") {
        *std::get<std::vector<std::string>*>(option.value) = {"mobif_vo_plus", "mobif_vo", "floor_slam"};
      } else if (option.key == "set") {
        *std::get<std::vector<std::string>*>(option.value) = {"duration_s=15"};
      }
    }
    tracking->Run(setup);
    tracking_ = "\n#" + tracking->Table();
  }

  void CompareQuickStarts(const ExperimentSetup& setup) {
    const PrivateFolder folder;
    for (int i = 0; i < options_.runs; ++i) {
      before_s_.push_back(TimeOfQuickStart(options_.before, folder.path()));
      now_s_.push_back(TimeOfQuickStart(setup.program.string(), folder.path()));
      if (!setup.quiet)
        fmt::print(stderr, "quick start: {:.1f} s before, {:.1f} s now\n", before_s_.back(), now_s_.back());
    }
  }

  std::string Introduction() const {
    return fmt::format(
        "# Speed\n\nMade by `{}`. All times are parts of something else's that was measured in turn with it, in the "
        "same process or by the same command.\n",
        command_);
  }

  std::string LightTable() const {
    if (light_.empty()) return "";
    std::string text = fmt::format(
        "\n## A blurred frame\n\nOf each walk the {} frames with the longest blur, without noise. `cost` is a frame's "
        "time "
        "over that of MuJoCo's bare loop (`mjv_updateScene`, `mjr_render`, `mjr_readPixels`) run once for every "
        "sub-frame, median; the second figure is with sharp twin, depth and blur vectors of every pixel. Differences "
        "are "
        "from plain integration with four times as many sub-frames, in grey levels, RMS / 99.9th percentile over all "
        "pixels and RMS within 3 px of a depth edge; beside them those of plain integration at its usual step.\n\n"
        "| walk | blur, px | sub-frames | renders | cost | with truth | difference | at edges | plain | at edges |\n"
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
        options_.frames);
    for (const LightRow& row : light_) {
      text += fmt::format(
          "| {} | {:.1f} | {:.0f} | {:.1f} | {:.2f} | {:.2f} | {:.2f} / {} | {:.2f} | {:.2f} / {} | {:.2f} |\n",
          row.name, row.blur_px, row.subframes, row.renders, row.ratio, row.ratio_with_truth, row.sheared.rms(),
          row.sheared.p99_9(), row.sheared_edges.rms(), row.plain.rms(), row.plain.p99_9(), row.plain_edges.rms());
    }
    return text;
  }

  std::string CrowdTable() const {
    if (crowd_.empty()) return "";
    std::string text =
        "\n## A crowd\n\nThe same frames with and without people in view. The bare loop draws the same people.\n\n"
        "| walk | blur, px | sub-frames | renders | cost |\n|---|---:|---:|---:|---:|\n";
    for (const LightRow& row : crowd_) {
      text += fmt::format("| {} | {:.1f} | {:.0f} | {:.1f} | {:.2f} |\n", row.name, row.blur_px, row.subframes,
                          row.renders, row.ratio);
    }
    return text + fmt::format("\nA frame with people takes {:.2f} times as long as one without.\n",
                              crowd_[1].frame_s / crowd_[0].frame_s);
  }

  std::string QuickStartTable() const {
    if (now_s_.empty()) return "";
    std::vector<double> ratio;
    for (size_t i = 0; i < now_s_.size(); ++i) ratio.push_back(now_s_[i] / before_s_[i]);
    return fmt::format(
        "\n## The quick start\n\n`gaitcam run quickstart`, {} times by an older program and by this one in turn: "
        "{:.1f} s "
        "({:.1f} to {:.1f}) before, {:.1f} s ({:.1f} to {:.1f}) now; the ratio of neighbours is {:.2f} ({:.2f} to "
        "{:.2f}).\n",
        now_s_.size(), MedianOf(before_s_), QuantileOf(before_s_, 0), QuantileOf(before_s_, 1), MedianOf(now_s_),
        QuantileOf(now_s_, 0), QuantileOf(now_s_, 1), MedianOf(ratio), QuantileOf(ratio, 0), QuantileOf(ratio, 1));
  }

  std::string command_, tracking_;
  std::vector<LightRow> light_, crowd_;
  std::vector<double> before_s_, now_s_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakeSpeed() { return std::make_unique<Speed>(); }

}  // namespace gaitcam
