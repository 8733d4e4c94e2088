#include "scenarios/code/experiments/crowd_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace gaitcam {
namespace {

constexpr int kPlotWidth_px = 360, kPlotHeight_px = 260, kLeft_px = 60, kAbove_px = 40, kBelow_px = 50;
const cv::Scalar kAxisInk(40, 40, 40), kGrid(225, 225, 225);

void Label(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& bgr = kAxisInk) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.42, bgr, 1, cv::LINE_AA);
}

void DrawThresholdPanel(cv::Mat picture, const std::vector<double>& thresholds, const ThresholdPanel& panel) {
  constexpr int kLines = 5;
  const double last = 1 / thresholds.front();
  const auto place = [&](double inverse, double value) {
    return cv::Point(kLeft_px + int(std::lround(inverse / last * kPlotWidth_px)),
                     kAbove_px + int(std::lround((1 - value / panel.most) * kPlotHeight_px)));
  };
  for (int i = 0; i <= kLines; ++i) {
    const double value = panel.most * i / kLines, inverse = last * i / kLines;
    cv::line(picture, place(0, value), place(last, value), kGrid);
    Label(picture, fmt::format("{:.3g}", value), place(0, value) + cv::Point(-42, 4));
    Label(picture, fmt::format("{:.3g}", inverse), place(inverse, 0) + cv::Point(-8, 18));
  }
  Label(picture, panel.title, {kLeft_px, 20});
  Label(picture, "1 / threshold", place(0.4 * last, 0) + cv::Point(0, 36));
  for (size_t c = 0; c < panel.curves.size(); ++c) {
    const ThresholdCurve& curve = panel.curves[c];
    for (size_t i = 0; i + 1 < thresholds.size(); ++i)
      if (std::isfinite(curve.values[i]) && std::isfinite(curve.values[i + 1]))
        cv::line(picture, place(1 / thresholds[i], curve.values[i]), place(1 / thresholds[i + 1], curve.values[i + 1]),
                 curve.bgr, 2, cv::LINE_AA);
    Label(picture, curve.label, place(0.62 * last, panel.most) + cv::Point(0, 18 + 18 * int(c)), curve.bgr);
  }
}

}  // namespace

cv::Mat DrawThresholds(const std::vector<double>& thresholds, const std::vector<ThresholdPanel>& panels) {
  const int width = kLeft_px + kPlotWidth_px + 30, height = kAbove_px + kPlotHeight_px + kBelow_px;
  cv::Mat picture(height, width * int(panels.size()), CV_8UC3, cv::Scalar::all(255));
  for (size_t i = 0; i < panels.size(); ++i)
    DrawThresholdPanel(picture(cv::Rect(int(i) * width, 0, width, height)), thresholds, panels[i]);
  return picture;
}

cv::Mat DrawMatches(const cv::Mat& a, const cv::Mat& b, const std::vector<MatchedPosition>& matches,
                    const std::vector<int>& kept) {
  constexpr int kGreyStep = 12, kLines = 40;
  cv::Mat both, picture;
  cv::hconcat(a, b, both);
  for (uchar& grey : cv::Mat_<uchar>(both)) grey = uchar(grey / kGreyStep * kGreyStep);
  cv::cvtColor(both, picture, cv::COLOR_GRAY2BGR);
  const cv::Scalar green(60, 200, 60), red(60, 60, 230);
  const size_t dropped = matches.size() - kept.size();
  for (const bool keep : {true, false}) {
    const size_t stride = 1 + (keep ? kept.size() : dropped) / kLines;
    size_t drawn = 0;
    for (size_t i = 0; i < matches.size(); ++i) {
      if (std::binary_search(kept.begin(), kept.end(), int(i)) != keep) continue;
      const cv::Point p(int(std::lround(matches[i].a.x())), int(std::lround(matches[i].a.y())));
      const cv::Point q(a.cols + int(std::lround(matches[i].b.x())), int(std::lround(matches[i].b.y())));
      if (drawn++ % stride == 0) cv::line(picture, p, q, keep ? green : red, 1, cv::LINE_AA);
      for (const cv::Point& end : {p, q}) cv::circle(picture, end, 2, keep ? green : red, cv::FILLED);
    }
  }
  return picture;
}

}  // namespace gaitcam
