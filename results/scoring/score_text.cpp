#include "results/scoring/score_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

namespace gaitcam {
namespace {

constexpr std::string_view kLive = "live_";

nlohmann::ordered_json JsonOf(const std::vector<Score>& scores) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  for (const Score& score : scores) {
    if (!std::isfinite(score.value)) {
      object[score.name] = nullptr;
    } else if (score.value == std::floor(score.value) && std::abs(score.value) < 1e15 && score.unit.empty()) {
      object[score.name] = int64_t(score.value);
    } else {
      object[score.name] = score.value;
    }
  }
  return object;
}

nlohmann::ordered_json JsonOf(const AlignmentResult& alignment) {
  const Similarity& X = alignment.X_WV;
  const Eigen::Vector4d q = X.rotation.coeffs();
  const Eigen::Vector3d t = X.translation;
  return {{"scale", X.scale},
          {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}},
          {"translation_m", {t.x(), t.y(), t.z()}},
          {"rank", alignment.rank}};
}

}  // namespace

std::string ScoresToJson(const Scores& scores) {
  nlohmann::ordered_json json;
  json["schema"] = "gaitcam.scores.1";
  json["scores"] = JsonOf(scores.scores);
  json["remarks"] = scores.remarks;
  json["alignment"]["se3"] = JsonOf(scores.last.se3);
  json["alignment"]["sim3"] = JsonOf(scores.last.sim3);
  json["timing"] = JsonOf(scores.timing);
  return json.dump(2) + "\n";
}

std::string ScoreText(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  if (value == std::floor(value) && size < 1e9) return fmt::format("{:.0f}", value);
  if (size >= 1e6 || size < 1e-6) return fmt::format("{:.3e}", value);
  const int digits_before = int(std::floor(std::log10(size))) + 1;
  return fmt::format("{:.{}f}", value, std::max(0, std::min(4 - digits_before, 7)));
}

std::vector<ScoreRow> JoinAnswers(const std::vector<Score>& scores) {
  std::map<std::string, double> live;
  for (const Score& score : scores) {
    if (score.name.starts_with(kLive)) live[score.name.substr(kLive.size())] = score.value;
  }
  std::vector<ScoreRow> rows;
  for (const Score& score : scores) {
    if (score.name.starts_with(kLive)) continue;
    const auto other = live.find(score.name);
    rows.push_back({score, other == live.end() ? std::nullopt : std::optional(other->second)});
  }
  return rows;
}

std::string ScoresToTable(const Scores& scores) {
  std::vector<ScoreRow> rows = JoinAnswers(scores.scores);
  for (const Score& score : scores.timing) rows.push_back({score, std::nullopt});
  size_t name_width = 0, value_width = 0, live_width = 0, unit_width = 0;
  for (const ScoreRow& row : rows) {
    name_width = std::max(name_width, row.last.name.size());
    value_width = std::max(value_width, ScoreText(row.last.value).size());
    if (row.live) live_width = std::max({live_width, ScoreText(*row.live).size(), size_t{4}});
    unit_width = std::max(unit_width, row.last.unit.size());
  }
  std::string text;
  if (live_width > 0) {
    value_width = std::max(value_width, size_t{5});
    text = fmt::format("{:<{}}  {:>{}}  {:>{}}\n", "", name_width, "final", value_width, "live", live_width);
  }
  for (const ScoreRow& row : rows) {
    text += fmt::format("{:<{}}  {:>{}}", row.last.name, name_width, ScoreText(row.last.value), value_width);
    if (live_width > 0) text += fmt::format("  {:>{}}", row.live ? ScoreText(*row.live) : "", live_width);
    text += fmt::format(" {:<{}}  {}\n", row.last.unit, unit_width, row.last.meaning);
  }
  for (const std::string& remark : scores.remarks) text += "note: " + remark + "\n";
  return text;
}

}  // namespace gaitcam
