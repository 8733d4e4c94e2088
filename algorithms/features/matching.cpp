#include "algorithms/features/matching.h"

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ConstMap = Eigen::Map<const Matrix, 0, Eigen::OuterStride<>>;

ConstMap View(const cv::Mat& descriptors) {
  GAITCAM_ASSERT(descriptors.type() == CV_32FC1);
  return {descriptors.ptr<float>(), descriptors.rows, descriptors.cols,
          Eigen::OuterStride<>(Eigen::Index(descriptors.step1()))};
}

/// Squared distances |a_i - b_j|^2 = |a_i|^2 + |b_j|^2 - 2 a_i.b_j: one matrix product instead of a double loop.
Matrix SquaredDistances(const cv::Mat& a, const cv::Mat& b) {
  const ConstMap A = View(a), B = View(b);
  const Eigen::VectorXf norm_a = A.rowwise().squaredNorm(), norm_b = B.rowwise().squaredNorm();
  Matrix D = -2.0f * (A * B.transpose());
  D.colwise() += norm_a;
  D.rowwise() += norm_b.transpose();
  return D.cwiseMax(0.0f);
}

}  // namespace

std::vector<Match> MatchDescriptors(const cv::Mat& a, const cv::Mat& b, const MatchingOptions& options) {
  std::vector<Match> matches;
  if (a.empty() || b.empty()) return matches;
  GAITCAM_ASSERT(a.cols == b.cols);
  const Matrix D = SquaredDistances(a, b);
  std::vector<int> nearest_of_b(size_t(b.rows), -1);
  for (int j = 0; j < b.rows; ++j) {
    Eigen::Index i = 0;
    D.col(j).minCoeff(&i);
    nearest_of_b[size_t(j)] = int(i);
  }
  const float ratio_squared = float(options.ratio * options.ratio);
  for (int i = 0; i < a.rows; ++i) {
    float best = std::numeric_limits<float>::infinity(), second = best;
    int best_j = -1;
    for (int j = 0; j < b.rows; ++j) {
      const float d = D(i, j);
      if (d < best) {
        second = best;
        best = d;
        best_j = j;
      } else if (d < second) {
        second = d;
      }
    }
    if (options.ratio < 1 && !(best < ratio_squared * second)) continue;
    if (options.mutual && nearest_of_b[size_t(best_j)] != i) continue;
    matches.push_back({i, best_j, std::sqrt(best)});
  }
  return matches;
}

}  // namespace gaitcam
