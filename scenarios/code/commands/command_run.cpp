#include <fmt/format.h>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "results/scoring/score_text.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/commands/summary.h"
#include "scenarios/code/jobs/sequence_cache.h"
#include "scenarios/code/runs/interrupt.h"
#include "scenarios/code/runs/localisation.h"
#include "scenarios/code/runs/runner.h"

namespace gaitcam {
namespace {

/// The report's file comes after the scores, and what went wrong comes last.
void PrintOutcome(const RunOutcome& outcome, bool all, const std::string& system) {
  if (outcome.scores) {
    const bool own = !outcome.table.empty() && !all;
    fmt::print("{}", own ? outcome.table : SummaryText(*outcome.scores, outcome.of_film, all));
  }
  fmt::print("\nreport: {}\n", (outcome.folder / "report.html").string());
  if (!outcome.failure.empty()) fmt::print("\n{} FAILED: {}\n", system, outcome.failure);
  if (outcome.status == "fell") {
    fmt::print("\nThe robot FELL after {:.2f} s; the scores cover what was filmed until then.\n", outcome.end_time_s);
  } else if (outcome.status == "interrupted") {
    fmt::print("\nINTERRUPTED after {:.2f} s; the scores cover what was filmed until then.\n", outcome.end_time_s);
  }
}

}  // namespace

int RunCommand(const RunArguments& arguments, const CommonOptions& common) {
  const ResolvedScenario resolved = ReadScenario(arguments.scenario.file, arguments.scenario.Assignments());
  const Scenario& scenario = resolved.scenario;
  const InterruptGuard guard;
  RunOptions options;
  options.out = arguments.out;
  if (options.out.empty()) {
    const std::string what = scenario.localisation ? "places" : scenario.system.name;
    options.out = fmt::format("runs/{}-{}-seed{}", scenario.name, what, scenario.seed);
  }
  options.quiet = common.quiet;
  if (scenario.localisation) options.cache = DefaultCacheFolder();
  options.interrupted = [&guard] { return guard.Interrupted(); };
  const RunOutcome outcome =
      scenario.localisation ? RunLocalisation(resolved, options) : RunScenario(resolved, options);
  const bool interrupted = outcome.status == "interrupted";
  if (!outcome.scores) {
    const std::filesystem::path page = outcome.folder / "report.html";
    const bool written = !scenario.localisation;  // a localisation is scored only when complete
    const std::string line =
        fmt::format("{} after {:.2f} s; {}{}", interrupted ? "interrupted" : "the walk " + outcome.status,
                    outcome.end_time_s, outcome.no_scores_reason, written ? "; see " + page.string() : "");
    if (!interrupted) throw TooLittleData(line);
    fmt::print(stderr, "gaitcam: {}\n", line);
    if (!written) return 130;
  }
  if (common.json) {
    fmt::print("{}", FileContent(outcome.folder / "scores.json"));
  } else if (!common.quiet) {
    PrintOutcome(outcome, arguments.all, scenario.system.name);
  }
  return interrupted ? 130 : 0;
}

}  // namespace gaitcam
