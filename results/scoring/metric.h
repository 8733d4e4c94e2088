/// Metrics as data: the name of a score, what it says and how it is computed are one row of a table.
///
/// A catalogue is a list of rows over one kind of evidence: what was measured of poses (pose_metrics.h), of a mapped
/// floor (floor_score.h), of a topological map (place_graph_score.h). The same rows name the scores before any run and
/// compute them after one.

#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace gaitcam {

/// Which way a score gets better.
enum class Better { kLower, kHigher, kNearOne, kNearZero, kNeither };

/// What a score is about; tables have a heading for each.
enum class ScoreGroup {
  kCoverage,
  kAbsolute,
  kRelative,
  kDrift,
  kScale,
  kRotation,
  kJumps,
  kConsistency,
  kMap,
  kLoops,
  kDrive,
  kTiming
};

/// A heading: "Absolute error".
std::string Title(ScoreGroup group);

struct Score {
  std::string name;
  double value = 0;     ///< NaN where the run does not determine it (null in JSON, "-" in tables).
  std::string unit;     ///< "" for ratios and counts.
  std::string meaning;  ///< One line.
  Better better = Better::kNeither;
  ScoreGroup group = ScoreGroup::kCoverage;
  bool headline = false;  ///< Among the dozen that sum a run up.
};

/// A row of a catalogue.
template <class Evidence>
struct Metric {
  std::string name, unit;
  Better better = Better::kNeither;
  ScoreGroup group = ScoreGroup::kCoverage;
  std::string meaning;
  std::function<double(const Evidence&)> value;
  bool headline = false;
};

template <class Evidence>
std::vector<Score> Evaluate(const std::vector<Metric<Evidence>>& metrics, const Evidence& evidence) {
  std::vector<Score> scores;
  for (const Metric<Evidence>& m : metrics) {
    scores.push_back({m.name, m.value(evidence), m.unit, m.meaning, m.better, m.group, m.headline});
  }
  return scores;
}

/// The scores that a catalogue will give, with NaN for values.
template <class Evidence>
std::vector<Score> NamesOf(const std::vector<Metric<Evidence>>& metrics) {
  std::vector<Score> scores;
  for (const Metric<Evidence>& m : metrics) {
    scores.push_back(
        {m.name, std::numeric_limits<double>::quiet_NaN(), m.unit, m.meaning, m.better, m.group, m.headline});
  }
  return scores;
}

}  // namespace gaitcam
