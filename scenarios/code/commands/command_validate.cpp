#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "models/code/yaml/yaml_reader.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/datasets/dataset_check.h"
#include "scenarios/code/datasets/record_matrix.h"
#include "scenarios/code/files/scenario.h"
#include "scenarios/code/jobs/study.h"
#include "scenarios/code/runs/runner.h"

namespace gaitcam {
namespace {

std::string Count(size_t count, const std::string& what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

void PrintDataset(const DatasetReport& report, const std::string& folder) {
  for (const DatasetReport::Sequence& s : report.sequences) {
    std::string floor = s.with_truth ? "too little floor in view to judge the intrinsics" : "no truth beside it";
    if (s.floor) {
      floor = fmt::format("the floor says fx {:.2f} +- {:.2f}, fy {:.2f} +- {:.2f} px", s.floor->fx, s.floor->fx_std,
                          s.floor->fy, s.floor->fy_std);
    }
    fmt::print("{:<44} {:>5} frames; {}\n", s.name, s.frames, floor);
  }
  fmt::print("{}: {}; {}, {} frames, {} images read{}\n", folder,
             report.problems.empty() ? "no fault found" : Count(report.problems.size(), "fault"),
             Count(report.sequences.size(), "sequence"), report.frames, report.images,
             report.files_summed > 0 ? fmt::format(", {} checksums", report.files_summed) : "");
}

nlohmann::ordered_json ToJson(const DatasetReport& report) {
  nlohmann::ordered_json json{{"valid", report.problems.empty()},
                              {"frames", report.frames},
                              {"images", report.images},
                              {"checksums", report.files_summed},
                              {"sequences", nlohmann::ordered_json::array()},
                              {"problems", nlohmann::ordered_json::array()}};
  for (const DatasetReport::Sequence& s : report.sequences) {
    nlohmann::ordered_json sequence{{"name", s.name}, {"frames", s.frames}, {"with_truth", s.with_truth}};
    if (s.floor)
      sequence["floor"] = {
          {"fx", s.floor->fx}, {"fx_std", s.floor->fx_std}, {"fy", s.floor->fy}, {"fy_std", s.floor->fy_std}};
    json["sequences"].push_back(sequence);
  }
  for (const Problem& p : report.problems)
    json["problems"].push_back({{"file", p.file.string()}, {"line", p.line}, {"message", p.message}});
  return json;
}

int ValidateDataset(const std::filesystem::path& folder, const CommonOptions& common) {
  const DatasetReport report = CheckDataset(folder);
  if (common.json) fmt::print("{}\n", ToJson(report).dump(2));
  if (!common.json && !common.quiet) PrintDataset(report, folder.string());
  std::fflush(stdout);
  for (const Problem& problem : report.problems) fmt::print(stderr, "{}\n", problem.ToText());
  return report.problems.empty() ? 0 : 2;
}

/// Tells studies from matrices by keys that only studies have.
int ValidateExperiment(const ScenarioArguments& arguments, const CommonOptions& common) {
  const OptionValue root = LoadYaml(arguments.file);
  size_t runs = 0, conditions = 0;
  if (root.Has("metrics") || root.Has("reference") || root.Has("by")) {
    const Study study = ReadStudy(arguments.file, true);
    runs = study.experiment.runs();
    conditions = study.experiment.conditions.size();
  } else {
    MatrixChanges changes;
    changes.sets = arguments.sets;
    changes.seed = arguments.seed;
    const RecordMatrix matrix = ReadMatrix(arguments.file, changes, true);
    runs = matrix.sequences.size();
    conditions = matrix.experiment.conditions.size();
  }
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"valid", true}, {"runs", runs}, {"conditions", conditions}}.dump(2));
  } else if (!common.quiet) {
    fmt::print("{}: valid; {} conditions, {} runs\n", arguments.file.string(), conditions, runs);
  }
  return 0;
}

}  // namespace

std::vector<std::string> ScenarioArguments::Assignments() const {
  std::vector<std::string> all = sets;
  if (seed) all.push_back("seed=" + std::to_string(*seed));
  if (system) all.push_back("system=" + *system);
  return all;
}

int ValidateCommand(const ScenarioArguments& arguments, const CommonOptions& common) {
  if (std::filesystem::is_directory(arguments.file)) return ValidateDataset(arguments.file, common);
  if (IsMatrix(arguments.file)) return ValidateExperiment(arguments, common);
  const ResolvedScenario resolved = ReadScenario(arguments.file, arguments.Assignments());
  CheckPlan(resolved);
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"valid", true}, {"scenario", resolved.scenario.name}}.dump(2));
  } else if (!common.quiet && resolved.scenario.localisation) {
    const LocalisationOptions& places = *resolved.scenario.localisation;
    fmt::print("{}: valid; {} recognises {} x {} places in {}\n", arguments.file.string(), resolved.robot.name,
               places.columns, places.rows, resolved.scene.name);
  } else if (!common.quiet) {
    fmt::print("{}: valid; {} walks `{}` in {}, tracked by {}\n", arguments.file.string(), resolved.robot.name,
               ToWord(resolved.scenario.path.kind), resolved.scene.name, resolved.scenario.system.name);
  }
  return 0;
}

}  // namespace gaitcam
