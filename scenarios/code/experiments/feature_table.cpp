#include "scenarios/code/experiments/feature_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

namespace gaitcam {
namespace {

/// The distinct values of one field, in the order of their first appearance.
template <class T, class Field>
std::vector<T> Distinct(const std::vector<FeatureCell>& cells, Field field) {
  std::vector<T> values;
  for (const FeatureCell& cell : cells)
    if (std::find(values.begin(), values.end(), cell.*field) == values.end()) values.push_back(cell.*field);
  return values;
}

const MatchCount* Find(const std::vector<FeatureCell>& cells, const FeatureCell& like) {
  for (const FeatureCell& cell : cells)
    if (cell.detector == like.detector && cell.setting == like.setting && cell.extent_px == like.extent_px &&
        cell.ratio == like.ratio && cell.both == like.both)
      return &cell.count;
  return nullptr;
}

/// "1234 (5.6)": correct matches, and the factor over SIFT.
std::string CorrectText(const std::vector<FeatureCell>& cells, const FeatureCell& like) {
  const MatchCount* count = Find(cells, like);
  if (!count) return "-";
  FeatureCell of_sift = like;
  of_sift.detector = "sift";
  const MatchCount* sift = Find(cells, of_sift);
  if (!sift || sift->correct == 0) return fmt::format("{}", count->correct);
  return fmt::format("{} ({:.2f})", count->correct, double(count->correct) / sift->correct);
}

std::string QualityText(const std::vector<FeatureCell>& cells, const FeatureCell& like) {
  const MatchCount* count = Find(cells, like);
  if (!count) return "-";
  if (count->correct == 0) return fmt::format("{:.0f} %", 100 * count->Precision());
  return fmt::format("{:.0f} %, {:.2f} px", 100 * count->Precision(), count->MedianError());
}

std::string FewestText(const std::vector<FeatureCell>& cells, const FeatureCell& like) {
  const MatchCount* count = Find(cells, like);
  return count ? std::to_string(count->fewest_points) : "-";
}

/// One row per detector, one column per extent and number of blurred images.
template <class Text>
std::string Grid(const std::vector<FeatureCell>& cells, const std::string& setting, double ratio, Text text) {
  const std::vector<double> extents = Distinct<double>(cells, &FeatureCell::extent_px);
  std::string head = "| detector |", line = "|---|";
  for (const double extent : extents) {
    head += extent > 0 ? fmt::format(" {0:.0f} px, one | {0:.0f} px, both |", extent) : " sharp |";
    line += extent > 0 ? "---:|---:|" : "---:|";
  }
  std::string rows;
  for (const std::string& detector : Distinct<std::string>(cells, &FeatureCell::detector)) {
    rows += "| " + detector + " |";
    for (const double extent : extents)
      for (const bool both : {false, true})
        if (extent > 0 || !both) rows += " " + text(cells, {detector, setting, extent, ratio, both, {}}) + " |";
    rows += "\n";
  }
  return head + "\n" + line + "\n" + rows + "\n";
}

std::string WalkTable(const std::vector<WalkCell>& walk) {
  if (walk.empty()) return "";
  std::string text =
      "## Frames of a walk\n\nReal blur of a walking robot's camera, the greater median of the two frames; true "
      "correspondences from depth and pose. Ratio 0.8. Correct matches per pair of frames, in how many pairs there are "
      "more than `sift` has, precision, median error.\n\n"
      "| median blur | pairs | detector | correct per pair | more than SIFT | precision | error |\n"
      "|---|---:|---|---:|---:|---:|---:|\n";
  for (const WalkCell& cell : walk)
    text += fmt::format("| {} | {} | {} | {:.1f} | {} | {:.0f} % | {:.2f} px |\n",
                        cell.to_px < 1e6 ? fmt::format("{:.0f} to {:.0f} px", cell.from_px, cell.to_px)
                                         : fmt::format("{:.0f} px and more", cell.from_px),
                        cell.pairs, cell.detector, double(cell.count.correct) / cell.pairs,
                        cell.more_than_sift ? std::to_string(*cell.more_than_sift) : "-", 100 * cell.count.Precision(),
                        cell.count.MedianError());
  return text + "\n";
}

}  // namespace

std::string FeatureTable(const std::vector<FeatureCell>& cells, const std::vector<WalkCell>& walk,
                         const std::vector<std::string>& pairs, const std::string& command) {
  std::string text = "# Features on blurred images\n\nMade by `" + command + "`.\n\n";
  if (cells.empty()) return text + WalkTable(walk);
  text += "Image pairs: ";
  for (size_t i = 0; i < pairs.size(); ++i) text += (i ? ", " : "") + pairs[i];
  text += fmt::format(
      ". A line blur of the given extent in a direction drawn from the seed, on one image or on both (in different "
      "directions), then {} px cut off each side. clean: grey values added up; noise: with noise of sigma 2; "
      "realistic: "
      "light added up, noise of sigma 2, JPEG 90. Nearest neighbour with the ratio test, no other filter; duplicates "
      "removed; correct: within {:.0f} px of the true homography. Sums over all pairs; in brackets the factor over "
      "`sift`.\n\n",
      kCrop_px, kCorrect_px);
  for (const std::string& setting : Distinct<std::string>(cells, &FeatureCell::setting))
    for (const double ratio : Distinct<double>(cells, &FeatureCell::ratio)) {
      text += fmt::format("## {}, ratio {}\n\nCorrect matches.\n\n", setting, ratio);
      text += Grid(cells, setting, ratio, CorrectText);
      text += "Precision and median error of the correct ones.\n\n" + Grid(cells, setting, ratio, QualityText);
    }
  text += "## Key points in the image that had the fewest, " + cells.front().setting + "\n\n" +
          Grid(cells, cells.front().setting, cells.front().ratio, FewestText);
  return text + WalkTable(walk);
}

std::string FeatureJson(const std::vector<FeatureCell>& cells, const std::vector<WalkCell>& walk) {
  const auto numbers = [](const MatchCount& count, nlohmann::ordered_json& out) {
    out["matches"] = count.matches;
    out["correct"] = count.correct;
    if (count.correct > 0) out["median_error_px"] = count.MedianError();
  };
  nlohmann::ordered_json json;
  json["pairs"] = nlohmann::ordered_json::array();
  json["walk"] = nlohmann::ordered_json::array();
  for (const FeatureCell& cell : cells) {
    nlohmann::ordered_json out = {{"detector", cell.detector},
                                  {"setting", cell.setting},
                                  {"extent_px", cell.extent_px},
                                  {"ratio", cell.ratio},
                                  {"both", cell.both}};
    numbers(cell.count, out);
    json["pairs"].push_back(out);
  }
  for (const WalkCell& cell : walk) {
    nlohmann::ordered_json out = {{"detector", cell.detector}, {"blur_from_px", cell.from_px}, {"pairs", cell.pairs}};
    if (cell.more_than_sift) out["pairs_with_more_than_sift"] = *cell.more_than_sift;
    numbers(cell.count, out);
    json["walk"].push_back(out);
  }
  return json.dump(1) + "\n";
}

namespace {

const cv::Scalar kInk(40, 40, 40), kFaint(220, 220, 220);

/// Colours that differ, whatever their number.
cv::Scalar Colour(size_t i, size_t n) {
  cv::Mat hsv(1, 1, CV_8UC3, cv::Scalar(double(180 * i / n), 255, i % 2 ? 140 : 210)), bgr;
  cv::cvtColor(hsv, bgr, cv::COLOR_HSV2BGR);
  const cv::Vec3b c = bgr.at<cv::Vec3b>(0);
  return {double(c[0]), double(c[1]), double(c[2])};
}

void Write(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& colour) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv::LINE_AA);
}

/// One setting's curves in a rectangle of the picture.
void DrawPanel(cv::Mat& picture, const cv::Rect& panel, const std::vector<FeatureCell>& cells,
               const std::string& setting, double decades) {
  const std::vector<double> extents = Distinct<double>(cells, &FeatureCell::extent_px);
  const std::vector<std::string> detectors = Distinct<std::string>(cells, &FeatureCell::detector);
  const double ratio = cells.front().ratio, last = std::max(1.0, extents.back());
  const auto place = [&](double extent, double count) {
    const double height = std::log10(std::max(count, 1.0)) / decades;
    return cv::Point(panel.x + int(extent / last * panel.width), panel.br().y - int(height * panel.height));
  };
  for (int d = 0; d <= int(decades); ++d) {
    const double count = std::pow(10, d);
    cv::line(picture, place(0, count), place(last, count), kFaint);
    Write(picture, fmt::format("{:.0f}", count), place(0, count) - cv::Point(48, -4), kInk);
  }
  for (const double extent : extents)
    Write(picture, fmt::format("{:.0f}", extent), place(extent, 1) + cv::Point(-6, 18), kInk);
  Write(picture, setting + ": correct matches over blur (px)", panel.tl() + cv::Point(0, -12), kInk);
  for (size_t d = 0; d < detectors.size(); ++d)
    for (size_t e = 0; e + 1 < extents.size(); ++e) {
      const MatchCount* a = Find(cells, {detectors[d], setting, extents[e], ratio, false, {}});
      const MatchCount* b = Find(cells, {detectors[d], setting, extents[e + 1], ratio, false, {}});
      if (a && b)
        cv::line(picture, place(extents[e], a->correct), place(extents[e + 1], b->correct), Colour(d, detectors.size()),
                 2, cv::LINE_AA);
    }
}

}  // namespace

cv::Mat FeaturePlot(const std::vector<FeatureCell>& cells) {
  constexpr int kPanel_px = 330, kGap_px = 90, kLegend_px = 150;
  const std::vector<std::string> settings = Distinct<std::string>(cells, &FeatureCell::setting);
  const std::vector<std::string> detectors = Distinct<std::string>(cells, &FeatureCell::detector);
  int most = 10;
  for (const FeatureCell& cell : cells) most = std::max(most, cell.count.correct);
  const int width = int(settings.size()) * (kPanel_px + kGap_px);
  cv::Mat picture(kPanel_px + 100, width + kLegend_px, CV_8UC3, cv::Scalar::all(255));
  for (size_t s = 0; s < settings.size(); ++s)
    DrawPanel(picture, {int(s) * (kPanel_px + kGap_px) + 60, 50, kPanel_px, kPanel_px}, cells, settings[s],
              std::log10(double(most)));
  for (size_t d = 0; d < detectors.size(); ++d)
    Write(picture, detectors[d], {width + 10, 60 + int(d) * 22}, Colour(d, detectors.size()));
  return picture;
}

}  // namespace gaitcam
