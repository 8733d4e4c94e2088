/// Studies: the effect of some keys of a scenario on the scores. A study file is an experiment
/// (scenarios/code/files/experiment.h) with keys of its own:
///
///   metrics: [coverage_ratio, ate_sim3_rmse_m]
///   reference: {camera.exposure_ms: 0}          # effects are differences from this level; else from the first
///   by: system                                  # effects stand within each level of this axis as well

#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "results/scoring/study_effects.h"
#include "results/scoring/study_table.h"
#include "scenarios/code/files/experiment.h"
#include "scenarios/code/jobs/executor.h"

namespace gaitcam {

struct StudyOptions : ExperimentOptions {
  std::vector<std::string> metrics{"coverage_ratio", "ate_sim3_rmse_m", "rpe_rot_rmse_deg_1s"};
  Assignments reference;
  std::string by;
  double confidence = 0.95;
  int resamples = 2000;
};

template <class Visitor>
void VisitFields(Visitor& visit, StudyOptions& o) {
  VisitFields(visit, static_cast<ExperimentOptions&>(o));
  visit("metrics", o.metrics, Nested(),
        "scores that tables and page are about, by name; each with that of the live answer, where it has one");
  visit("reference", o.reference, Nested(), "axis: the level that effects are differences from; else its first");
  visit("by", o.by, AnyText(), "axis within whose levels effects stand as well; else `system`, if that is an axis");
  visit("confidence", o.confidence, Between(0.5, 0.999), "of all intervals");
  visit("resamples", o.resamples, Between(100, 100000), "of bootstrap intervals");
}

/// A study file, read and checked before the first run.
struct Study {
  StudyOptions options;
  Experiment experiment;
  StudyTable table;          ///< Its runs have no results yet.
  std::optional<size_t> by;  ///< Index of the axis.
  std::string text;          ///< Of the file.

  StudyStatistics Statistics() const { return {options.confidence, options.resamples}; }
};

/// Resolves all conditions and checks that the robot can walk each of them.
/// @throws BadInput with file, line and key; see ResolveExperiment.
Study ReadStudy(const std::filesystem::path& file, bool yes);

/// One item per run, in the order of the table.
std::vector<WorkItem> ItemsOf(const Study& study);

/// Fills the table from the finished runs. `failures` is the executor's: why a run has no result.
void CollectRuns(const std::filesystem::path& runs, const std::vector<WorkItem>& items,
                 const std::map<std::string, std::string>& failures, StudyTable& table);

}  // namespace gaitcam
