#include <fmt/format.h>

#include "algorithms/core/errors.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/jobs/sequence_cache.h"
#include "scenarios/code/runs/localisation.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

struct LocalisationTableOptions {
  InputPaths scenario;           ///< Empty: robocup_localisation.yaml.
  uint64_t seed = 1;             ///< Of all randomness.
  std::vector<std::string> set;  ///< KEY=VALUE of the scenario.
};

template <class Visitor>
void VisitFields(Visitor& visit, LocalisationTableOptions& o) {
  visit("scenario", o.scenario, Nested(), "scenario with `localisation:` (default: robocup_localisation.yaml)");
  visit("seed", o.seed, Between(0, 1e15), "seed of all randomness");
  visit("set", o.set, Nested(), "set any key of the scenario, KEY=VALUE");
}

/// What `gaitcam run` measures of a scenario with `localisation:`, as a table. The run's folder lies beside the table.
class LocalisationTable : public ExperimentOf<LocalisationTableOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    command_ = setup.command;
    const std::vector<std::string>& files = options_.scenario.paths;
    if (files.size() > 1) throw BadInput("scenario: " + files[1] + ": one scenario at a time");
    std::vector<std::string> sets = options_.set;
    sets.push_back(fmt::format("seed={}", options_.seed));
    const fs::path file = files.empty() ? DataFolder() / "scenarios/robocup_localisation.yaml" : fs::path(files[0]);
    const ResolvedScenario resolved = ReadScenario(file, sets);
    if (!resolved.scenario.localisation) throw BadInput(file.string() + ": has no section localisation");
    RunOptions run;
    run.out = fs::path(setup.table).replace_extension("");
    run.quiet = setup.quiet;
    run.cache = DefaultCacheFolder();
    const RunOutcome outcome = RunLocalisation(resolved, run);
    if (!outcome.scores) throw TooLittleData(outcome.no_scores_reason);
    name_ = resolved.scenario.name;
    rows_ = outcome.table;
  }
  std::string Table() const override {
    return fmt::format("# Localisation: {}\n\nMade by `{}`.\n\n```\n{}```\n", name_, command_, rows_);
  }

 private:
  std::string command_, name_, rows_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakeLocalisationTable() { return std::make_unique<LocalisationTable>(); }

}  // namespace gaitcam
