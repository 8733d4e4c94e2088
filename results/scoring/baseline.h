/// What a suite measured when it was last accepted: results/baselines/SUITE.json, committed beside the code.
///
/// A baseline holds for the very scenarios that it was measured on, by their hashes. Another renderer, or newer code
/// that makes the frames, does not invalidate it: what that does to scores is for the statistics to absorb, and is
/// named.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/scoring/verdict.h"

namespace gaitcam {

struct BaselineEntry {
  MeasuredEntry measured;
  std::string resolved;  ///< The resolved scenario of the first seed as YAML: shows what changed when hashes differ.
};

struct Baseline {
  std::string suite;
  std::string program_version;
  std::string frames_fingerprint;  ///< Of the code that makes frames.
  std::string renderer;
  std::vector<BaselineEntry> entries;

  /// Null if there is none.
  const BaselineEntry* Find(const std::string& scenario, const std::string& system) const;
};

/// One line per run; byte-identical for equal content.
std::string BaselineToJson(const Baseline& baseline);

/// @throws BadInput naming the file if it is not there, damaged, or of another schema.
Baseline ReadBaseline(const std::filesystem::path& file);

}  // namespace gaitcam
