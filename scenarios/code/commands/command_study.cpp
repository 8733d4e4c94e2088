#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "algorithms/core/errors.h"
#include "algorithms/io/whole_file.h"
#include "results/reports/study_report.h"
#include "results/reports/study_tables.h"
#include "results/scoring/score_text.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/files/versions.h"
#include "scenarios/code/jobs/slurm_pool.h"
#include "scenarios/code/jobs/study.h"
#include "scenarios/code/runs/interrupt.h"
#include "scenarios/code/runs/output_folder.h"
#include "scenarios/code/runs/runner.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr const char* kMarker = "study.yaml";
constexpr const char* kFiles[] = {"study.yaml",  "runs.csv",  "timings.csv", "summary.csv",
                                  "effects.csv", "tables.md", "report.html"};

/// The folder of an earlier call of this or another study, or a new one.
void PrepareFolder(const fs::path& out, const std::string& study_text) {
  std::error_code error;
  for (const char* name : kFiles) RemoveAbandoned(out / name);
  if (fs::exists(out) && !(fs::is_directory(out) && (fs::is_empty(out, error) || fs::exists(out / kMarker)))) {
    throw BadInput("--out " + out.string() + ": exists and holds something else (no " + kMarker +
                   " in it); name another folder or remove it");
  }
  fs::create_directories(out, error);
  if (error) throw MissingResource("cannot create the folder " + out.string() + ": " + error.message());
  for (const char* name : kFiles) RemoveUnfinished(out / name);
  WriteWholeFile(out / kMarker, study_text);
}

ExecutorOutcome Execute(const std::vector<WorkItem>& items, const StudyArguments& arguments, const fs::path& out,
                        const std::string& name, const CommonOptions& common, const InterruptGuard& guard) {
  ExecutorOptions options;
  options.runs = out / "runs";
  options.cache = arguments.cache;
  options.jobs = arguments.jobs;
  options.what = name;
  options.quiet = common.quiet;
  options.interrupted = [&guard] { return guard.Interrupted(); };
  if (arguments.executor == "local") return ExecuteLocally(items, options);
  SlurmOptions slurm;
  slurm.quiet = options.quiet;
  slurm.job_name = "gaitcam-" + name;
  slurm.sbatch = arguments.sbatch;
  return ExecuteOnSlurm(items, options, slurm);
}

std::vector<std::pair<std::string, std::string>> FactsOf(const Study& study, const fs::path& file) {
  std::vector<std::pair<std::string, std::string>> facts{
      {"command", "gaitcam study " + file.string()},
      {"runs", fmt::format("{}: {} conditions, {} seeds each", study.table.runs.size(), study.table.conditions(),
                           study.table.seeds)}};
  for (const auto& fact : LibraryVersions()) facts.push_back(fact);
  std::map<std::string, int> renderers;
  for (const StudyRun& run : study.table.runs) {
    if (!run.renderer.empty()) ++renderers[run.renderer];
  }
  std::set<std::string> steering;
  for (const Condition& condition : study.experiment.conditions) steering.insert(SteeringText(condition.resolved));
  for (const std::string& text : steering) facts.emplace_back("robots", text);
  for (const auto& [renderer, runs] : renderers)
    facts.emplace_back("renderer", renderers.size() == 1 ? renderer : fmt::format("{}: {} runs", renderer, runs));
  return facts;
}

void WriteTables(const Study& study, const std::vector<StudyEffect>& effects, const StudyArguments& arguments,
                 const fs::path& out) {
  StudyReportInput report;
  report.table = &study.table;
  report.effects = &effects;
  report.statistics = study.Statistics();
  report.by = study.by;
  report.study_file = study.text;
  report.facts = FactsOf(study, arguments.file);
  const std::string page = StudyReportHtml(report);  // throws without Chart.js, before anything is written
  WriteWholeFile(out / "summary.csv", SummaryCsv(study.table, report.statistics));
  WriteWholeFile(out / "effects.csv", EffectsCsv(study.table, effects));
  WriteWholeFile(out / "tables.md", StudyTablesMarkdown(study.table, study.by));
  WriteWholeFile(out / "timings.csv", TimingsCsv(study.table));
  WriteWholeFile(out / "report.html", page);
  WriteWholeFile(out / "runs.csv", RunsCsv(study.table));
}

/// Reasons why runs failed, each once.
std::map<std::string, int> Reasons(const StudyTable& table) {
  std::map<std::string, int> reasons;
  for (const StudyRun& run : table.runs) {
    if (run.status == "failed") ++reasons[run.failure];
  }
  return reasons;
}

std::string Percent(double confidence) { return fmt::format("{:g} %", 100 * confidence); }

void PrintEffects(const Study& study, const std::vector<StudyEffect>& effects, size_t most) {
  size_t width = 6, metric_width = 6;
  const size_t shown = std::min(most, effects.size());
  for (size_t i = 0; i < shown; ++i) {
    width = std::max(width, EffectText(study.table, effects[i]).size());
    metric_width = std::max(metric_width, effects[i].metric.name.size());
  }
  fmt::print(
      "Effects, the surest first: shift with its {} interval, Wilcoxon's p, corrected for {} comparisons (Holm); "
      "n walks (seeds), each with the median of its pairs\n",
      Percent(study.options.confidence), effects.size());
  for (size_t i = 0; i < shown; ++i) {
    const StudyEffect& e = effects[i];
    const int verdict = e.Verdict(study.options.confidence);
    fmt::print("  {:<{}}  {:<{}}  {:>9} [{}, {}]  n={}  p={:.2g}  {}\n", EffectText(study.table, e), width,
               e.metric.name, metric_width, ScoreText(e.shift), ScoreText(e.ends.low), ScoreText(e.ends.high), e.walks,
               e.p_holm,
               verdict > 0   ? "better"
               : verdict < 0 ? "worse"
                             : "");
  }
  if (effects.size() > shown) fmt::print("  ... and {} more in effects.csv\n", effects.size() - shown);
  const std::string too_few = TooFewSeeds(effects, study.options.confidence);
  if (!too_few.empty()) fmt::print("{}\n", too_few);
}

nlohmann::ordered_json Number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json ToJson(const Study& study, const std::vector<StudyEffect>& effects,
                              const ExecutorOutcome& outcome, const fs::path& out) {
  nlohmann::ordered_json json{{"schema", "gaitcam.study.1"},
                              {"name", study.table.name},
                              {"folder", out.string()},
                              {"runs", study.table.runs.size()},
                              {"conditions", study.table.conditions()},
                              {"reused", outcome.reused},
                              {"failed", nlohmann::ordered_json::array()},
                              {"effects", nlohmann::ordered_json::array()}};
  for (const StudyRun& run : study.table.runs) {
    if (run.status == "failed") json["failed"].push_back({{"hash", run.hash}, {"reason", run.failure}});
  }
  for (const StudyEffect& e : effects) {
    const StudyAxis& axis = study.table.axes[e.axis];
    nlohmann::ordered_json within = nullptr;
    if (e.within) {
      const StudyAxis& by = study.table.axes[e.within->first];
      within = {{by.key, by.levels[e.within->second]}};
    }
    json["effects"].push_back({{"axis", axis.key},
                               {"level", axis.levels[e.level]},
                               {"reference", axis.levels[axis.reference]},
                               {"within", within},
                               {"metric", e.metric.name},
                               {"pairs", e.pairs},
                               {"unpaired", e.unpaired},
                               {"walks", e.walks},
                               {"reference_median", Number(e.reference)},
                               {"shift", Number(e.shift)},
                               {"low", Number(e.ends.low)},
                               {"high", Number(e.ends.high)},
                               {"p", e.p},
                               {"p_holm", e.p_holm}});
  }
  return json;
}

}  // namespace

int StudyCommand(const StudyArguments& arguments, const CommonOptions& common) {
  const InterruptGuard guard;
  if (arguments.executor == "slurm") CheckSlurm();
  Study study = ReadStudy(arguments.file, arguments.yes);
  const fs::path out = arguments.out.empty() ? fs::path("studies") / study.table.name : arguments.out;
  const std::vector<WorkItem> items = ItemsOf(study);
  PrepareFolder(out, study.text);
  const ExecutorOutcome outcome = Execute(items, arguments, out, study.table.name, common, guard);
  if (outcome.interrupted) {
    fmt::print(stderr, "gaitcam: interrupted; {} of {} runs are done, the same command goes on from there\n",
               outcome.reused + outcome.done, items.size());
    return 130;
  }
  CollectRuns(out / "runs", items, outcome.failures, study.table);
  const std::vector<StudyEffect> effects = RankEffects(study.table, study.Statistics(), study.by);
  WriteTables(study, effects, arguments, out);
  const std::map<std::string, int> reasons = Reasons(study.table);
  int failed = 0;
  for (const auto& [reason, count] : reasons) failed += count;
  for (const auto& [reason, count] : reasons)
    fmt::print(stderr, "gaitcam: {} of {} runs failed: {}\n", count, items.size(), reason);
  if (common.json) {
    fmt::print("{}\n", ToJson(study, effects, outcome, out).dump(2));
  } else if (!common.quiet) {
    fmt::print("{} runs ({} reused), {} conditions\n\n", items.size(), outcome.reused, study.table.conditions());
    PrintEffects(study, effects, 12);
    fmt::print("\nreport: {}\n", (out / "report.html").string());
  }
  if (failed == int(items.size())) throw TooLittleData("none of the runs came to a result");
  return 0;
}

}  // namespace gaitcam
