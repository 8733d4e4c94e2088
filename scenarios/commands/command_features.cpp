#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>

#include "algorithms/core/errors.h"
#include "scenarios/commands/commands.h"
#include "scenarios/datasets/feature_experiment.h"
#include "scenarios/datasets/feature_table.h"
#include "scenarios/runs/output_folder.h"
#include "scenarios/runs/progress.h"

namespace gaitcam {
namespace {

/// Pictures that come with Debian's opencv-doc: the graf pair, and photographs to be seen from a second side.
std::vector<ImagePair> PackagedPairs(uint64_t seed) {
  const std::filesystem::path folder = "/usr/share/doc/opencv-doc/examples/data";
  if (!std::filesystem::exists(folder / "graf1.png"))
    throw MissingResource(folder.string() + ": no pictures there; install opencv-doc, or name folders of image pairs");
  std::vector<ImagePair> pairs = ReadPairs(folder);
  std::vector<std::filesystem::path> photographs;
  for (const char* name : {"building.jpg", "home.jpg", "leuvenA.jpg", "aloeL.jpg", "fruits.jpg"})
    photographs.push_back(folder / name);
  for (ImagePair& pair : MakePairs(photographs, seed)) pairs.push_back(std::move(pair));
  return pairs;
}

std::vector<ImagePair> PairsOf(const FeaturesArguments& arguments) {
  if (arguments.pairs.empty()) return PackagedPairs(arguments.seed);
  std::vector<ImagePair> pairs;
  for (const std::filesystem::path& folder : arguments.pairs)
    for (ImagePair& pair : ReadPairs(folder)) pairs.push_back(std::move(pair));
  return pairs;
}

/// As it would be typed again, without the way to the user's own folders.
std::string CommandText(const FeaturesArguments& arguments) {
  std::string text = "gaitcam features";
  for (const std::filesystem::path& folder : arguments.pairs) text += " " + folder.filename().string();
  for (const std::filesystem::path& dataset : arguments.walks) text += " --walk " + dataset.filename().string();
  if (arguments.seed != 1) text += fmt::format(" --seed {}", arguments.seed);
  for (const std::string& name : arguments.detectors) text += " --detector " + name;
  return text;
}

}  // namespace

int FeaturesCommand(const FeaturesArguments& arguments, const CommonOptions& common) {
  FeatureExperimentOptions options;
  options.seed = arguments.seed;
  if (!arguments.detectors.empty()) options.detectors = arguments.detectors;
  const std::vector<ImagePair> pairs = PairsOf(arguments);
  constexpr int kGap_frames = 3, kStride_frames = 5;
  std::vector<WalkPair> frames;
  for (const std::filesystem::path& dataset : arguments.walks)
    for (WalkPair& pair : ReadWalkPairs(dataset, kGap_frames, kStride_frames)) frames.push_back(std::move(pair));

  Progress pairs_progress("pairs", int64_t(pairs.size() * CameraSettings().size()), common.quiet);
  const std::vector<FeatureCell> cells =
      RunFeatureExperiment(pairs, options, [&](int done, int) { pairs_progress.Update(done); });
  pairs_progress.Finish();
  std::vector<WalkCell> walk;
  if (!frames.empty()) {
    Progress walk_progress("walk", int64_t(frames.size()), common.quiet);
    walk = RunWalkExperiment(frames, options, [&](int done, int) { walk_progress.Update(done); });
    walk_progress.Finish();
  }

  std::vector<std::string> names;
  for (const ImagePair& pair : pairs) names.push_back(pair.name);
  const std::string table = FeatureTable(cells, walk, names, CommandText(arguments));
  OutputFolder out(arguments.out.empty() ? "features" : arguments.out, "features.json");
  out.WriteText("features.md", table);
  out.WriteText("features.json", FeatureJson(cells, walk));
  if (!cv::imwrite((out.path() / "features.png").string(), FeaturePlot(cells)))
    throw MissingResource((out.path() / "features.png").string() + ": cannot be written");
  out.Commit();
  if (common.json) {
    fmt::print("{}", FeatureJson(cells, walk));
  } else if (!common.quiet) {
    fmt::print("{}", table);
  }
  return 0;
}

}  // namespace gaitcam
