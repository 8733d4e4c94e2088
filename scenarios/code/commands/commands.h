/// The verbs. Each does its whole job and returns the exit code; bad input is thrown (see algorithms/core/errors.h).

#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/code/jobs/sequence_cache.h"

namespace gaitcam {

/// Options of every verb.
struct CommonOptions {
  bool quiet = false;  ///< No progress and no prose.
  bool json = false;   ///< The result as JSON on standard output, and nothing else there.
};

/// A scenario file and changes of its keys.
struct ScenarioArguments {
  std::filesystem::path file;
  std::vector<std::string> sets;  ///< key=value, applied in order.
  std::optional<uint64_t> seed;
  std::optional<std::string> system;

  /// `--seed` and `--system` as assignments, after the others.
  std::vector<std::string> Assignments() const;
};

struct RunArguments {
  ScenarioArguments scenario;
  std::filesystem::path out;  ///< Empty: runs/NAME-SYSTEM-seedN.
  bool all = false;           ///< Print all scores.
};
int RunCommand(const RunArguments& arguments, const CommonOptions& common);

struct RecordArguments {
  ScenarioArguments scenario;         ///< Or a matrix of recordings.
  std::optional<std::string> format;  ///< Else tum, or as the matrix says.
  std::filesystem::path out;          ///< Empty: datasets/NAME-seedN; of a matrix datasets/NAME.
  bool truth_inside = false;          ///< Also put the truth where the layout's own tools look for it.
  bool pairs = false;                 ///< Pairs of frames with true correspondences.
  std::optional<int> compression;     ///< Of images: 0 none, 1 fast to 9 smallest.
  bool preview = false;               ///< Video and contact sheet also of a single scenario.
  int jobs = 0;                       ///< Sequences of a matrix at once; 0: one per core.
  bool yes = false;                   ///< Also more than 100000 sequences.
};
int RecordCommand(const RecordArguments& arguments, const CommonOptions& common);

/// Started by `record` for every sequence of a matrix; not meant to be typed.
struct FilmArguments {
  std::filesystem::path dataset;
  std::string name;
};
int FilmCommand(const FilmArguments& arguments, const CommonOptions& common);

struct TrackArguments {
  std::filesystem::path dataset;
  std::string system = "sift_vo";  ///< As under `system:` of a scenario; a .so, or a .yaml that holds such a map.
  std::vector<std::string> sets;   ///< name=value, settings of the system.
  uint64_t seed = 1;
  std::filesystem::path out;  ///< Trajectory file (TUM); empty: estimate-SYSTEM.txt in the working folder.
  bool all = false;           ///< Print all scores.
};
int TrackCommand(const TrackArguments& arguments, const CommonOptions& common);

/// Answers the lines of frame_protocol.h; started for a shared library, not meant to be typed.
struct ServeArguments {
  std::string system;            ///< One of ours, or
  std::filesystem::path plugin;  ///< a shared library.
  bool info = false;             ///< Prints what is known of the library's system and ends.
};
int ServeCommand(const ServeArguments& arguments);

struct ScoreArguments {
  std::filesystem::path estimate, truth;
  std::vector<std::string> sets;  ///< key=value of ScoreOptions, as under `score:` of a scenario.
  std::filesystem::path out;      ///< scores.json; empty: none.
  bool all = false;               ///< Print all scores.
  bool strict = false;            ///< Stamps must increase.
};
int ScoreCommand(const ScoreArguments& arguments, const CommonOptions& common);

struct CheckArguments {
  std::string suite;               ///< Name of a shipped suite, or path of a suite file.
  std::filesystem::path baseline;  ///< Empty: the suite's own.
  bool update = false;             ///< Write the baseline instead of comparing with it.
  std::filesystem::path junit, markdown;
  std::filesystem::path out;  ///< Folder of the runs; empty: runs/check-SUITE.
  SequenceCacheOptions cache;
  int jobs = 0;  ///< 0: one per core.
  bool self_test = false;
  int reruns = 0;                ///< Of the self-test.
  std::filesystem::path record;  ///< Markdown file of the self-test's rates.
};
int CheckCommand(const CheckArguments& arguments, const CommonOptions& common);

/// Started by `check` and `study` for every run; not meant to be typed.
struct WorkArguments {
  std::filesystem::path runs;
  std::string hash;
  SequenceCacheOptions cache;
};
int WorkCommand(const WorkArguments& arguments, const CommonOptions& common);

struct StudyArguments {
  std::filesystem::path file;
  std::filesystem::path out;  ///< Empty: studies/NAME.
  int jobs = 0;               ///< Runs at once; 0: one per core.
  SequenceCacheOptions cache;
  std::string executor = "local";
  std::vector<std::string> sbatch;  ///< Further options of Slurm's sbatch.
  bool yes = false;                 ///< Also more than 100000 runs.
};
int StudyCommand(const StudyArguments& arguments, const CommonOptions& common);

struct SchemaArguments {
  std::string kind;  ///< Of file: scenario, study, suite, matrix.
};
int SchemaCommand(const SchemaArguments& arguments);

struct ListArguments {
  std::string kind;  ///< One of ListedKinds(); empty: all of them.
  std::string name;  ///< The one to be told more of.
};
/// "robots", "scenes", "systems", "scenarios".
const std::vector<std::string>& ListedKinds();
/// The names of a kind, sorted; none for a kind that is not listed.
std::vector<std::string> ListedNames(const std::string& kind);
int ListCommand(const ListArguments& arguments, const CommonOptions& common);

/// `file` is a scenario, or the folder of a dataset.
int ValidateCommand(const ScenarioArguments& scenario, const CommonOptions& common);
int DoctorCommand(const CommonOptions& common);

}  // namespace gaitcam
