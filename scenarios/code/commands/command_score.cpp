#include <fmt/format.h>

#include "algorithms/io/trajectory_file.h"
#include "models/code/yaml/yaml_reader.h"
#include "results/scoring/score.h"
#include "results/scoring/score_text.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/commands/summary.h"
#include "scenarios/code/runs/output_folder.h"

namespace gaitcam {

int ScoreCommand(const ScoreArguments& arguments, const CommonOptions& common) {
  const TrajectoryFile estimate = ReadTrajectory(arguments.estimate);
  const TrajectoryFile truth = ReadTrajectory(arguments.truth);
  ScoreOptions options;
  OptionValue settings = ParseYaml("", "score");
  for (const std::string& assignment : arguments.sets) SetOption(settings, assignment);
  ReadOption(settings, options);
  const Scores scores = ScoreEstimate(EstimateFromTrajectory(estimate.trajectory), truth.trajectory, {}, options);
  if (!arguments.out.empty()) WriteTextFile(arguments.out, ScoresToJson(scores));
  if (common.json) {
    fmt::print("{}", ScoresToJson(scores));
  } else if (!common.quiet) {
    fmt::print("{}", SummaryText(scores, {}, arguments.all));
  }
  return 0;
}

}  // namespace gaitcam
