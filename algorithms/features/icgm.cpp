#include "algorithms/features/icgm.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "algorithms/core/errors.h"
#include "algorithms/features/icgm_consensus.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

/// Centres of gravity of the kept matches in both images (Hua, Eq. 4.15), one match more at a time.
class Gravity {
 public:
  void Add(const MatchedPosition& match) {
    ++count_;
    centre_.a += (match.a - centre_.a) / count_;
    centre_.b += (match.b - centre_.b) / count_;
  }
  /// Of the vectors to the match (Hua, Eqs. 4.16 and 4.19).
  double RatioOf(const MatchedPosition& match) const { return RatioOf(match.a, match.b); }
  double RatioOf(const Vector2d& a, const Vector2d& b) const { return RatioOfDifference(centre_.a - a, centre_.b - b); }

 private:
  int count_ = 0;
  MatchedPosition centre_;
};

/// Hua, Algorithm 1. It calls its first two robust but does not put them out: here they are.
std::vector<int> GrowFromRandomPair(const std::vector<MatchedPosition>& matches, double threshold, int max_draws,
                                    RandomStream& random) {
  const int n = int(matches.size());
  for (int draw = 0; draw < max_draws; ++draw) {
    const int i = random.Index(n), j = random.Index(n);
    const MatchedPosition &p = matches[size_t(i)], &q = matches[size_t(j)];
    if (i == j || RatioOfDifference(p.a - q.a, p.b - q.b) > threshold) continue;
    Gravity gravity;
    gravity.Add(p);
    gravity.Add(q);
    std::vector<int> kept;
    for (int k = 0; k < n; ++k) {
      const bool first = k == i || k == j;
      if (!first && gravity.RatioOf(matches[size_t(k)]) > threshold) continue;
      kept.push_back(k);
      if (!first) gravity.Add(matches[size_t(k)]);
    }
    return kept;
  }
  return {};
}

void CheckMatches(const std::vector<MatchedPosition>& matches) {
  if (matches.size() < 2)
    throw BadInput("icgm: " + std::to_string(matches.size()) + (matches.size() == 1 ? " match" : " matches") +
                   "; expected 2 or more");
  for (size_t i = 0; i < matches.size(); ++i)
    if (!matches[i].a.allFinite() || !matches[i].b.allFinite())
      throw BadInput("icgm: match " + std::to_string(i) + " lies nowhere; expected finite positions");
}

/// The share of ascending values that are not above a limit.
double ShareUpTo(const std::vector<double>& values, double limit) {
  return double(std::upper_bound(values.begin(), values.end(), limit) - values.begin()) / double(values.size());
}

/// What to expect of thresholds, from the ratios of the matches and of pairs at random, both ascending.
class ExpectedF1 {
 public:
  ExpectedF1(const std::vector<double>& ratios, const std::vector<double>& random) : ratios_(ratios), random_(random) {
    const double middle = random[random.size() / 2];
    const double random_beyond = 1 - ShareUpTo(random, middle);
    if (random_beyond > 0) wrong_ = std::min(1.0, (1 - ShareUpTo(ratios, middle)) / random_beyond);
  }
  double At(double threshold) const {
    const double kept = ShareUpTo(ratios_, threshold);
    const double right = kept - std::min(kept, wrong_ * ShareUpTo(random_, threshold));
    return right > 0 ? 2 * right / (kept + (1 - wrong_)) : 0;
  }

 private:
  const std::vector<double>&ratios_, &random_;
  double wrong_ = 0;  ///< Share of the matches.
};

}  // namespace

IcgmOptions IcgmOptions::Consensus() {
  IcgmOptions options;
  options.start = IcgmStart::kConsensus;
  options.threshold = 0.12;
  return options;
}

std::vector<MatchedPosition> PositionsOf(const std::vector<Match>& matches, const Features& a, const Features& b) {
  std::vector<MatchedPosition> positions;
  for (const Match& match : matches) {
    const cv::Point2f &p = a.keypoints[size_t(match.a)].pt, &q = b.keypoints[size_t(match.b)].pt;
    positions.push_back({{p.x, p.y}, {q.x, q.y}});
  }
  return positions;
}

double RatioOfDifference(const Vector2d& x, const Vector2d& y) {
  const double lengths = x.norm() + y.norm();
  return lengths > 0 ? std::min(1.0, (x - y).norm() / lengths) : 0;
}

double AutomaticThreshold(const std::vector<MatchedPosition>& matches, const IcgmOptions& options) {
  constexpr double kLoose = 0.12, kNearBest = 0.02;
  constexpr int kShuffles = 20;
  const int n = int(matches.size());
  const std::vector<char> core = Agreement(matches, kLoose, options.noise_px).Core();
  Gravity gravity;
  for (int i = 0; i < n; ++i)
    if (core[size_t(i)] != 0) gravity.Add(matches[size_t(i)]);
  std::vector<double> ratios, random;
  for (int i = 0; i < n; ++i) {
    ratios.push_back(gravity.RatioOf(matches[size_t(i)]));
    for (int k = 0; k < kShuffles; ++k) {
      const int j = int((int64_t(i) + 1 + int64_t(k) * (n - 1) / kShuffles) % n);  // never i
      random.push_back(gravity.RatioOf(matches[size_t(i)].a, matches[size_t(j)].b));
    }
  }
  std::sort(ratios.begin(), ratios.end());
  std::sort(random.begin(), random.end());
  const ExpectedF1 expected(ratios, random);
  double best = 0;
  for (const double ratio : ratios) best = std::max(best, expected.At(ratio));
  for (const double ratio : ratios)
    if (expected.At(ratio) >= best - kNearBest) return ratio;
  return ratios.back();
}

IcgmResult FilterByGravity(const std::vector<MatchedPosition>& matches, const IcgmOptions& options,
                           RandomStream& random) {
  CheckMatches(matches);
  IcgmResult result;
  result.threshold = options.automatic ? AutomaticThreshold(matches, options) : options.threshold;
  result.kept = options.start == IcgmStart::kConsensus
                    ? KeepByConsensus(matches, result.threshold, options)
                    : GrowFromRandomPair(matches, result.threshold, options.max_draws, random);
  return result;
}

std::vector<Match> FilterByGravity(const std::vector<Match>& matches, const Features& a, const Features& b,
                                   const IcgmOptions& options, RandomStream& random) {
  std::vector<Match> kept;
  if (matches.size() < 2) return kept;
  for (const int i : FilterByGravity(PositionsOf(matches, a, b), options, random).kept)
    kept.push_back(matches[size_t(i)]);
  return kept;
}

}  // namespace gaitcam
