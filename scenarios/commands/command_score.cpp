#include <fmt/format.h>

#include "algorithms/io/trajectory_file.h"
#include "models/yaml_fields.h"
#include "results/score.h"
#include "scenarios/commands/commands.h"
#include "scenarios/runs/output_folder.h"

namespace gaitcam {

int ScoreCommand(const ScoreArguments& arguments, const CommonOptions& common) {
  const TrajectoryFile estimate = ReadTrajectory(arguments.estimate);
  const TrajectoryFile truth = ReadTrajectory(arguments.truth);
  ScoreOptions options;
  YamlNode settings = YamlNode::FromText("", "score");
  for (const std::string& assignment : arguments.sets) settings.Set(assignment);
  ReadYaml(settings, options);
  const Scores scores = ScoreEstimate(EstimateFromTrajectory(estimate.trajectory), truth.trajectory, {}, options);
  if (!arguments.out.empty()) WriteTextFile(arguments.out, ScoresToJson(scores));
  if (common.json) {
    fmt::print("{}", ScoresToJson(scores));
  } else if (!common.quiet) {
    fmt::print("{}", ScoresToTable(scores));
  }
  return 0;
}

}  // namespace gaitcam
