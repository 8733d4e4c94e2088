/// Tables for validation: read to the end, every fault kept with its file and line, where a reader stops at the first.

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace gaitcam {

/// One fault of a dataset.
struct Problem {
  std::filesystem::path file;
  int line = 0;  ///< 0: of the file as a whole.
  std::string message;

  /// "file:line: message"
  std::string ToText() const;
};

using Problems = std::vector<Problem>;

class CheckedTable {
 public:
  /// @param separator ',' or ' ' (any run of blanks). Rows of fewer than `columns` fields are faults and left out.
  /// @param names_columns the first row is not data but names the columns.
  CheckedTable(std::filesystem::path file, char separator, size_t columns, Problems& problems,
               bool names_columns = false);

  bool was_read() const { return was_read_; }
  size_t size() const { return rows_.size(); }
  const std::filesystem::path& file() const { return file_; }
  int line(size_t row) const { return rows_[row].line; }
  const std::string& Text(size_t row, size_t column) const { return rows_[row].fields[column]; }
  /// Lines of comment before the first row.
  int leading_comments() const { return leading_comments_; }
  /// A fault if no column has this name.
  std::optional<size_t> ColumnNamed(const std::string& name);
  size_t columns(size_t row) const { return rows_[row].fields.size(); }

  /// A fault unless the field is a finite number.
  std::optional<double> Number(size_t row, size_t column, const std::string& what);
  std::optional<int64_t> Integer(size_t row, size_t column, const std::string& what);
  /// The times of all rows, faults unless they are times that increase. Rows without a time get none.
  /// @param seconds of TUM's tables; else whole nanoseconds.
  std::vector<std::optional<int64_t>> Stamps(bool seconds, size_t column = 0);
  /// A fault unless the quaternion (four columns in any order) has length 1 to `tolerance`.
  void UnitQuaternion(size_t row, size_t column, double tolerance, const std::string& what);

  void Fail(size_t row, const std::string& message);
  void FailWhole(const std::string& message);

 private:
  struct Row {
    int line = 0;
    std::vector<std::string> fields;
  };

  std::filesystem::path file_;
  Problems& problems_;
  bool was_read_ = false;
  int leading_comments_ = 0;
  std::vector<std::string> names_;
  std::vector<Row> rows_;
};

/// Faults where the table's stamps differ from those of the frames, each reported once.
/// @param frames stamps of the frames, of the table called `named`.
void CompareStamps(const std::vector<std::optional<int64_t>>& stamps, CheckedTable& table,
                   const std::vector<int64_t>& frames, const std::string& named);

}  // namespace gaitcam
