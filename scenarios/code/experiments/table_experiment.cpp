#include "scenarios/code/experiments/table_experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <thread>

#include "results/scoring/statistics.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

std::string PathText(const std::string& path) {
  const fs::path normal = fs::path(path).lexically_normal();
  if (normal.is_relative()) return normal.string();
  return (normal.has_filename() ? normal : normal.parent_path()).filename().string();
}

/// The words of one option, each with a blank before it.
struct WordsOf {
  const std::string flag;
  std::string operator()(const bool* value) const { return *value ? " " + flag : ""; }
  std::string operator()(const int* value) const { return fmt::format(" {} {}", flag, *value); }
  std::string operator()(const double* value) const { return fmt::format(" {} {:g}", flag, *value); }
  std::string operator()(const uint64_t* value) const { return fmt::format(" {} {}", flag, *value); }
  std::string operator()(const std::string* value) const { return " " + flag + " " + PathText(*value); }
  std::string operator()(const std::vector<std::string>* value) const {
    std::string text;
    for (const std::string& word : *value) text += " " + flag + " " + PathText(word);
    return text;
  }
  std::string operator()(const InputPaths* value) const {
    std::string text;
    for (const std::string& path : value->paths) text += " " + PathText(path);
    return text;
  }
};

}  // namespace

std::string MedianAndRange(std::vector<double> values, int digits) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return "-";
  const std::string median = fmt::format("{:.{}f}", MedianOf(values), digits);
  if (values.size() == 1) return median;
  return fmt::format("{0} ({1:.{3}f} to {2:.{3}f})", median, QuantileOf(values, 0), QuantileOf(values, 1), digits);
}

std::string ExperimentOption::Flag() const {
  std::string flag = "--" + key;
  std::replace(flag.begin(), flag.end(), '_', '-');
  return flag;
}

std::string ExperimentOption::ToText() const { return std::visit(WordsOf{Flag()}, value); }

const std::vector<ExperimentEntry>& ListExperiments() {
  static const std::vector<ExperimentEntry> entries{
      {"crowds", "which matches are kept between views in which people and things move",
       "gaitcam experiment crowds --pairs 34 --out results/crowds.md\n"
       "gaitcam experiment crowds --scene hall --people 25 --standing 0.5",
       MakeCrowds},
      {"features", "detectors and descriptors on blurred images whose true correspondences are known",
       "gaitcam experiment features --out results/features.md\n"
       "gaitcam experiment features oxford/graf oxford/boat --detector sift --detector mobif",
       MakeBlurredFeatures},
      {"localisation", "in which place of a grid a view was taken, by every method",
       "gaitcam experiment localisation --seed 3 --seeds 10 --prefilter 0.5 --prefilter 1 --out places.md\n"
       "gaitcam experiment localisation --set localisation.wavelet.prefilter=0.5",
       MakeLocalisationTable},
      {"loops", "which earlier place a view of a walk shows, by every memory of places: precision over recall",
       "gaitcam record scenarios/corridor_loops.yaml --set camera.rate_hz=1 --out walks/twin\n"
       "gaitcam record scenarios/lab_loop.yaml --set camera.rate_hz=1 --set path.laps=2 --out walks/lab\n"
       "gaitcam experiment loops walks/twin --train walks/lab --out loops.md\n"
       "gaitcam experiment loops walks/people* --over crowd.count --over camera.exposure_ms --out density.md",
       MakeLoopTable},
      {"nees", "whether stereo points and motions know their errors: the chapter's tests, repeated, and a map",
       "gaitcam experiment nees --out results/nees.md\n"
       "gaitcam experiment nees --repeats 100 --trials 50",
       MakeStereoConsistency},
      {"peers", "any systems, yours and ours, on the same recordings: coverage, errors, jumps and time in one table",
       "gaitcam record scenarios/lab_loop.yaml --out walks/lab\n"
       "gaitcam experiment peers walks/lab --system mobif_vo_plus --system \"{process: [python3, my_slam.py]}\"\n"
       "gaitcam experiment peers walks/* --system sift_vo \\\n"
       "  --system '{command: [./my_slam, \"{dataset}\", \"{output}\"], format: tum}' --out peers.md",
       MakePeers},
      {"place_distance", "how the similarity of panoramas falls with the distance between them",
       "gaitcam run scenarios/khr1hv_loops.yaml --seed 1 --out runs/loops1\n"
       "gaitcam experiment place_distance runs/loops1",
       MakePlaceDistance},
      {"planes", "direct alignment of pictures of floors with known motion and blur",
       "gaitcam experiment planes --out results/planes.md", MakeFloorAlignment},
      {"psf", "estimated against true point spread functions, on photographs and on walks",
       "gaitcam experiment psf --walks 5 --out results/psf.md", MakeBlurEstimation},
      {"speed", "what a blurred frame and the quick start cost, and how exact the frame is",
       "gaitcam experiment speed --out results/speed.md\n"
       "gaitcam experiment speed scenarios/tabletop_khr1hv.yaml --frames 20",
       MakeSpeed},
      {"stress", "how much may go wrong with frames, stamps, IMU and calibration before a system fails: thresholds",
       "gaitcam experiment stress --system mobif_vo --system sift_vo --out stress.md\n"
       "gaitcam record scenarios/lab_loop.yaml --set duration_s=10 --out walks/lab\n"
       "gaitcam experiment stress --recording walks/lab --system \"{process: [python3, my_slam.py]}\" \\\n"
       "  --kinds dropped,frozen --seeds 5",
       MakeStress},
      {"tracking_time", "what a frame costs each system, beside SIFT on the same frames",
       "gaitcam experiment tracking_time --system mobif_vo_plus --system floor_slam --out tracking_time.md\n"
       "gaitcam experiment tracking_time datasets/lab_loop_brisk-seed1 --system mobif_vo",
       MakeTrackingTime},
      {"walking", "every humanoid, gait preset and path over several seeds: falls, speed, tilt, path error",
       "gaitcam experiment walking --out results/walking.md\n"
       "gaitcam experiment walking --robot khr1hv --preset brisk",
       MakeWalking}};
  return entries;
}

std::string ExperimentCommand(const ExperimentEntry& entry, TableExperiment& experiment) {
  const std::unique_ptr<TableExperiment> defaults = entry.make();
  const OptionList given = experiment.Options(), usual = defaults->Options();
  std::string text = "gaitcam experiment " + entry.name;
  for (size_t i = 0; i < given.options.size(); ++i) {
    const std::string words = given.options[i].ToText();
    if (words != usual.options[i].ToText()) text += words;
  }
  return text;
}

void InParallel(int count, int jobs, const std::function<void(int)>& fn) {
  const int threads = std::min(count, jobs > 0 ? jobs : std::max(1, int(std::thread::hardware_concurrency())));
  std::atomic<int> next = 0;
  const auto work = [&] {
    try {
      for (int i = next++; i < count; i = next++) fn(i);
    } catch (...) {
      next = count;
      throw;
    }
  };
  std::vector<std::future<void>> workers;
  for (int i = 0; i < threads; ++i) workers.push_back(std::async(std::launch::async, work));
  for (std::future<void>& worker : workers) worker.get();
}

}  // namespace gaitcam
