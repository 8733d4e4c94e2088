#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "scenarios/commands.h"
#include "scenarios/interrupt.h"
#include "scenarios/recorder.h"

namespace gaitcam {

int RecordCommand(const RecordArguments& arguments, const CommonOptions& common) {
  const ResolvedScenario resolved = ReadScenario(arguments.scenario.file, arguments.scenario.Assignments());
  const Scenario& scenario = resolved.scenario;
  const InterruptGuard guard;
  RunOptions options;
  options.out = arguments.out;
  if (options.out.empty()) options.out = fmt::format("datasets/{}-seed{}", scenario.name, scenario.seed);
  options.quiet = common.quiet;
  options.interrupted = [&guard] { return guard.Interrupted(); };
  DatasetWriterOptions format;
  format.format = DatasetFormatFromText(arguments.format);
  format.truth_inside = arguments.truth_inside;
  const RecordOutcome outcome = RecordScenario(resolved, format, options);
  if (common.json) {
    fmt::print("{}\n", nlohmann::ordered_json{{"sensors", outcome.folders.sensors.string()},
                                              {"truth", outcome.folders.truth.string()},
                                              {"status", outcome.status},
                                              {"end_time_s", outcome.end_time_s},
                                              {"frames", outcome.frames}}
                           .dump(2));
  } else if (!common.quiet) {
    fmt::print("{} frames; the walk {} at {:.2f} s\nsensors: {}\ntruth:   {}\n", outcome.frames,
               outcome.status == "interrupted" ? "was interrupted" : outcome.status, outcome.end_time_s,
               outcome.folders.sensors.string(), outcome.folders.truth.string());
  }
  return outcome.status == "interrupted" ? 130 : 0;
}

}  // namespace gaitcam
