#include "scenarios/code/experiments/ellipse_plot.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace gaitcam {
namespace {

constexpr int kPlot_px = 380, kMargin_px = 75, kTop_px = 40, kBottom_px = 100;
const cv::Scalar kPlotInk(40, 40, 40), kDots(200, 170, 140), kFrame(190, 190, 190);

void WriteText(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& bgr) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, bgr, 1, cv::LINE_AA);
}

std::vector<Eigen::Vector2d> Outline(const PlottedEllipse& ellipse) {
  constexpr int kPoints = 240;
  constexpr double kSigmas = 2;
  const Eigen::Matrix2d L = ellipse.covariance.llt().matrixL();
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i <= kPoints; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPoints;
    outline.push_back(ellipse.centre + kSigmas * L * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return outline;
}

/// From a panel's coordinates to pixels.
class PlotAxes {
 public:
  PlotAxes(const EllipsePanel& panel, const cv::Rect& plot) : plot_(plot) {
    low_ = high_ = panel.ellipses.front().centre;
    const auto include = [&](const Eigen::Vector2d& p) {
      low_ = low_.cwiseMin(p);
      high_ = high_.cwiseMax(p);
    };
    for (const Eigen::Vector2d& sample : panel.samples) include(sample);
    for (const PlottedEllipse& ellipse : panel.ellipses)
      for (const Eigen::Vector2d& p : Outline(ellipse)) include(p);
    constexpr double kAir = 0.04;
    const Eigen::Vector2d air = kAir * (high_ - low_);
    low_ -= air;
    high_ += air;
  }
  cv::Point At(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d part = (p - low_).cwiseQuotient(high_ - low_);
    return {plot_.x + int(std::lround(part.x() * plot_.width)),
            plot_.br().y - int(std::lround(part.y() * plot_.height))};
  }
  void DrawTicks(cv::Mat& picture) const {
    cv::rectangle(picture, plot_, kFrame);
    for (int axis = 0; axis < 2; ++axis) {
      const double step = Step(high_[axis] - low_[axis]);
      for (double at = std::ceil(low_[axis] / step) * step; at < high_[axis]; at += step) {
        Eigen::Vector2d p = low_;
        p[axis] = at;
        const cv::Point pixel = At(p);
        const std::string text = fmt::format("{:.4g}", std::abs(at) < 1e-9 * step ? 0.0 : at);
        cv::line(picture, pixel, pixel + (axis == 0 ? cv::Point(0, 5) : cv::Point(-5, 0)), kPlotInk);
        WriteText(picture, text, pixel + (axis == 0 ? cv::Point(-14, 20) : cv::Point(-58, 5)), kPlotInk);
      }
    }
  }

 private:
  static double Step(double span) {
    const double power = std::pow(10, std::floor(std::log10(span / 4)));
    for (const double factor : {1.0, 2.0, 5.0})
      if (span / (factor * power) < 6) return factor * power;
    return 10 * power;
  }

  cv::Rect plot_;
  Eigen::Vector2d low_, high_;
};

void DrawEllipse(cv::Mat& picture, const PlotAxes& axes, const PlottedEllipse& ellipse) {
  const std::vector<Eigen::Vector2d> outline = Outline(ellipse);
  constexpr size_t kDash = 6;
  for (size_t i = 0; i + 1 < outline.size(); ++i) {
    if (ellipse.dashed && i / kDash % 2) continue;
    cv::line(picture, axes.At(outline[i]), axes.At(outline[i + 1]), ellipse.bgr, 2, cv::LINE_AA);
  }
  cv::circle(picture, axes.At(ellipse.centre), 4, ellipse.bgr, cv::FILLED, cv::LINE_AA);
}

}  // namespace

PlottedEllipse EllipseOf(const std::vector<Eigen::Vector2d>& samples, const std::string& label, const cv::Scalar& bgr) {
  PlottedEllipse ellipse{label, {0, 0}, Eigen::Matrix2d::Zero(), bgr};
  for (const Eigen::Vector2d& p : samples) ellipse.centre += p / double(samples.size());
  for (const Eigen::Vector2d& p : samples)
    ellipse.covariance += (p - ellipse.centre) * (p - ellipse.centre).transpose() / double(samples.size() - 1);
  return ellipse;
}

cv::Mat DrawPanels(const std::vector<EllipsePanel>& panels) {
  const int width = kPlot_px + kMargin_px + 25;
  cv::Mat picture(kTop_px + kPlot_px + kBottom_px, width * int(panels.size()), CV_8UC3, cv::Scalar::all(255));
  for (size_t i = 0; i < panels.size(); ++i) {
    const EllipsePanel& panel = panels[i];
    const cv::Rect plot(int(i) * width + kMargin_px, kTop_px, kPlot_px, kPlot_px);
    const PlotAxes axes(panel, plot);
    for (const Eigen::Vector2d& sample : panel.samples) cv::circle(picture, axes.At(sample), 1, kDots, cv::FILLED);
    for (const PlottedEllipse& ellipse : panel.ellipses) DrawEllipse(picture, axes, ellipse);
    axes.DrawTicks(picture);
    WriteText(picture, panel.title, plot.tl() + cv::Point(0, -12), kPlotInk);
    WriteText(picture, panel.x_label + " to the right, " + panel.y_label + " up", {plot.x, plot.br().y + 40}, kPlotInk);
    int row = 0;
    for (const PlottedEllipse& ellipse : panel.ellipses)
      WriteText(picture, (ellipse.dashed ? "- - " : "---- ") + ellipse.label, {plot.x, plot.br().y + 58 + 17 * row++},
                ellipse.bgr);
  }
  return picture;
}

}  // namespace gaitcam
