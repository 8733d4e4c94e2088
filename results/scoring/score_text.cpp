#include "results/scoring/score_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace gaitcam {
namespace {

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
  json["alignment"]["se3"] = JsonOf(scores.se3);
  json["alignment"]["sim3"] = JsonOf(scores.sim3);
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

std::string ScoresToTable(const Scores& scores) {
  size_t name_width = 0, value_width = 0, unit_width = 0;
  for (const std::vector<Score>* list : {&scores.scores, &scores.timing}) {
    for (const Score& s : *list) {
      name_width = std::max(name_width, s.name.size());
      value_width = std::max(value_width, ScoreText(s.value).size());
      unit_width = std::max(unit_width, s.unit.size());
    }
  }
  std::string text;
  for (const std::vector<Score>* list : {&scores.scores, &scores.timing}) {
    for (const Score& s : *list) {
      text += fmt::format("{:<{}}  {:>{}} {:<{}}  {}\n", s.name, name_width, ScoreText(s.value), value_width, s.unit,
                          unit_width, s.meaning);
    }
  }
  for (const std::string& remark : scores.remarks) text += "note: " + remark + "\n";
  return text;
}

}  // namespace gaitcam
