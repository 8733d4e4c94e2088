#include "scenarios/code/datasets/checked_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/io/text_table.h"

namespace gaitcam {
namespace {

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> fields;
  if (separator == ' ') {
    for (size_t at = 0; (at = text.find_first_not_of(" \t", at)) != std::string::npos;) {
      const size_t end = std::min(text.find_first_of(" \t", at), text.size());
      fields.push_back(text.substr(at, end - at));
      at = end;
    }
    return fields;
  }
  size_t begin = 0;
  for (size_t end; (end = text.find(separator, begin)) != std::string::npos; begin = end + 1)
    fields.push_back(text.substr(begin, end - begin));
  fields.push_back(text.substr(begin));
  return fields;
}

}  // namespace

std::string Problem::ToText() const {
  return line > 0 ? fmt::format("{}:{}: {}", file.string(), line, message)
                  : fmt::format("{}: {}", file.string(), message);
}

CheckedTable::CheckedTable(std::filesystem::path file, char separator, size_t columns, Problems& problems,
                           bool names_columns)
    : file_(std::move(file)), problems_(problems) {
  std::istringstream stream;
  try {
    stream.str(FileContent(file_));
    was_read_ = true;
  } catch (const BadInput&) {
    FailWhole("cannot read this file");
    return;
  }
  std::string text;
  for (int line = 1; std::getline(stream, text); ++line) {
    if (!text.empty() && text.back() == '\r') text.pop_back();
    if (text.find_first_not_of(" \t") == std::string::npos || text[0] == '#') {
      if (line == leading_comments_ + 1) ++leading_comments_;
      continue;
    }
    if (names_columns && names_.empty()) {
      names_ = Split(text, separator);
      continue;
    }
    Row row{line, Split(text, separator)};
    if (row.fields.size() < columns) {
      problems_.push_back(
          {file_, line, fmt::format("has {} fields, expected at least {}", row.fields.size(), columns)});
    } else {
      rows_.push_back(std::move(row));
    }
  }
}

std::optional<size_t> CheckedTable::ColumnNamed(const std::string& name) {
  const auto at = std::find(names_.begin(), names_.end(), name);
  if (at != names_.end()) return size_t(at - names_.begin());
  if (was_read_) problems_.push_back({file_, 1, fmt::format("names no column \"{}\"", name)});
  return std::nullopt;
}

void CheckedTable::Fail(size_t row, const std::string& message) { problems_.push_back({file_, line(row), message}); }
void CheckedTable::FailWhole(const std::string& message) { problems_.push_back({file_, 0, message}); }

std::optional<double> CheckedTable::Number(size_t row, size_t column, const std::string& what) {
  const std::string& text = Text(row, column);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && std::isfinite(value)) return value;
  Fail(row, fmt::format("{} is \"{}\", expected a finite number", what, text));
  return std::nullopt;
}

std::optional<int64_t> CheckedTable::Integer(size_t row, size_t column, const std::string& what) {
  const std::string& text = Text(row, column);
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size()) return value;
  Fail(row, fmt::format("{} is \"{}\", expected a whole number", what, text));
  return std::nullopt;
}

std::vector<std::optional<int64_t>> CheckedTable::Stamps(bool seconds, size_t column) {
  std::vector<std::optional<int64_t>> stamps;
  std::optional<int64_t> last;
  for (size_t row = 0; row < size(); ++row) {
    std::optional<int64_t> stamp;
    int64_t ns = 0;
    if (!seconds) {
      stamp = Integer(row, column, "the time in nanoseconds");
    } else if (ParseSeconds(Text(row, column), ns)) {
      stamp = ns;
    } else {
      Fail(row, fmt::format("the time in seconds is \"{}\", expected a number", Text(row, column)));
    }
    if (stamp && last && *stamp == *last) Fail(row, fmt::format("time {} s is there twice", SecondsText(*stamp)));
    if (stamp && last && *stamp < *last) {
      Fail(row,
           fmt::format("time {} s comes before that of the row above, {} s", SecondsText(*stamp), SecondsText(*last)));
    }
    if (stamp) last = stamp;
    stamps.push_back(stamp);
  }
  return stamps;
}

void CheckedTable::UnitQuaternion(size_t row, size_t column, double tolerance, const std::string& what) {
  double squared = 0;
  for (size_t i = 0; i < 4; ++i) {
    const std::optional<double> q = Number(row, column + i, what + ": a part of its quaternion");
    if (!q) return;
    squared += *q * *q;
  }
  const double length = std::sqrt(squared);
  if (std::abs(length - 1) > tolerance)
    Fail(row, fmt::format("{}: its quaternion has length {:.6g}, expected 1", what, length));
}

void CompareStamps(const std::vector<std::optional<int64_t>>& stamps, CheckedTable& table,
                   const std::vector<int64_t>& frames, const std::string& named) {
  const std::set<int64_t> wanted(frames.begin(), frames.end());
  std::set<int64_t> there;
  for (size_t row = 0; row < stamps.size(); ++row) {
    if (!stamps[row]) continue;
    there.insert(*stamps[row]);
    if (wanted.count(*stamps[row]) == 0)
      table.Fail(row, fmt::format("{} has no frame at {} s", named, SecondsText(*stamps[row])));
  }
  constexpr int kMaxListed = 20;
  int missing = 0;
  for (const int64_t stamp : wanted) {
    if (there.count(stamp) == 0 && ++missing <= kMaxListed)
      table.FailWhole(fmt::format("has no row for the frame at {} s of {}", SecondsText(stamp), named));
  }
  if (missing > kMaxListed) table.FailWhole(fmt::format("... nor for {} frames more", missing - kMaxListed));
}

}  // namespace gaitcam
