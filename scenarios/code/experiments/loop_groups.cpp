#include "scenarios/code/experiments/loop_groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <set>

#include "models/code/yaml/yaml_reader.h"
#include "results/scoring/statistics.h"

namespace gaitcam {
namespace {

using Group = std::vector<const LoopOutcome*>;
using Measure = std::function<double(const LoopOutcome&)>;  ///< NaN: the walk has none.

double Share(int part, int whole) { return whole == 0 ? std::nan("") : 100.0 * part / whole; }
double Precision(const LoopOutcome& o) { return Share(o.right, o.accepted); }
double Recall(const LoopOutcome& o) { return Share(o.right, o.curve.possible); }
double SafeRecall(const LoopOutcome& o) { return 100 * o.curve.recall_at_full_precision; }

struct Spread {
  double low, median, high;  ///< NaN for no walks.
};

Spread SpreadOf(const Group& group, const Measure& measure) {
  std::vector<double> values;
  for (const LoopOutcome* outcome : group)
    if (const double value = measure(*outcome); std::isfinite(value)) values.push_back(value);
  return {QuantileOf(values, 0), MedianOf(values), QuantileOf(values, 1)};
}

std::string Text(const Spread& spread, int decimals) {
  if (!std::isfinite(spread.median)) return "-";
  return fmt::format("{:.{}f} ({:.{}f} to {:.{}f})", spread.median, decimals, spread.low, decimals, spread.high,
                     decimals);
}

/// Numbers by their value, words after them.
struct ByValue {
  bool operator()(const std::string& a, const std::string& b) const {
    const auto x = OptionValue(a).AsNumber(), y = OptionValue(b).AsNumber();
    if (x && y) return *x < *y;
    return x.has_value() != y.has_value() ? x.has_value() : a < b;
  }
};
using Levels = std::set<std::string, ByValue>;

Levels LevelsOfKey(const std::vector<LoopOutcome>& outcomes, size_t key) {
  Levels levels;
  for (const LoopOutcome& outcome : outcomes) levels.insert(outcome.levels[key]);
  return levels;
}

/// In the order in which they were asked.
std::vector<std::string> MethodsOf(const std::vector<LoopOutcome>& outcomes) {
  std::vector<std::string> methods;
  for (const LoopOutcome& outcome : outcomes)
    if (std::find(methods.begin(), methods.end(), outcome.method) == methods.end()) methods.push_back(outcome.method);
  return methods;
}

Group GroupOf(const std::vector<LoopOutcome>& outcomes, const std::string& method,
              const std::vector<std::string>& levels) {
  Group group;
  for (const LoopOutcome& outcome : outcomes)
    if (outcome.method == method && outcome.levels == levels) group.push_back(&outcome);
  return group;
}

constexpr int kPlotWidth_px = 190, kPlotHeight_px = 170, kLeft_px = 46, kAbove_px = 34, kBelow_px = 36, kKey_px = 26;
const cv::Scalar kInk(40, 40, 40), kGrid(225, 225, 225);
const std::array<cv::Scalar, 4> kLines{cv::Scalar(180, 120, 0), cv::Scalar(40, 150, 60), cv::Scalar(40, 40, 210),
                                       cv::Scalar(160, 0, 160)};

void Write(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& bgr = kInk) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.4, bgr, 1, cv::LINE_AA);
}

struct Panel {
  std::string title, x_label;
  Levels x;                        ///< Numbers.
  std::vector<std::string> lines;  ///< Levels of the second key; one empty text if there is none.
  std::function<Spread(const std::string& x, const std::string& line)> at;
};

void Draw(cv::Mat picture, const Panel& panel) {
  const double first = *OptionValue(*panel.x.begin()).AsNumber(), last = *OptionValue(*panel.x.rbegin()).AsNumber();
  const auto place = [&](const std::string& x, double percent) {
    const double part = last > first ? (*OptionValue(x).AsNumber() - first) / (last - first) : 0.5;
    return cv::Point(kLeft_px + int(std::lround(part * kPlotWidth_px)),
                     kAbove_px + int(std::lround((1 - percent / 100) * kPlotHeight_px)));
  };
  for (const int percent : {0, 20, 40, 60, 80, 100}) {
    const int y = place(*panel.x.begin(), percent).y;
    cv::line(picture, {kLeft_px, y}, {kLeft_px + kPlotWidth_px, y}, kGrid);
    Write(picture, std::to_string(percent), {kLeft_px - 32, y + 4});
  }
  for (const std::string& x : panel.x) Write(picture, x, place(x, 0) + cv::Point(-7, 16));
  Write(picture, panel.title, {kLeft_px, kAbove_px - 10});
  Write(picture, panel.x_label, {kLeft_px + 50, kAbove_px + kPlotHeight_px + 31});
  for (size_t line = 0; line < panel.lines.size(); ++line) {
    const cv::Scalar& bgr = kLines[line % kLines.size()];
    const cv::Point beside(4 * int(line) - 2 * int(panel.lines.size() - 1), 0);  // bars of one x side by side
    std::vector<cv::Point> medians;
    for (const std::string& x : panel.x) {
      const Spread spread = panel.at(x, panel.lines[line]);
      if (!std::isfinite(spread.median)) continue;
      cv::line(picture, place(x, spread.low) + beside, place(x, spread.high) + beside, bgr, 1, cv::LINE_AA);
      medians.push_back(place(x, spread.median) + beside);
      cv::circle(picture, medians.back(), 3, bgr, cv::FILLED, cv::LINE_AA);
    }
    cv::polylines(picture, std::vector{medians}, false, bgr, 2, cv::LINE_AA);
  }
}

}  // namespace

std::vector<std::string> LevelsOf(const std::filesystem::path& scenario, const std::vector<std::string>& keys) {
  const OptionValue root = LoadYaml(scenario);
  std::vector<std::string> levels;
  for (const std::string& key : keys) {
    OptionValue value = root;
    for (size_t from = 0; from <= key.size();) {
      const size_t dot = std::min(key.find('.', from), key.size());
      value = value.Child(key.substr(from, dot - from));
      from = dot + 1;
    }
    value = value.WithPath(key);
    if (!value.IsScalar()) value.Fail("is no single number or word of this walk's scenario, which --over needs");
    if (levels.empty() && !value.AsNumber()) value.Fail(value.Shown() + " is not a number, as the first --over needs");
    levels.push_back(value.text());
  }
  return levels;
}

std::string LoopGroupTable(const std::vector<std::string>& keys, const std::vector<LoopOutcome>& outcomes) {
  std::string text = "|", rule = "|";
  for (const std::string& key : keys) {
    text += " " + key + " |";
    rule += "---:|";
  }
  text += " blur, px | method | walks | precision, % | recall, % | area | recall at 100 %, % |\n" + rule +
          "---:|---|---:|---|---|---|---|\n";
  std::set<std::vector<std::string>> seen;
  std::vector<std::vector<std::string>> combinations;
  for (const LoopOutcome& outcome : outcomes)
    if (seen.insert(outcome.levels).second) combinations.push_back(outcome.levels);
  std::sort(combinations.begin(), combinations.end(), [](const auto& a, const auto& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), ByValue());
  });
  for (const auto& levels : combinations) {
    for (const std::string& method : MethodsOf(outcomes)) {
      const Group group = GroupOf(outcomes, method, levels);
      if (group.empty()) continue;
      text += "|";
      for (const std::string& level : levels) text += " " + level + " |";
      text += fmt::format(" {:.1f} | {} | {} | {} | {} | {} | {} |\n",
                          SpreadOf(group, [](const LoopOutcome& o) { return o.blur_px; }).median, method, group.size(),
                          Text(SpreadOf(group, Precision), 1), Text(SpreadOf(group, Recall), 1),
                          Text(SpreadOf(group, [](const LoopOutcome& o) { return o.curve.area; }), 3),
                          Text(SpreadOf(group, SafeRecall), 1));
    }
  }
  return text;
}

cv::Mat DrawLoopGroups(const std::vector<std::string>& keys, const std::vector<LoopOutcome>& outcomes) {
  const std::array<std::pair<std::string, Measure>, 3> measures{
      {{"recall, %", Recall}, {"precision, %", Precision}, {"recall at 100 %", SafeRecall}}};
  const std::vector<std::string> methods = MethodsOf(outcomes);
  std::vector<std::string> lines{""};
  if (keys.size() > 1) {
    const Levels levels = LevelsOfKey(outcomes, 1);
    lines.assign(levels.begin(), levels.end());
  }
  const int width = kLeft_px + kPlotWidth_px + 14, height = kAbove_px + kPlotHeight_px + kBelow_px;
  cv::Mat picture(kKey_px + height * int(measures.size()), width * int(methods.size()), CV_8UC3, cv::Scalar::all(255));
  for (size_t row = 0; row < measures.size(); ++row) {
    for (size_t column = 0; column < methods.size(); ++column) {
      const auto at = [&](const std::string& x, const std::string& line) {
        std::vector<std::string> levels{x};
        if (keys.size() > 1) levels.push_back(line);
        return SpreadOf(GroupOf(outcomes, methods[column], levels), measures[row].second);
      };
      const std::string title = row == 0 ? methods[column] + ": " + measures[row].first : measures[row].first;
      Draw(picture(cv::Rect(int(column) * width, kKey_px + int(row) * height, width, height)),
           {title, keys.front(), LevelsOfKey(outcomes, 0), lines, at});
    }
  }
  for (size_t line = 0; line < lines.size() && keys.size() > 1; ++line)
    Write(picture, keys[1] + " " + lines[line], {kLeft_px + 200 * int(line), 18}, kLines[line % kLines.size()]);
  return picture;
}

std::string LoopOutcomeRows(const std::vector<std::string>& keys, const std::vector<LoopOutcome>& outcomes) {
  std::string text = "walk,method";
  for (const std::string& key : keys) text += "," + key;
  text += ",blur_px,views,possible,accepted,right,area,recall_at_full_precision\n";
  for (const LoopOutcome& o : outcomes) {
    text += fmt::format("\"{}\",\"{}\"", o.walk, o.method);  // two walks' names have a comma between them
    for (const std::string& level : o.levels) text += "," + level;
    text += fmt::format(",{:.2f},{},{},{},{},{:.4f},{:.4f}\n", o.blur_px, o.views, o.curve.possible, o.accepted,
                        o.right, o.curve.area, o.curve.recall_at_full_precision);
  }
  return text;
}

}  // namespace gaitcam
