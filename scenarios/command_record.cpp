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
  RecordOptions options;
  options.quiet = common.quiet;
  options.interrupted = [&guard] { return guard.Interrupted(); };
  options.format.format = DatasetFormatFromText(arguments.format);
  options.format.truth_inside = arguments.truth_inside;
  std::filesystem::path out = arguments.out;
  if (out.empty()) out = fmt::format("datasets/{}-seed{}", scenario.name, scenario.seed);
  const RecordOutcome outcome = RecordScenario(resolved, DatasetFolders::In(out, scenario.name), options);
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
