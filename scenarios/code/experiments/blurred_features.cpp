#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/io/whole_file.h"
#include "scenarios/code/experiments/blur_kernels.h"
#include "scenarios/code/experiments/feature_experiment.h"
#include "scenarios/code/experiments/feature_table.h"
#include "scenarios/code/experiments/photographs.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/runs/progress.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

struct BlurredFeatureOptions {
  InputPaths pairs;                   ///< Folders of image pairs; empty: pictures of Debian's opencv-doc.
  std::vector<std::string> walk;      ///< Recordings with their truth beside them.
  bool walk_alone = false;            ///< No photographs.
  std::vector<std::string> detector;  ///< Empty: all.
  bool kernels = false;               ///< The table of blur_kernels.h instead.
  int strongest = 0;                  ///< Of each image, for equal numbers; 0: what each detector finds by itself.
  uint64_t seed = 1;
};

template <class Visitor>
void VisitFields(Visitor& visit, BlurredFeatureOptions& o) {
  visit("pairs", o.pairs, Nested(),
        "folders of image pairs in Oxford layout: img1.png, img2.png, H1to2p, ... (default: pictures of opencv-doc)");
  visit("walk", o.walk, Nested(), "also frames of a recording with its truth beside it");
  visit("walk_alone", o.walk_alone, Nested(), "of the recordings alone, no photographs");
  visit("detector", o.detector, Nested(), "only this detector (default: all)");
  visit("kernels", o.kernels, Nested(), "instead: blur along paths as a walk makes them, unknown and known");
  visit("strongest", o.strongest, Between(0, 20000),
        "equal numbers: so many of the strongest points of each image, thresholds lowered (default: each detector's "
        "own)");
  visit("seed", o.seed, Between(0, 1e15), "seed of directions, noise and generated views");
}

/// The graf pair, and photographs to be seen from a second side.
std::vector<ImagePair> PackagedPairs(uint64_t seed) {
  std::vector<ImagePair> pairs = ReadPairs(PackagedPicture("graf1.png").parent_path());
  std::vector<fs::path> photographs;
  for (const char* name : {"building.jpg", "home.jpg", "leuvenA.jpg", "aloeL.jpg", "fruits.jpg"})
    photographs.push_back(PackagedPicture(name));
  for (ImagePair& pair : MakePairs(photographs, seed)) pairs.push_back(std::move(pair));
  return pairs;
}

/// @throws BadInput for options that --kernels would pass over: its table has rows and numbers of its own.
void CheckKernelOptions(const BlurredFeatureOptions& options) {
  if (!options.detector.empty()) throw BadInput("--detector: not with --kernels, which compares detectors of its own");
  if (!options.walk.empty()) throw BadInput("--walk: not with --kernels, which blurs photographs");
  if (options.walk_alone) throw BadInput("--walk-alone: not with --kernels, which blurs photographs");
  if (options.strongest > 0) throw BadInput("--strongest: not with --kernels, which takes all points");
}

class BlurredFeatures : public ExperimentOf<BlurredFeatureOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    if (options_.kernels) CheckKernelOptions(options_);
    FeatureExperimentOptions options;
    options.seed = options_.seed;
    options.jobs = setup.jobs;
    options.strongest = options_.strongest;
    options.detectors = ExperimentDetectors(options.strongest > 0);
    if (!options_.detector.empty()) options.detectors = options_.detector;
    CheckDetectors(options);
    if (options_.walk_alone && (options_.walk.empty() || !options_.pairs.paths.empty()))
      throw BadInput("--walk-alone: needs a --walk, and no folders of image pairs");
    const std::vector<ImagePair> pairs = options_.walk_alone ? std::vector<ImagePair>() : Pairs();
    if (options_.kernels) return RunKernels(pairs, setup);
    std::vector<WalkPair> frames = WalkPairs();
    if (!pairs.empty()) {
      Progress pairs_progress("pairs", int64_t(pairs.size() * CameraSettings().size()), setup.quiet);
      cells_ = RunFeatureExperiment(pairs, options, [&](int done, int) { pairs_progress.Update(done); });
      pairs_progress.Finish();
    }
    if (!frames.empty()) {
      Progress walk_progress("walk", int64_t(frames.size()), setup.quiet);
      walk_ = RunWalkExperiment(frames, options, [&](int done, int) { walk_progress.Update(done); });
    }
    for (const ImagePair& pair : pairs) names_.push_back(pair.name);
    command_ = setup.command;
    fs::path beside = setup.table;
    WriteWholeFile(beside.replace_extension(".json"), FeatureJson(cells_, walk_));
    if (!cells_.empty() && !cv::imwrite(beside.replace_extension(".png").string(), FeaturePlot(cells_)))
      throw MissingResource(beside.string() + ": cannot be written");
  }
  std::string Table() const override {
    return options_.kernels ? KernelTable(trials_, command_) : FeatureTable(cells_, walk_, names_, command_);
  }

 private:
  void RunKernels(const std::vector<ImagePair>& pairs, const ExperimentSetup& setup) {
    KernelExperimentOptions options;
    options.seed = options_.seed;
    options.jobs = setup.jobs;
    Progress progress("pairs", int64_t(pairs.size() * options.settings.size()), setup.quiet);
    trials_ = RunKernelExperiment(pairs, options, [&](int done, int) { progress.Update(done); });
    progress.Finish();
    command_ = setup.command;
  }

  std::vector<ImagePair> Pairs() const {
    if (options_.pairs.paths.empty()) return PackagedPairs(options_.seed);
    std::vector<ImagePair> pairs;
    for (const std::string& folder : options_.pairs.paths)
      for (ImagePair& pair : ReadPairs(folder)) pairs.push_back(std::move(pair));
    return pairs;
  }
  std::vector<WalkPair> WalkPairs() const {
    constexpr int kGap_frames = 3, kStride_frames = 5;
    std::vector<WalkPair> frames;
    for (const std::string& dataset : options_.walk)
      for (WalkPair& pair : ReadWalkPairs(dataset, kGap_frames, kStride_frames)) frames.push_back(std::move(pair));
    return frames;
  }

  std::vector<FeatureCell> cells_;
  std::vector<WalkCell> walk_;
  std::vector<KernelTrial> trials_;
  std::vector<std::string> names_;
  std::string command_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakeBlurredFeatures() { return std::make_unique<BlurredFeatures>(); }

}  // namespace gaitcam
