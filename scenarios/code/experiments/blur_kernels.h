/// How well detectors survive blur that is not a uniform line: one image of a pair blurred along a path as a walk makes
/// it (algorithms/features/synthetic_blur.h), the blur unknown, known, or known to a pixel.

#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "algorithms/features/synthetic_blur.h"
#include "scenarios/code/experiments/feature_experiment.h"

namespace gaitcam {

struct KernelExperimentOptions {
  std::vector<BlurKind> kinds = {BlurKind::kLine, BlurKind::kRamp, BlurKind::kArc, BlurKind::kJitter,
                                 BlurKind::kRotation};
  std::vector<double> extents_px = {10, 20, 30, 40};
  std::vector<std::string> settings = {"noise", "realistic"};  ///< Of CameraSettings.
  uint64_t seed = 1;
  double ratio = 0.8;
  int max_features = 20000;
  int jobs = 0;  ///< Threads; 0: one per core.
};

/// The rows of the table: detectors that see the image alone, and `mobif` that is told more, or made to do one thing.
std::vector<std::string> KernelWays();

/// One image of one pair, blurred; what each way makes of it.
struct KernelTrial {
  std::string pair, setting;
  BlurKind kind = BlurKind::kLine;
  double extent_px = 0;          ///< 0: sharp.
  std::vector<MatchCount> ways;  ///< As KernelWays.
  double confidence = 0;         ///< Of the path that was found (psf_path.h).
  double found_apart_px = 0;     ///< PathDistance of that path and the true one; of a rotation, at the middle.
  bool of_light = false;         ///< The found path's blur acted on light,
  bool straight = false;         ///< or a line explains the image as well.
};

std::vector<KernelTrial> RunKernelExperiment(const std::vector<ImagePair>& pairs,
                                             const KernelExperimentOptions& options,
                                             const std::function<void(int done, int all)>& progress);

/// Sums over the pairs, and how often the confidence came true, in Markdown.
std::string KernelTable(const std::vector<KernelTrial>& trials, const std::string& command);

}  // namespace gaitcam
