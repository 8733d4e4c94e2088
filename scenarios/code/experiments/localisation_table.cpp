#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "algorithms/core/errors.h"
#include "algorithms/core/option_value.h"
#include "algorithms/io/whole_file.h"
#include "algorithms/places/place_recognition.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/jobs/sequence_cache.h"
#include "scenarios/code/runs/localisation.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

struct LocalisationTableOptions {
  InputPaths scenario;                 ///< Empty: robocup_localisation.yaml.
  uint64_t seed = 1;                   ///< Of all randomness; the first of them.
  int seeds = 1;                       ///< Counted on from the first.
  std::vector<std::string> prefilter;  ///< Of `wavelet`, in squares, beside the scenario's own.
  std::vector<std::string> set;        ///< KEY=VALUE of the scenario.
};

template <class Visitor>
void VisitFields(Visitor& visit, LocalisationTableOptions& o) {
  visit("scenario", o.scenario, Nested(), "scenario with `localisation:` (default: robocup_localisation.yaml)");
  visit("seed", o.seed, Between(0, 1e15), "the first seed of all randomness");
  visit("seeds", o.seeds, Between(1, 1000), "so many seeds, counted on from the first");
  visit("prefilter", o.prefilter, Nested(), "a further Gaussian of `wavelet`, its sigma in squares; may be repeated");
  visit("set", o.set, Nested(), "set any key of the scenario, KEY=VALUE");
}

/// What one method reaches in one condition with one seed.
struct LocalisationRow {
  uint64_t seed;
  std::string method, condition;
  std::map<std::string, double> scores;  ///< By name, as "found_ratio".
};

/// The scores of a method in a condition that have a column.
constexpr const char* kColumns[] = {"found_ratio",     "bearing_error_median_deg", "position_error_median_m",
                                    "peak_area_ratio", "peak_area_range_ratio",    "modes"};

/// What `gaitcam run` measures of a scenario with `localisation:`, with several seeds and Gaussians. The runs' folders
/// lie beside the table, in a folder of its name, and the rows in a .csv.
class LocalisationTable : public ExperimentOf<LocalisationTableOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    command_ = setup.command;
    if (options_.scenario.paths.size() > 1)
      throw BadInput("scenario: " + options_.scenario.paths[1] + ": one scenario at a time");
    for (const std::string& sigma : options_.prefilter) CheckSigma(sigma);
    Resolved(options_.seed, {});  // now, not after an hour: is all of it permitted?
    const fs::path folder = fs::path(setup.table).replace_extension("");
    for (int i = 0; i < options_.seeds; ++i) {
      const uint64_t seed = options_.seed + uint64_t(i);
      const std::string name = fmt::format("seed{}", seed);
      Measure(setup, folder / name, Resolved(seed, {}), "");
      for (const std::string& sigma : options_.prefilter) {
        const std::vector<std::string> more{"localisation.methods=[wavelet]",
                                            "localisation.wavelet.prefilter=" + sigma};
        Measure(setup, folder / (name + "_prefilter" + sigma), Resolved(seed, more), "_" + sigma);
      }
    }
    WriteWholeFile(fs::path(setup.table).replace_extension(".csv"), Rows());
  }

  std::string Table() const override {
    return fmt::format(
               "# Localisation: {}\n\nMade by `{}`. Median (smallest to largest) over {} seed{}; {} views of each "
               "condition and seed. `wavelet_0.5`: the Gaussian has a sigma of 0.5 squares.\n",
               name_, command_, options_.seeds, options_.seeds > 1 ? "s" : "", views_) +
           TableOf("Found: the nearest place or one beside it, %", "found_ratio", 100, 1) +
           TableOf("Error of the heading, median of the views, degrees", "bearing_error_median_deg", 1, 1);
  }

 private:
  static void CheckSigma(const std::string& text) {
    const std::optional<double> number = OptionValue(text).AsNumber();
    if (!number) throw BadOption("--prefilter: \"" + text + "\" is no number");
    WaveletOptions wavelet;
    wavelet.prefilter = *number;
    CheckFields(wavelet, "--");
  }

  ResolvedScenario Resolved(uint64_t seed, const std::vector<std::string>& more) const {
    std::vector<std::string> sets = options_.set;
    sets.push_back(fmt::format("seed={}", seed));
    sets.insert(sets.end(), more.begin(), more.end());
    const std::vector<std::string>& files = options_.scenario.paths;
    const fs::path file = files.empty() ? DataFolder() / "scenarios/robocup_localisation.yaml" : fs::path(files[0]);
    ResolvedScenario resolved = ReadScenario(file, sets);
    if (!resolved.scenario.localisation) throw BadInput(file.string() + ": has no section localisation");
    return resolved;
  }

  /// @param suffix of the names of methods
  void Measure(const ExperimentSetup& setup, const fs::path& folder, const ResolvedScenario& resolved,
               const std::string& suffix) {
    RunOptions run;
    run.out = folder;
    run.quiet = setup.quiet || !suffix.empty();  // its pictures are there
    run.cache = DefaultCacheFolder();
    const RunOutcome outcome = RunLocalisation(resolved, run);
    if (!outcome.scores) throw TooLittleData(outcome.no_scores_reason);
    const LocalisationOptions& places = *resolved.scenario.localisation;
    name_ = resolved.scenario.name;
    views_ = places.queries;
    std::map<std::string, double> scores;
    for (const Score& score : outcome.scores->scores) scores[score.name] = score.value;
    for (const std::string& method : places.methods.empty() ? PlaceIndexNames() : places.methods) {
      for (const std::string& condition : PlaceConditions(places)) {
        LocalisationRow row{resolved.scenario.seed, method + suffix, condition, {}};
        for (const char* column : kColumns) row.scores[column] = scores.at(method + "_" + condition + "_" + column);
        rows_.push_back(std::move(row));
      }
    }
  }

  std::string Rows() const {
    std::string text = "seed,method,condition";
    for (const char* column : kColumns) text += fmt::format(",{}", column);
    for (const LocalisationRow& row : rows_) {
      text += fmt::format("\n{},{},{}", row.seed, row.method, row.condition);
      for (const char* column : kColumns) {
        const double value = row.scores.at(column);
        text += std::isfinite(value) ? fmt::format(",{:.5g}", value) : ",";
      }
    }
    return text + "\n";
  }

  /// A row for each method, a column for each condition, as they come.
  std::string TableOf(const std::string& title, const std::string& score, double factor, int digits) const {
    std::vector<std::string> methods, conditions;
    std::map<std::pair<std::string, std::string>, std::vector<double>> values;
    const auto note = [](std::vector<std::string>& names, const std::string& name) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    };
    for (const LocalisationRow& row : rows_) {
      note(methods, row.method);
      note(conditions, row.condition);
      values[{row.method, row.condition}].push_back(factor * row.scores.at(score));
    }
    std::string head = "| method |", rule = "|---|", body;
    for (const std::string& condition : conditions) {
      head += " " + condition + " |";
      rule += "---|";
    }
    for (const std::string& method : methods) {
      body += "| " + method + " |";
      for (const std::string& condition : conditions)
        body += " " + MedianAndRange(values[{method, condition}], digits) + " |";
      body += "\n";
    }
    return "\n## " + title + "\n\n" + head + "\n" + rule + "\n" + body;
  }

  std::string command_, name_;
  int views_ = 0;
  std::vector<LocalisationRow> rows_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakeLocalisationTable() { return std::make_unique<LocalisationTable>(); }

}  // namespace gaitcam
