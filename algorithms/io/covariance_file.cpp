#include "algorithms/io/covariance_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "algorithms/core/errors.h"
#include "algorithms/io/text_table.h"
#include "algorithms/io/whole_file.h"

namespace gaitcam {
namespace {

constexpr const char* kEstimate = "estimate";

/// Names of the columns of one matrix: ",c11,c12,...".
std::string ColumnNames(char letter) {
  std::string names;
  for (int row = 1; row <= 6; ++row) {
    for (int col = row; col <= 6; ++col) names += "," + (letter + std::to_string(row)) + std::to_string(col);
  }
  return names;
}

std::string CommonNames(Eigen::Index errors) {
  std::string names;
  for (Eigen::Index error = 1; error <= errors; ++error) {
    for (int row = 1; row <= 6; ++row) names += fmt::format(",g{}{}", error, row);
  }
  return names;
}

std::string UpperTriangle(const Matrix6d& covariance) {
  std::string numbers;
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) numbers += "," + ExactText(covariance(row, col));
  }
  return numbers;
}

Matrix6d ReadUpperTriangle(TextTable& table, size_t column) {
  Matrix6d covariance;
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) {
      covariance(row, col) = covariance(col, row) = table.Number(column++, "a covariance");
    }
  }
  return covariance;
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
  bool any_own = false;
  Eigen::Index common = 0;
  for (const FrameEstimate& frame : frames) {
    if (!frame.covariance) continue;
    rows += std::to_string(frame.stamp_ns) + UpperTriangle(*frame.covariance);
    if (frame.own_covariance) rows += UpperTriangle(*frame.own_covariance);
    for (const double number : frame.common_errors.reshaped()) rows += "," + ExactText(number);
    common = std::max(common, frame.common_errors.cols());
    any_own |= frame.own_covariance.has_value();
    rows += "\n";
  }
  if (rows.empty()) return false;
  WriteWholeFile(
      file, "#stamp_ns" + ColumnNames('c') + (any_own ? ColumnNames('o') : "") + CommonNames(common) + "\n" + rows);
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
    constexpr size_t kNumbers = 21;
    entry.covariance = ReadUpperTriangle(table, 1);
    if (table.size() > 1 + kNumbers) entry.own_covariance = ReadUpperTriangle(table, 1 + kNumbers);
    for (size_t column = 1 + 2 * kNumbers; column < table.size(); column += 6) {
      entry.common_errors.conservativeResize(6, entry.common_errors.cols() + 1);
      for (size_t row = 0; row < 6; ++row) {
        entry.common_errors(long(row), entry.common_errors.cols() - 1) = table.Number(column + row, "an error");
      }
    }
    covariances.push_back(entry);
  }
  return covariances;
}

}  // namespace gaitcam
