#include "results/scoring/association.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <tuple>

namespace gaitcam {
namespace {

int64_t NanosecondsOf(double milliseconds) { return std::llround(milliseconds * 1e6); }

/// One admissible pair, and the best chain of pairs that ends with it.
struct Link {
  IndexPair pair;
  int64_t gain = 0;  ///< Sum of (max_difference - |difference|) along the chain, ns.
  int64_t length = 0;
  int64_t previous = -1;  ///< The link before it in the chain.
};

bool IsBetter(const Link& a, const Link& b) { return std::tie(a.gain, a.length) > std::tie(b.gain, b.length); }

/// Best link so far over all truth indices below a bound: a Fenwick tree of prefix maxima.
class BestChain {
 public:
  BestChain(size_t size, const std::vector<Link>& links) : tree_(size + 1, -1), links_(links) {}

  int64_t Below(size_t truth) const {
    int64_t best = -1;
    for (size_t k = truth; k > 0; k -= k & (~k + 1)) best = Better(best, tree_[k]);
    return best;
  }
  void Insert(int64_t link) {
    for (size_t k = links_[link].pair.truth + 1; k < tree_.size(); k += k & (~k + 1)) tree_[k] = Better(tree_[k], link);
  }

 private:
  int64_t Better(int64_t a, int64_t b) const {
    if (a < 0 || b < 0) return std::max(a, b);
    return IsBetter(links_[b], links_[a]) ? b : a;
  }
  std::vector<int64_t> tree_;
  const std::vector<Link>& links_;
};

std::vector<IndexPair> OneToOne(const std::vector<int64_t>& truth, const std::vector<int64_t>& estimate,
                                int64_t tolerance) {
  std::vector<Link> links;
  BestChain chains(truth.size(), links);
  int64_t best = -1;
  size_t first = 0;  // first truth index within reach of the current estimate
  for (size_t e = 0; e < estimate.size(); ++e) {
    while (first < truth.size() && truth[first] < estimate[e] - tolerance) ++first;
    const size_t new_links = links.size();
    for (size_t t = first; t < truth.size() && truth[t] <= estimate[e] + tolerance; ++t) {
      const int64_t before = chains.Below(t);
      Link link{{t, e}, tolerance - std::abs(truth[t] - estimate[e]), 1, before};
      if (before >= 0) {
        link.gain += links[before].gain;
        link.length += links[before].length;
      }
      links.push_back(link);
    }
    for (size_t k = new_links; k < links.size(); ++k) {
      chains.Insert(int64_t(k));
      if (best < 0 || IsBetter(links[k], links[best])) best = int64_t(k);
    }
  }
  std::vector<IndexPair> pairs;
  for (int64_t k = best; k >= 0; k = links[k].previous) pairs.push_back(links[k].pair);
  std::reverse(pairs.begin(), pairs.end());
  return pairs;
}

/// Index of the stamp nearest to `stamp`, the earlier of two that are equally near.
size_t NearestIndex(const std::vector<int64_t>& stamps, int64_t stamp) {
  const auto after = std::lower_bound(stamps.begin(), stamps.end(), stamp);
  if (after == stamps.end()) return stamps.size() - 1;
  if (after != stamps.begin() && stamp - *(after - 1) <= *after - stamp) return size_t(after - stamps.begin()) - 1;
  return size_t(after - stamps.begin());
}

std::vector<IndexPair> Nearest(const std::vector<int64_t>& truth, const std::vector<int64_t>& estimate,
                               int64_t tolerance) {
  std::vector<IndexPair> pairs;
  if (truth.empty() || estimate.empty()) return pairs;
  const bool estimate_is_longer = estimate.size() > truth.size();
  const std::vector<int64_t>& shorter = estimate_is_longer ? truth : estimate;
  const std::vector<int64_t>& longer = estimate_is_longer ? estimate : truth;
  for (size_t s = 0; s < shorter.size(); ++s) {
    const size_t l = NearestIndex(longer, shorter[s]);
    if (std::abs(longer[l] - shorter[s]) > tolerance) continue;
    pairs.push_back(estimate_is_longer ? IndexPair{s, l} : IndexPair{l, s});
  }
  return pairs;
}

}  // namespace

std::vector<IndexPair> Associate(const std::vector<int64_t>& truth_ns, const std::vector<int64_t>& estimate_ns,
                                 const AssociationOptions& options) {
  CheckFields(options, "association.");
  std::vector<int64_t> shifted = estimate_ns;
  for (int64_t& stamp : shifted) stamp += NanosecondsOf(options.time_offset_ms);
  const int64_t tolerance = NanosecondsOf(options.max_difference_ms);
  return options.rule == AssociationRule::kNearest ? Nearest(truth_ns, shifted, tolerance)
                                                   : OneToOne(truth_ns, shifted, tolerance);
}

std::vector<PosePair> AssociatePoses(const std::vector<FrameEstimate>& answer, const Trajectory& truth,
                                     const AssociationOptions& options) {
  CheckStampsIncrease(truth, "truth");
  CheckStampsIncrease(PosesOf(answer), "estimate");
  std::vector<int64_t> truth_ns, estimate_ns;
  std::vector<const FrameEstimate*> posed;
  for (const StampedPose& p : truth) truth_ns.push_back(p.stamp_ns);
  for (const FrameEstimate& frame : answer) {
    if (!frame.pose) continue;
    estimate_ns.push_back(frame.stamp_ns + frame.pose_delay_ns);
    posed.push_back(&frame);
  }
  std::vector<int64_t> partner(posed.size(), -1);
  for (const IndexPair& k : Associate(truth_ns, estimate_ns, options)) partner[k.estimate] = int64_t(k.truth);
  const int64_t offset_ns = NanosecondsOf(options.time_offset_ms), max_gap_ns = NanosecondsOf(options.max_gap_ms);
  std::vector<PosePair> pairs;
  for (size_t i = 0; i < posed.size(); ++i) {
    const FrameEstimate& frame = *posed[i];
    const int64_t stamp_ns = estimate_ns[i] + offset_ns;
    std::optional<Pose> there;
    if (options.rule == AssociationRule::kInterpolated) there = SmoothPoseAt(truth, stamp_ns, max_gap_ns);
    if (there) {
      pairs.push_back({stamp_ns, *there, *frame.pose, frame.covariance, frame.own_covariance, frame.common_errors});
    } else if (partner[i] >= 0) {
      const StampedPose& nearest = truth[size_t(partner[i])];
      pairs.push_back(
          {nearest.stamp_ns, nearest.pose, *frame.pose, frame.covariance, frame.own_covariance, frame.common_errors});
    }
  }
  return pairs;
}

}  // namespace gaitcam
