/// Datasets: many recordings from one file, which is an experiment (scenarios/code/files/experiment.h) with keys of its
/// own:
///
///   format: tum               # or euroc, vslamlab
///   pairs: {every: 10}        # pairs of frames with true correspondences; absent: none
///   preview: true             # a video and a contact sheet per sequence
///   licence: CC-BY-4.0        # stated on the data card
///   author: Jane Doe          # ... and how to cite
///
/// OUT/
///   README.md                 data card
///   index.csv                 one row per sequence
///   SHA256SUMS                of all files, for `sha256sum -c`
///   matrix.yaml               the matrix file
///   sequences/NAME            what a SLAM system may see: algorithms/io/dataset_layout.h
///   sequences/NAME-truth      its truth; also its pictures, pairs and sequence.json

#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "scenarios/code/datasets/sequence_recording.h"
#include "scenarios/code/files/experiment.h"

namespace gaitcam {

struct MatrixOptions : ExperimentOptions {
  SequenceOptions recording;
  std::string licence;
  std::string author;
};

template <class Visitor>
void VisitFields(Visitor& visit, MatrixOptions& o) {
  VisitFields(visit, static_cast<ExperimentOptions&>(o));
  VisitFields(visit, o.recording);
  visit("licence", o.licence, AnyText(), "licence of the data, for the data card");
  visit("author", o.author, AnyText(), "whom to cite, for the data card");
}

struct PlannedSequence {
  std::string name;  ///< Of its folder: levels and seed.
  size_t condition = 0;
  uint64_t seed = 1;
};

/// A matrix file, read and checked before the first recording.
struct RecordMatrix {
  MatrixOptions options;
  Experiment experiment;
  std::vector<PlannedSequence> sequences;  ///< Conditions in their order, each with all seeds.
  std::string text;                        ///< Of the file.
  std::string changes;                     ///< Changes made on the command line, as typed.

  ResolvedScenario Resolved(const PlannedSequence& sequence) const;
};

/// Changes of a matrix file on the command line.
struct MatrixChanges {
  std::vector<std::string> sets;  ///< KEY=VALUE of the scenario, for all conditions.
  std::optional<uint64_t> seed;   ///< Replaces the file's seeds.
  std::optional<std::string> format;
  std::optional<int> compression;
  bool pairs = false, truth_inside = false;  ///< In addition to the file's.
};

/// Whether a file is a matrix and not a scenario: it has the key `base`. @throws BadInput if it cannot be read.
bool IsMatrix(const std::filesystem::path& file);

/// Resolves all conditions and checks that the robot can walk each of them.
/// @throws BadInput with file, line and key; also if two conditions give the same frames.
RecordMatrix ReadMatrix(const std::filesystem::path& file, const MatrixChanges& changes, bool yes);

struct MatrixRecordingOptions {
  std::filesystem::path out;
  int jobs = 0;  ///< Sequences at once, each in a process of its own; 0: one per core.
  bool quiet = false;
  std::function<bool()> interrupted = [] { return false; };
};

struct MatrixOutcome {
  std::vector<SequenceRecord> records;  ///< Finished ones, in the matrix's order.
  int reused = 0;                       ///< Of these, recorded by an earlier call.
  bool interrupted = false;
  std::map<std::string, std::string> failures;  ///< Name to the reason.
};

/// Records the sequences that are missing in a pool of processes (scenarios/code/jobs/pool.h), then writes index, data
/// card and checksums of all finished ones.
/// @throws BadInput if OUT holds something else, or a sequence of another scenario; MissingResource.
MatrixOutcome RecordDataset(const RecordMatrix& matrix, const MatrixRecordingOptions& options);

/// The work of one process of RecordDataset: records one sequence of OUT. @returns the exit code.
int FilmSequence(const std::filesystem::path& out, const std::string& name);

}  // namespace gaitcam
