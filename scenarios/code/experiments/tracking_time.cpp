#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/io/dataset_reader.h"
#include "results/scoring/statistics.h"
#include "scenarios/code/experiments/processor_time.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/files/system_needs.h"
#include "scenarios/code/jobs/sequence_cache.h"
#include "scenarios/code/systems/chosen_system.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

struct TrackingTimeOptions {
  InputPaths walks;  ///< Empty: scenarios/lab_loop_brisk.yaml.
  std::vector<std::string> system;
  std::vector<std::string> set;  ///< KEY=VALUE of scenarios.
  uint64_t seed = 1;
  int frames = 0;  ///< 0: all.
};

template <class Visitor>
void VisitFields(Visitor& visit, TrackingTimeOptions& o) {
  visit("walks", o.walks, Nested(), "recorded folders or scenarios (default: scenarios/lab_loop_brisk.yaml)");
  visit("system", o.system, Nested(), "a system, by name or as in a scenario (default: mobif_vo and mobif_vo_plus)");
  visit("set", o.set, Nested(), "set any key of the scenarios, KEY=VALUE");
  visit("seed", o.seed, Between(0, 1e15), "seed of the systems");
  visit("frames", o.frames, Between(0, 1e6), "only so many frames of each walk (0: all)");
}

/// Times of every frame, ms.
struct FrameTimes {
  std::string walk, system;
  cv::Size size;
  std::vector<double> own, sift;

  double Ratio() const { return MedianOf(own) / MedianOf(sift); }
  std::string Row() const {
    const double median = MedianOf(own), worst = QuantileOf(own, 1);
    return fmt::format("| {} | {} x {} | {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.1f} | {:.2f} | {:.2f} | {:.3f} |\n",
                       walk, size.width, size.height, own.size(), system, median, QuantileOf(own, 0.95), worst,
                       worst / median, MedianOf(sift), QuantileOf(sift, 1), Ratio());
  }
};

/// Of OpenCV's own settings.
double TimeOfSift(cv::Feature2D& sift, const cv::Mat& image) {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat grey = image, descriptors;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  const double before_ms = ProcessorTime_ms();
  sift.detectAndCompute(grey, cv::noArray(), keypoints, descriptors);
  return ProcessorTime_ms() - before_ms;
}

/// Both in turn on every frame, so that whatever slows the machine down slows both.
FrameTimes TimeFrames(const fs::path& dataset, const SystemChoice& choice, const TrackingTimeOptions& options,
                      const fs::path& folder) {
  DatasetReader reader(dataset);
  if (const auto lack = LackInDataset(InfoOf(choice), reader.calibration(), dataset)) throw BadInput(*lack);
  const std::unique_ptr<System> system =
      MakeSystem(choice, {reader.calibration(), options.seed, choice.settings}, folder);
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create();
  FrameTimes times;
  for (int i = 0; options.frames == 0 || i < options.frames; ++i) {
    const std::optional<Observation> observation = reader.Next();
    if (!observation) break;
    times.size = observation->image.pixels.size();
    times.sift.push_back(TimeOfSift(*sift, observation->image.pixels));
    const double before_ms = ProcessorTime_ms();
    system->Track(*observation);
    times.own.push_back(ProcessorTime_ms() - before_ms);
  }
  if (times.own.empty()) throw TooLittleData(dataset.string() + ": has no frames");
  return times;
}

/// What a frame costs a system, in parts of what its features alone would cost with SIFT.
class TrackingTime : public ExperimentOf<TrackingTimeOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    command_ = setup.command;
    cv::setNumThreads(1);  // times are one thread's
    if (options_.walks.paths.empty()) {
      options_.walks.paths = {(DataFolder() / "scenarios/lab_loop_brisk.yaml").string()};
    }
    if (options_.system.empty()) options_.system = {"mobif_vo", "mobif_vo_plus"};
    std::vector<SystemChoice> systems;
    for (const std::string& text : options_.system) {
      systems.push_back(ParseSystemChoice(text));
      const SystemChoice& choice = systems.back();
      InfoOf(choice);  // now, not after the walk was recorded: is there such a system?
      if (choice.command || choice.process) throw BadInput(text + ": only what runs in this program is timed");
    }
    for (const std::string& walk : options_.walks.paths) Measure(walk, systems, setup);
  }
  std::string Table() const override {
    std::string text = fmt::format(
        "# What tracking a frame costs\n\nMade by `{}`. Times in ms per frame, one thread's, as the processor counts "
        "them: what else the machine does hardly lengthens them. Beside every frame's tracking stands cv::SIFT's "
        "detectAndCompute, with its defaults, on the same frame in the same process, one after the other. The ratio "
        "is the median over SIFT's. What a system does after its last frame is not counted.\n\n"
        "| walk | image | frames | system | median | 95 % | worst | worst / median | SIFT | SIFT, worst | ratio |\n"
        "|---|---|---:|---|---:|---:|---:|---:|---:|---:|---:|\n",
        command_);
    for (const FrameTimes& times : rows_) text += times.Row();
    return text;
  }

 private:
  /// Of a recording, or of a scenario as it is recorded.
  void Measure(const std::string& walk, const std::vector<SystemChoice>& systems, const ExperimentSetup& setup) {
    const std::string name = fs::path(walk).stem().string();
    if (fs::is_directory(walk)) return Measure(name, FindDataset(walk), systems, setup);
    const ResolvedScenario resolved = ReadScenario(UsersOrShipped(walk, {"scenarios"}), options_.set);
    const auto recorded = SequenceCache({}).Get(resolved, setup.quiet, [] { return false; });
    Measure(name, recorded->folders.sensors, systems, setup);
  }
  void Measure(const std::string& name, const fs::path& dataset, const std::vector<SystemChoice>& systems,
               const ExperimentSetup& setup) {
    const fs::path folder = fs::absolute(setup.table).parent_path();
    for (size_t i = 0; i < systems.size(); ++i) {
      rows_.push_back(TimeFrames(dataset, systems[i], options_, folder));
      rows_.back().walk = name;
      rows_.back().system = options_.system[i];
      if (!setup.quiet) fmt::print(stderr, "{}", rows_.back().Row());
    }
  }

  std::string command_;
  std::vector<FrameTimes> rows_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakeTrackingTime() { return std::make_unique<TrackingTime>(); }

}  // namespace gaitcam
