/// The results of a study: one row per run, and its tables as text. A study runs every combination of the levels of
/// some axes (the conditions) with the same seeds.

#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "results/scoring/score.h"

namespace gaitcam {

/// A factor that is varied.
struct StudyAxis {
  std::string key;                  ///< "camera.exposure_ms"; "condition" where conditions were listed one by one.
  std::vector<std::string> levels;  ///< As the file writes them, shortened where they are maps.
  size_t reference = 0;             ///< Effects are differences from this level.

  /// "exposure, ms": the key's last part in words, and its unit.
  std::string Title() const;
  /// The levels as numbers; empty if one of them is not a number.
  std::vector<double> Numbers() const;
};

struct StudyRun {
  std::vector<size_t> levels;  ///< One index per axis.
  uint64_t seed = 0;
  std::string hash;
  std::string status;                    ///< "finished", "fell", or "failed" if there is no result at all.
  std::string failure;                   ///< Why the system stopped, why nothing could be scored, or why it failed.
  double blur_median_px = 0;             ///< NaN if there is no result.
  std::string renderer;                  ///< Who rendered the frames, in one line; empty if there is no result.
  int64_t frames = 0;                    ///< That the system was given.
  std::map<std::string, double> scores;  ///< Empty if there is no result; only coverage if too little was covered.
  std::map<std::string, double> timing;

  /// NaN if there is no such score.
  double Value(const std::string& score) const;
};

struct StudyTable {
  std::string name, description;
  std::vector<StudyAxis> axes;
  std::vector<std::string> score_names;  ///< Columns, in the order of score tables.
  std::vector<Score> metrics;            ///< The scores that summary, effects and page show; their values are not used.
  std::vector<StudyRun> runs;            ///< By condition, the first axis slowest, then by seed.
  size_t seeds = 1;                      ///< Per condition.

  size_t conditions() const { return runs.size() / seeds; }
};

/// runs.csv: condition, seed, hash, status, failure, blur, frames and every score; the same bytes for the same runs.
std::string RunsCsv(const StudyTable& table);
/// timings.csv: what differs from run to run.
std::string TimingsCsv(const StudyTable& table);

/// A field of a CSV file, in quotes if it must be.
std::string CsvField(const std::string& text);
/// The shortest text that reads back as the same number; empty for NaN.
std::string CsvNumber(double value);

}  // namespace gaitcam
