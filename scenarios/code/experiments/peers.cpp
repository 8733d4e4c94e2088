#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/io/dataset_reader.h"
#include "algorithms/io/whole_file.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/files/system_needs.h"
#include "scenarios/code/runs/run_scores.h"
#include "scenarios/code/runs/tracking.h"
#include "scenarios/code/systems/chosen_system.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

struct PeersOptions {
  InputPaths recordings;
  std::vector<std::string> system;
  uint64_t seed = 1;
};

template <class Visitor>
void VisitFields(Visitor& visit, PeersOptions& o) {
  visit("recordings", o.recordings, Nested(), "folders that gaitcam record made, the truth beside them");
  visit("system", o.system, Nested(),
        "a system, by name or as in a scenario: 'mobif_vo', '{command: [./my_slam, \"{dataset}\", \"{output}\"]}'");
  visit("seed", o.seed, Between(0, 1e15), "seed of the systems");
}

/// One system on one recording.
struct Trial {
  std::string recording, system;
  std::map<std::string, double> scores;  ///< Those that are determined.
  double seconds = 0;                    ///< Wall time of it all.
  std::string failure;                   ///< Why there are no scores.
};

struct Column {
  const char* score;
  const char* title;
  double factor;
  int digits;
};
constexpr Column kColumns[] = {{"coverage_ratio", "coverage, %", 100, 0},
                               {"live_coverage_ratio", "live coverage, %", 100, 0},
                               {"ate_rmse_m", "ATE, SE(3), mm", 1000, 1},
                               {"ate_sim3_rmse_m", "ATE, Sim(3), mm", 1000, 1},
                               {"live_ate_sim3_rmse_m", "the same, live, mm", 1000, 1},
                               {"drift_sim3_pct", "drift, %", 1, 2},
                               {"jumps", "jumps", 1, 0}};

std::string Cell(const std::map<std::string, double>& scores, const Column& column) {
  const auto at = scores.find(column.score);
  if (at == scores.end()) return "-";
  return fmt::format("{:.{}f}", column.factor * at->second, column.digits);
}

/// Every system on every recording, whoever's they are, scored alike.
class Peers : public ExperimentOf<PeersOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    command_ = setup.command;
    if (options_.recordings.paths.empty()) throw BadInput("peers: name at least one folder of a recorded walk");
    if (options_.system.empty()) throw BadInput("peers: name at least one --system");
    std::vector<SystemChoice> systems;
    for (const std::string& text : options_.system) {
      systems.push_back(ParseSystemChoice(text));
      InfoOf(systems.back());  // now, not after others have run: is there such a system?
    }
    std::vector<fs::path> folders;
    for (const std::string& path : options_.recordings.paths) {
      folders.push_back(FindDataset(path));
      if (!HasTruthBeside(folders.back()))
        throw BadInput(folders.back().string() + ": the truth does not lie beside it; nothing can be scored");
    }
    for (size_t f = 0; f < folders.size(); ++f) {
      for (size_t i = 0; i < systems.size(); ++i) {
        trials_.push_back(TrackOne(folders[f], systems[i], setup));
        trials_.back().recording = options_.recordings.paths[f];
        trials_.back().system = options_.system[i];
        if (!setup.quiet) fmt::print(stderr, "{}", RowOf(trials_.back()));
      }
    }
  }

  std::string Table() const override {
    std::string text = fmt::format(
        "# Systems on the same recordings\n\nMade by `{}`. Errors are of the part of a recording that has poses: read "
        "them beside the coverage. Sim(3): the scale is given away, which a monocular system needs. *live*: what a "
        "system had said when it had seen nothing later; a command says all at its end. Drift: mean error of sub-paths "
        "in per cent of the path walked, scale corrected. Jumps: steps between successive poses that are wrong by more "
        "than 2 cm or 2 degrees and 25 % of the true step. Time: wall time of the whole, start and end included, over "
        "the recorded time; other programs on the machine lengthen it.\n\n",
        command_);
    text += Head("| recording | system |", "|---|---|");
    for (const Trial& trial : trials_) text += RowOf(trial);
    if (options_.recordings.paths.size() > 1) {
      text += "\n## Medians over the recordings\n\nOf those in which a system was scored (smallest to largest).\n\n" +
              Head("| scored | system |", "|---:|---|");
      for (const std::string& system : options_.system) text += MedianRow(system);
    }
    return text;
  }

 private:
  Trial TrackOne(const fs::path& sensors, const SystemChoice& choice, const ExperimentSetup& setup) const {
    Trial trial;
    const auto begin = std::chrono::steady_clock::now();
    try {
      DatasetReader reader(sensors);
      if (const auto lack = LackInDataset(InfoOf(choice), reader.calibration(), sensors)) throw BadInput(*lack);
      const fs::path folder = fs::absolute(setup.table).parent_path();
      TrackingThread tracker(MakeSystem(choice, {reader.calibration(), options_.seed, choice.settings}, folder));
      const Estimate estimate = TrackRecorded(reader, tracker, [] { return false; });
      trial.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      trial.failure = estimate.failure;
      for (const Score& score : ScoreAgainstTruthBeside(estimate, sensors, choice.name).scores)
        if (std::isfinite(score.value)) trial.scores[score.name] = score.value;
    } catch (const TooLittleData& e) {
      trial.failure = e.what();
    } catch (const BadInput& e) {
      trial.failure = e.what();
    } catch (const MissingResource& e) {  // one system's: the others' rows stay
      trial.failure = e.what();
    }
    return trial;
  }

  static std::string Head(std::string titles, std::string rule) {
    for (const Column& column : kColumns) {
      titles += fmt::format(" {} |", column.title);
      rule += "---:|";
    }
    return titles + " time, s / s | remark |\n" + rule + "---:|---|\n";
  }

  static std::string RowOf(const Trial& trial) {
    std::string row = fmt::format("| {} | `{}` |", trial.recording, trial.system);
    for (const Column& column : kColumns) row += " " + Cell(trial.scores, column) + " |";
    const auto length = trial.scores.find("duration_s");
    const bool is_timed = length != trial.scores.end() && length->second > 0;
    row += is_timed ? fmt::format(" {:.2f} |", trial.seconds / length->second) : " - |";
    return row + " " + trial.failure + " |\n";
  }

  std::string MedianRow(const std::string& system) const {
    std::string cells;
    size_t scored = 0;
    for (const Column& column : kColumns) {
      std::vector<double> values;
      for (const Trial& trial : trials_) {
        const auto at = trial.scores.find(column.score);
        if (trial.system == system && at != trial.scores.end()) values.push_back(column.factor * at->second);
      }
      scored = std::max(scored, values.size());
      cells += " " + MedianAndRange(values, column.digits) + " |";
    }
    return fmt::format("| {} of {} | `{}` |{}  |  |\n", scored, options_.recordings.paths.size(), system, cells);
  }

  std::string command_;
  std::vector<Trial> trials_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakePeers() { return std::make_unique<Peers>(); }

}  // namespace gaitcam
