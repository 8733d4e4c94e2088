#include <fmt/format.h>

#include "algorithms/core/errors.h"
#include "algorithms/io/trajectory_file.h"
#include "algorithms/io/whole_file.h"
#include "models/code/yaml/yaml_reader.h"
#include "results/scoring/score.h"
#include "results/scoring/score_text.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/commands/summary.h"

namespace gaitcam {

int ScoreCommand(const ScoreArguments& arguments, const CommonOptions& common) {
  for (const std::filesystem::path& input : {arguments.estimate, arguments.truth}) {
    std::error_code error;
    if (arguments.out.empty() || !std::filesystem::equivalent(arguments.out, input, error)) continue;
    throw BadInput("--out " + arguments.out.string() + ": this file is read; expected another name for the scores");
  }
  const StampOrder order = arguments.strict ? StampOrder::kStrict : StampOrder::kRepaired;
  const TrajectoryFile estimate = ReadTrajectory(arguments.estimate, {}, {}, order);
  const TrajectoryFile truth = ReadTrajectory(arguments.truth, {}, {}, order);
  ScoreOptions options;
  OptionValue settings = ParseYaml("", "score");
  for (const std::string& assignment : arguments.sets) SetOption(settings, assignment);
  ReadOption(settings, options);
  Scores scores = ScoreEstimate(EstimateFromTrajectory(estimate.trajectory), truth.trajectory, {}, options);
  for (const TrajectoryFile* file : {&estimate, &truth}) {
    scores.remarks.insert(scores.remarks.end(), file->remarks.begin(), file->remarks.end());
  }
  if (!arguments.out.empty()) WriteWholeFile(arguments.out, ScoresToJson(scores));
  if (common.json) {
    fmt::print("{}", ScoresToJson(scores));
  } else if (!common.quiet) {
    fmt::print("{}", SummaryText(scores, {}, arguments.all));
  }
  return 0;
}

}  // namespace gaitcam
