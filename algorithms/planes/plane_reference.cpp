#include "algorithms/planes/plane_reference.h"

#include <algorithm>
#include <utility>

namespace gaitcam {

std::vector<Eigen::Vector2d> SelectPixels(const PyramidLevel& level, const cv::Mat& mask, size_t k, size_t max_points) {
  constexpr float kMinGradient_grey = 1;  // per pixel
  constexpr int kBlock_px = 8, kMargin_px = 2;
  struct Candidate {
    float strength;
    uint16_t u, v;
    bool operator<(const Candidate& b) const {  // the stronger, then the upper, left one first
      return strength != b.strength ? strength > b.strength : std::pair(v, u) < std::pair(b.v, b.u);
    }
  };
  const int blocks_across = level.width() / kBlock_px + 1;
  std::vector<std::vector<Candidate>> blocks(size_t(blocks_across) * size_t(level.height() / kBlock_px + 1));
  for (int v = kMargin_px; v < level.height() - kMargin_px; ++v) {
    const uchar* inside = mask.ptr<uchar>(std::min(v << k, mask.rows - 1));
    const cv::Vec3f* row = level.samples.ptr<cv::Vec3f>(v);
    for (int u = kMargin_px; u < level.width() - kMargin_px; ++u) {
      if (inside[std::min(u << k, mask.cols - 1)] == 0) continue;
      const float strength = row[u][1] * row[u][1] + row[u][2] * row[u][2];
      if (strength < kMinGradient_grey * kMinGradient_grey) continue;
      std::vector<Candidate>& block = blocks[size_t(v / kBlock_px * blocks_across + u / kBlock_px)];
      if (block.empty()) block.reserve(kBlock_px * kBlock_px);
      block.push_back({strength, uint16_t(u), uint16_t(v)});
    }
  }
  std::vector<Eigen::Vector2d> points;
  points.reserve(max_points);
  std::vector<Candidate> round;
  for (size_t rank = 0; points.size() < max_points; ++rank) {
    round.clear();
    for (std::vector<Candidate>& block : blocks) {
      if (block.size() <= rank) continue;
      std::iter_swap(block.begin() + long(rank), std::min_element(block.begin() + long(rank), block.end()));
      round.push_back(block[rank]);
    }
    if (round.empty()) break;
    if (round.size() > max_points - points.size()) {
      std::nth_element(round.begin(), round.begin() + long(max_points - points.size()), round.end());
      round.resize(max_points - points.size());
    }
    for (const Candidate& c : round) points.emplace_back(c.u, c.v);
  }
  return points;
}

}  // namespace gaitcam
