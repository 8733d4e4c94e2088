/// The largest set of matches that agree with each other about how their vectors changed; parts of icgm.h.

#pragma once

#include <vector>

#include "algorithms/features/icgm.h"

namespace gaitcam {

/// Which pairs of matches agree: |(a_i - a_j) - (b_i - b_j)| <= threshold (|a_i - a_j| + |b_i - b_j|) + noise_px.
class Agreement {
 public:
  Agreement(const std::vector<MatchedPosition>& matches, double threshold, double noise_px);
  bool Between(int i, int j) const { return agrees_(i, j) != 0; }
  /// With how many of a set a match agrees, itself left out. @param in 1 for those in the set, else 0.
  int Count(int i, const std::vector<char>& in) const;
  /// Taking out who agrees with fewest, until each agrees with half of the others: 1 for those that are left.
  std::vector<char> Core() const;

 private:
  Eigen::Matrix<unsigned char, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> agrees_;
};

/// Indices of what start consensus keeps, ascending (FilterByGravity).
std::vector<int> KeepByConsensus(const std::vector<MatchedPosition>& matches, double threshold,
                                 const IcgmOptions& options);

}  // namespace gaitcam
