/// Experiments: measurements behind the tables of `results`, repeated when what they measure has changed. All have one
/// shape: described options, a run that measures, and a table in Markdown that names the command which made it.
///
/// They are a program of their own, `gaitcam_experiments`: they compile for long, and no other verb needs them.

#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "algorithms/core/fields.h"

namespace gaitcam {

/// Files or folders that stand on the command line without a key.
struct InputPaths {
  std::vector<std::string> paths;
};

/// One option of an experiment; `value` points into the experiment's options.
struct ExperimentOption {
  using Value = std::variant<bool*, int*, double*, uint64_t*, std::string*, std::vector<std::string>*, InputPaths*>;
  std::string key;      ///< As in the code: `max_features` is --max-features.
  std::string meaning;  ///< With unit and, where it has limits, these.
  Value value;

  std::string Flag() const;
  /// As typed on a command line: "--pairs 50", "--walk a --walk b"; empty for a flag that is not set. Absolute paths
  /// lose their folders, which are the user's own.
  std::string ToText() const;
};

/// The visitor of VisitFields that lists options.
class OptionList {
 public:
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void operator()(std::string_view key, Number& value, const Interval& limits, std::string_view meaning) {
    options.push_back({std::string(key), std::string(meaning) + ", " + limits.ToText(), &value});
  }
  void operator()(std::string_view key, std::string& value, const Words& limits, std::string_view meaning) {
    const std::string words = limits.words.empty() ? "" : ": " + limits.ToText();
    options.push_back({std::string(key), std::string(meaning) + words, &value});
  }
  template <class T>
  void operator()(std::string_view key, T& value, Nested, std::string_view meaning) {
    options.push_back({std::string(key), std::string(meaning), &value});
  }

  std::vector<ExperimentOption> options;
};

/// "median (smallest to largest)" of the finite values, rounded; one value alone, "-" for none.
std::string MedianAndRange(std::vector<double> values, int digits);

/// How a run is carried out; nothing here changes a figure.
struct ExperimentSetup {
  std::filesystem::path table;    ///< The Markdown file; further files of an experiment lie beside it.
  std::string command;            ///< That makes the table, to be named in it.
  std::filesystem::path program;  ///< The gaitcam that does single runs.
  int jobs = 0;                   ///< Runs or threads at once; 0: one per core.
  bool quiet = false;
};

class TableExperiment {
 public:
  virtual ~TableExperiment() = default;
  virtual OptionList Options() = 0;
  /// @throws BadOption naming the option, its value and what is permitted.
  virtual void CheckOptions() const = 0;
  /// Measures, and writes files beside the table if there are any.
  /// @throws BadInput, TooLittleData, MissingResource.
  virtual void Run(const ExperimentSetup& setup) = 0;
  /// What the last run measured, in Markdown.
  virtual std::string Table() const = 0;
};

/// An experiment whose options are a struct with VisitFields.
template <class O>
class ExperimentOf : public TableExperiment {
 public:
  OptionList Options() final {
    OptionList list;
    VisitFields(list, options_);
    return list;
  }
  void CheckOptions() const final { CheckFields(options_, "--"); }

 protected:
  O options_;
};

struct ExperimentEntry {
  std::string name;
  std::string summary;   ///< One line.
  std::string examples;  ///< Lines of commands.
  std::unique_ptr<TableExperiment> (*make)();
};

/// By name.
const std::vector<ExperimentEntry>& ListExperiments();

/// "gaitcam experiment psf --frames 20": with those options that differ from their defaults.
std::string ExperimentCommand(const ExperimentEntry& entry, TableExperiment& experiment);

/// Does fn(0) ... fn(count - 1), many at once; results that go by index do not depend on the order.
/// @throws what one of those that failed threw; what was not begun by then is left out.
void InParallel(int count, int jobs, const std::function<void(int)>& fn);

std::unique_ptr<TableExperiment> MakeBlurredFeatures();
std::unique_ptr<TableExperiment> MakeBlurEstimation();
std::unique_ptr<TableExperiment> MakeCrowds();
std::unique_ptr<TableExperiment> MakeFloorAlignment();
std::unique_ptr<TableExperiment> MakeLocalisationTable();
std::unique_ptr<TableExperiment> MakeLoopTable();
std::unique_ptr<TableExperiment> MakePeers();
std::unique_ptr<TableExperiment> MakePlaceDistance();
std::unique_ptr<TableExperiment> MakeSpeed();
std::unique_ptr<TableExperiment> MakeStereoConsistency();
std::unique_ptr<TableExperiment> MakeStress();
std::unique_ptr<TableExperiment> MakeTrackingTime();
std::unique_ptr<TableExperiment> MakeWalking();

}  // namespace gaitcam
