/// Tables in text files, read row by row with errors that point at file and line; numbers written so that they come
/// back.

#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace gaitcam {

/// A text file of rows of fields. Blank lines and lines that begin with '#' are skipped; line ends may be \n or \r\n.
class TextTable {
 public:
  /// @param separator ',' or ' ' (which stands for any run of blanks and tabs)
  /// @throws BadInput if the file cannot be read.
  TextTable(std::filesystem::path file, char separator);

  /// Moves to the next row. @returns false at the end of the file. @throws BadInput if reading breaks off before it.
  bool Next();
  size_t size() const { return fields_.size(); }
  /// The column of this name, where the present row names the columns. @throws BadInput if there is none.
  size_t ColumnNamed(std::string_view name) const;
  const std::filesystem::path& file() const { return file_; }
  int line() const { return line_; }

  /// Each throws BadInput naming file, line and `what` if the field is absent or is not what is asked for.
  std::string_view Text(size_t column, std::string_view what) const;
  double Number(size_t column, std::string_view what) const;  ///< Finite.
  int64_t Integer(size_t column, std::string_view what) const;
  int64_t SecondsAsNs(size_t column, std::string_view what) const;  ///< Exact to the nanosecond.

  /// @throws BadInput "file:line: message".
  [[noreturn]] void Fail(const std::string& message) const;

 private:
  std::filesystem::path file_;
  char separator_;
  std::ifstream stream_;
  std::string text_;
  std::vector<std::string_view> fields_;
  int line_ = 0;
};

/// The shortest text that reads back as the same double.
std::string ExactText(double value);

/// "[1, 2.5, -3]", of such texts.
std::string ExactList(const std::vector<double>& values);

/// Seconds with nine decimals: exact for every stamp.
std::string SecondsText(int64_t stamp_ns);

/// Nanoseconds of a decimal number of seconds, without going through a double. @returns false if it is not a number.
bool ParseSeconds(std::string_view text, int64_t& stamp_ns);

}  // namespace gaitcam
