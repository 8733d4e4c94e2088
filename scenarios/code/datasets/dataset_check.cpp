#include "scenarios/code/datasets/dataset_check.h"

#include <fmt/format.h>

#include <map>
#include <set>

#include "algorithms/core/errors.h"
#include "algorithms/io/checksum.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr const char* kSums = "SHA256SUMS";

void AddSequence(const DatasetFolders& folders, DatasetReport& report) {
  SequenceReport sequence = CheckSequence(folders);
  report.frames += sequence.frames;
  report.images += sequence.images;
  report.sequences.push_back(
      {folders.sensors.filename().string(), sequence.frames, sequence.with_truth, sequence.floor});
  report.problems.insert(report.problems.end(), sequence.problems.begin(), sequence.problems.end());
}

/// The folder beside it, named as it is given: "data/walk" -> "data/walk-truth".
fs::path TruthBeside(const fs::path& sensors) {
  fs::path normal = sensors.lexically_normal();
  if (!normal.has_filename()) normal = normal.parent_path();
  if (normal.empty() || normal == "." || normal.filename() == "..") normal = fs::canonical(sensors);
  return normal.string() + "-truth";
}

/// Fields of index.csv: quoted ones may hold commas.
std::vector<std::string> CsvFields(const std::string& row) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char c : row) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

/// The rows of index.csv, by the names of its columns.
struct IndexRow {
  int line = 0;
  std::map<std::string, std::string> values;
};

std::vector<IndexRow> ReadIndex(const fs::path& file, Problems& problems) {
  CheckedTable table(file, '\n', 1, problems);
  std::vector<IndexRow> rows;
  if (table.size() == 0) return rows;
  const std::vector<std::string> header = CsvFields(table.Text(0, 0));
  for (size_t i = 1; i < table.size(); ++i) {
    const std::vector<std::string> fields = CsvFields(table.Text(i, 0));
    if (fields.size() != header.size()) {
      table.Fail(i, fmt::format("has {} fields, the first row has {}", fields.size(), header.size()));
      continue;
    }
    IndexRow row{table.line(i), {}};
    for (size_t k = 0; k < header.size(); ++k) row.values[header[k]] = fields[k];
    rows.push_back(row);
  }
  return rows;
}

void CheckIndex(const fs::path& folder, DatasetReport& report) {
  const fs::path index = folder / "index.csv";
  std::set<fs::path> listed;
  for (IndexRow& row : ReadIndex(index, report.problems)) {
    const auto fail = [&](const std::string& message) { report.problems.push_back({index, row.line, message}); };
    const std::string path = row.values["path"], truth = row.values["truth_path"];
    const DatasetFolders folders{folder / path, folder / truth};
    if (!listed.insert(path).second) fail("lists the sequence " + path + " again");
    listed.insert(truth);
    if (path.empty() || !fs::is_directory(folders.sensors)) {
      fail("lists the sequence " + row.values["name"] + ", but there is no folder " + folders.sensors.string());
      continue;
    }
    if (!fs::is_directory(folders.truth)) fail("the truth " + folders.truth.string() + " is missing");
    try {
      AddSequence(folders, report);
    } catch (const BadInput& e) {
      fail(e.what());
      continue;
    }
    if (std::to_string(report.sequences.back().frames) != row.values["frames"])
      fail(fmt::format("says {} frames, there are {}", row.values["frames"], report.sequences.back().frames));
  }
  std::set<fs::path> unlisted;
  for (const auto& entry : fs::directory_iterator(folder / "sequences")) {
    const fs::path relative = fs::path("sequences") / entry.path().filename();
    if (listed.count(relative) == 0) unlisted.insert(entry.path());
  }
  for (const fs::path& path : unlisted) report.problems.push_back({path, 0, "is not listed in " + index.string()});
}

void CheckSums(const fs::path& folder, DatasetReport& report) {
  const fs::path sums = folder / kSums;
  CheckedTable table(sums, ' ', 2, report.problems);
  if (!table.was_read()) return;
  std::set<fs::path> summed{sums};
  for (size_t row = 0; row < table.size(); ++row) {
    const fs::path file = folder / table.Text(row, 1);
    summed.insert(file);
    try {
      if (!fs::exists(file)) {
        table.Fail(row, file.string() + " is missing");
      } else if (Sha256OfFile(file) != table.Text(row, 0)) {
        table.Fail(row, file.string() + " is not the file that was recorded: its checksum differs");
      }
    } catch (const BadInput& e) {
      table.Fail(row, e.what());
    }
  }
  report.files_summed = int64_t(table.size());
  std::set<fs::path> others;
  for (fs::recursive_directory_iterator it(folder), end; it != end; ++it) {
    if (it->path().filename().string()[0] == '.') {
      it.disable_recursion_pending();
    } else if (it->is_regular_file() && summed.count(it->path()) == 0) {
      others.insert(it->path());
    }
  }
  for (const fs::path& file : others) report.problems.push_back({file, 0, "has no checksum in " + sums.string()});
}

}  // namespace

DatasetReport CheckDataset(const fs::path& given) {
  DatasetReport report;
  const fs::path folder = given.has_filename() ? given : given.parent_path();
  if (fs::exists(folder / "index.csv") || fs::is_directory(folder / "sequences")) {
    CheckIndex(folder, report);
    CheckSums(folder, report);
    if (!fs::exists(folder / "README.md"))
      report.problems.push_back({folder / "README.md", 0, "the data card is missing"});
    return report;
  }
  const fs::path sensors = FindDataset(folder);
  AddSequence({sensors, TruthBeside(sensors)}, report);
  return report;
}

}  // namespace gaitcam
