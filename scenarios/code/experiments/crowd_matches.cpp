#include "scenarios/code/experiments/crowd_matches.h"

#include <algorithm>
#include <numeric>

#include "algorithms/core/random.h"
#include "algorithms/core/units.h"
#include "algorithms/features/features.h"
#include "algorithms/features/matching.h"
#include "algorithms/geometry/two_view.h"

namespace gaitcam {
namespace {

constexpr int kFeatures = 1500;
constexpr double kNear_px = 6;

RandomStream StreamFor(const JudgedMatches& judged, const std::string& what) {
  return {judged.seed, what + "." + judged.scene + "." + judged.detector + (judged.moving ? ".moving." : ".still.") +
                           std::to_string(judged.pair)};
}

/// Matches that fit one rigid motion within 1.5 px (Sampson).
std::vector<int> KeepByFivePoints(const JudgedMatches& judged) {
  constexpr double kResidual_px = 1.5;
  std::vector<PointPair> pairs;
  for (const MatchedPosition& match : judged.matches)
    pairs.push_back({judged.camera.Unproject(match.a).head<2>(), judged.camera.Unproject(match.b).head<2>()});
  if (pairs.size() < 8) return {};
  RansacOptions options;
  options.threshold = kResidual_px / judged.camera.fx;
  RandomStream random = StreamFor(judged, "five_points");
  return EstimateEssential(pairs, options, random, SampsonError2).inliers;
}

MatchJudge IcgmJudge(const std::string& name, const IcgmOptions& options) {
  return {name, [options](const JudgedMatches& judged) { return KeepByIcgm(judged, options); }};
}

IcgmOptions With(IcgmOptions options, double threshold, bool automatic) {
  options.threshold = threshold;
  options.automatic = automatic;
  return options;
}

double Share(int part, int whole) { return whole > 0 ? double(part) / whole : kNaN; }

}  // namespace

int JudgedMatches::CountRight() const { return int(std::count(truth.begin(), truth.end(), MatchTruth::kRight)); }

Features FindFeatures(const cv::Mat& image, const std::string& detector) {
  return DetectFeatures(*MakeFeature2d(detector, detector == "surf" ? 30 : 10), image, kFeatures);
}

JudgedMatches MatchViews(const CrowdPair& pair, const std::string& detector) {
  const Features a = FindFeatures(pair.a.grey, detector), b = FindFeatures(pair.b.grey, detector);
  JudgedMatches judged;
  judged.detector = detector;
  judged.camera = pair.camera;
  judged.matches = PositionsOf(MatchDescriptors(a.descriptors, b.descriptors, {}), a, b);
  const PairTruth truth(pair);
  for (const MatchedPosition& match : judged.matches) {
    judged.truth.push_back(truth.Of(match.a, match.b));
    judged.errors_px.push_back(truth.Error(match.a, match.b));
  }
  return judged;
}

double FilterScore::Precision() const { return Share(right, kept); }
double FilterScore::NearPrecision() const { return Share(near, kept); }
double FilterScore::Recall() const { return Share(right, all_right); }
double FilterScore::F1() const { return Share(2 * right, kept + all_right); }

FilterScore ScoreOf(const JudgedMatches& judged, const std::vector<int>& kept) {
  FilterScore score;
  score.all_right = judged.CountRight();
  score.kept = int(kept.size());
  for (const int i : kept) {
    const MatchTruth truth = judged.truth[size_t(i)];
    score.right += truth == MatchTruth::kRight;
    score.movers += truth == MatchTruth::kMover;
    score.near += truth != MatchTruth::kMover && judged.errors_px[size_t(i)] <= kNear_px;
  }
  return score;
}

std::vector<int> KeepByIcgm(const JudgedMatches& judged, const IcgmOptions& options, int draw) {
  if (judged.matches.size() < 2) return {};
  RandomStream random = StreamFor(judged, "icgm" + std::to_string(draw));
  return FilterByGravity(judged.matches, options, random).kept;
}

std::vector<MatchJudge> CrowdFilters() {
  const IcgmOptions faithful, ours = IcgmOptions::Consensus();
  return {{"none",
           [](const JudgedMatches& judged) {
             std::vector<int> all(judged.matches.size());
             std::iota(all.begin(), all.end(), 0);
             return all;
           }},
          IcgmJudge("ICGM, 0.08", faithful),
          IcgmJudge("ICGM, 0.2", With(faithful, 0.2, false)),
          IcgmJudge("ICGM, automatic", With(faithful, 0, true)),
          IcgmJudge("consensus, 0.12", ours),
          IcgmJudge("consensus, automatic", With(ours, 0, true)),
          {"five points", KeepByFivePoints}};
}

std::vector<double> FixedThresholds() {
  std::vector<double> thresholds;
  for (double threshold = 0.025; threshold < 0.5; threshold *= 1.12) thresholds.push_back(threshold);
  return thresholds;
}

}  // namespace gaitcam
