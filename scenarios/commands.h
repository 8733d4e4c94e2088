/// The verbs. Each does its whole job and returns the exit code; bad input is thrown (see algorithms/core/errors.h).

#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace gaitcam {

/// Options that every verb shares.
struct CommonOptions {
  bool quiet = false;  ///< No progress and no prose.
  bool json = false;   ///< The result as JSON on standard output, and nothing else there.
};

/// Which scenario, and what differs from its file.
struct ScenarioArguments {
  std::filesystem::path file;
  std::vector<std::string> sets;  ///< key=value, applied in order.
  std::optional<uint64_t> seed;
  std::optional<std::string> system;

  /// `--seed` and `--system` as assignments, after the others.
  std::vector<std::string> Assignments() const;
};

/// Where recorded walks are kept for other systems to see.
struct CacheArguments {
  std::filesystem::path folder;  ///< Empty: ~/.cache/gaitcam/sequences.
  double max_gb = 20;
};

struct RunArguments {
  ScenarioArguments scenario;
  std::filesystem::path out;  ///< Empty: runs/NAME-SYSTEM-seedN.
};
int RunCommand(const RunArguments& arguments, const CommonOptions& common);

struct RecordArguments {
  ScenarioArguments scenario;
  std::string format = "tum";
  std::filesystem::path out;  ///< Empty: datasets/NAME-seedN.
  bool truth_inside = false;  ///< Also put the truth where the layout's own tools look for it.
};
int RecordCommand(const RecordArguments& arguments, const CommonOptions& common);

struct TrackArguments {
  std::filesystem::path dataset;
  std::string system = "sift_vo";
  std::vector<std::string> sets;  ///< name=number, settings of the system.
  uint64_t seed = 1;
  std::filesystem::path out;  ///< Trajectory file (TUM); empty: estimate-SYSTEM.txt in the working folder.
};
int TrackCommand(const TrackArguments& arguments, const CommonOptions& common);

struct ScoreArguments {
  std::filesystem::path estimate, truth;
  std::vector<std::string> sets;  ///< key=value of ScoreOptions, as under `score:` of a scenario.
  std::filesystem::path out;      ///< scores.json; empty: none.
};
int ScoreCommand(const ScoreArguments& arguments, const CommonOptions& common);

struct FeaturesArguments {
  std::vector<std::filesystem::path> pairs;  ///< Folders of image pairs; empty: pictures of Debian's opencv-doc.
  std::vector<std::filesystem::path> walks;  ///< Recordings with their truth beside them.
  std::vector<std::string> detectors;        ///< Empty: all.
  uint64_t seed = 1;
  std::filesystem::path out;  ///< Empty: features.
};
int FeaturesCommand(const FeaturesArguments& arguments, const CommonOptions& common);

/// What `check` and `study` start for every run; not meant to be typed.
struct WorkArguments {
  std::filesystem::path runs;
  std::string hash;
  CacheArguments cache;
};
int WorkCommand(const WorkArguments& arguments, const CommonOptions& common);

struct StudyArguments {
  std::filesystem::path file;
  std::filesystem::path out;  ///< Empty: studies/NAME.
  int jobs = 0;               ///< Runs at once; 0: one per core.
  CacheArguments cache;
  std::string executor = "local";
  std::vector<std::string> sbatch;  ///< Further words for Slurm's sbatch.
  bool yes = false;                 ///< Also more runs than anybody wants by mistake.
};
int StudyCommand(const StudyArguments& arguments, const CommonOptions& common);

int ValidateCommand(const ScenarioArguments& scenario, const CommonOptions& common);
int ListCommand(const CommonOptions& common);
int DoctorCommand(const CommonOptions& common);

}  // namespace gaitcam
