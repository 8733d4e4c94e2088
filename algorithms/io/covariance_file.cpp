#include "algorithms/io/covariance_file.h"

#include <string>

#include "algorithms/core/errors.h"
#include "algorithms/io/text_table.h"

namespace gaitcam {
namespace {

constexpr const char* kEstimate = "estimate";

std::string Header() {
  std::string header = "#stamp_ns";
  for (int row = 1; row <= 6; ++row) {
    for (int col = row; col <= 6; ++col) header += ",c" + std::to_string(row) + std::to_string(col);
  }
  return header + "\n";
}

}  // namespace

std::filesystem::path CovarianceFileOf(const std::filesystem::path& trajectory) {
  std::string stem = trajectory.stem().string();
  if (stem.starts_with(kEstimate)) {
    stem.replace(0, std::string(kEstimate).size(), "covariances");
  } else {
    stem += "-covariances";
  }
  return trajectory.parent_path() / (stem + ".csv");
}

bool WriteCovariances(const std::filesystem::path& file, const std::vector<FrameEstimate>& frames) {
  std::string rows;
  for (const FrameEstimate& frame : frames) {
    if (!frame.covariance) continue;
    rows += std::to_string(frame.stamp_ns);
    for (int row = 0; row < 6; ++row) {
      for (int col = row; col < 6; ++col) rows += "," + ExactText((*frame.covariance)(row, col));
    }
    rows += "\n";
  }
  if (rows.empty()) return false;
  WriteWholeFile(file, Header() + rows);
  return true;
}

std::vector<StampedCovariance> ReadCovariances(const std::filesystem::path& file) {
  std::vector<StampedCovariance> covariances;
  TextTable table(file, ',');
  while (table.Next()) {
    StampedCovariance entry;
    entry.stamp_ns = table.Integer(0, "the time in ns");
    if (!covariances.empty() && entry.stamp_ns <= covariances.back().stamp_ns)
      table.Fail("its time does not come after the row before it");
    size_t column = 1;
    for (int row = 0; row < 6; ++row) {
      for (int col = row; col < 6; ++col) {
        entry.covariance(row, col) = entry.covariance(col, row) = table.Number(column++, "a covariance");
      }
    }
    covariances.push_back(entry);
  }
  return covariances;
}

}  // namespace gaitcam
