#include "algorithms/io/text_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int kNsDigits = 9;
constexpr size_t kMaxDigits = 19;  // of an int64_t

std::string_view Trim(std::string_view text) {
  const size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> fields;
  const std::string_view ends = separator == ' ' ? std::string_view(" \t") : std::string_view(",");
  while (true) {
    const size_t end = text.find_first_of(ends);
    fields.push_back(Trim(text.substr(0, end)));
    if (end == std::string_view::npos) return fields;
    text.remove_prefix(end + 1);
    if (separator == ' ') text = Trim(text);
  }
}

template <class T>
bool Parse(std::string_view text, T& value) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

std::string Quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

}  // namespace

TextTable::TextTable(std::filesystem::path file, char separator)
    : file_(std::move(file)), separator_(separator), stream_(file_) {
  GAITCAM_ASSERT(separator == ',' || separator == ' ');
  if (!stream_ || std::filesystem::is_directory(file_)) throw BadInput(file_.string() + ": cannot read this file");
}

bool TextTable::Next() {
  while (std::getline(stream_, text_)) {
    ++line_;
    const std::string_view row = Trim(text_);
    if (row.empty() || row.front() == '#') continue;
    fields_ = Split(row, separator_);
    return true;
  }
  if (stream_.bad()) throw BadInput(file_.string() + ": reading broke off after line " + std::to_string(line_));
  fields_.clear();
  return false;
}

size_t TextTable::ColumnNamed(std::string_view name) const {
  const auto at = std::find(fields_.begin(), fields_.end(), name);
  if (at == fields_.end()) Fail("the first row names no column " + Quoted(name));
  return size_t(at - fields_.begin());
}

std::string_view TextTable::Text(size_t column, std::string_view what) const {
  if (column >= fields_.size()) {
    Fail("the row ends after " + std::to_string(fields_.size()) + " fields; field " + std::to_string(column + 1) +
         " should be " + std::string(what));
  }
  return fields_[column];
}

double TextTable::Number(size_t column, std::string_view what) const {
  const std::string_view text = Text(column, what);
  double value = 0;
  if (!Parse(text, value) || !std::isfinite(value)) {
    Fail(Quoted(text) + " is not a finite number; field " + std::to_string(column + 1) + " should be " +
         std::string(what));
  }
  return value;
}

int64_t TextTable::Integer(size_t column, std::string_view what) const {
  const std::string_view text = Text(column, what);
  int64_t value = 0;
  if (!Parse(text, value)) {
    Fail(Quoted(text) + " is not a whole number; field " + std::to_string(column + 1) + " should be " +
         std::string(what));
  }
  return value;
}

int64_t TextTable::SecondsAsNs(size_t column, std::string_view what) const {
  const std::string_view text = Text(column, what);
  int64_t value = 0;
  if (!ParseSeconds(text, value)) {
    Fail(Quoted(text) + " is not a time in seconds; field " + std::to_string(column + 1) + " should be " +
         std::string(what));
  }
  return value;
}

void TextTable::Fail(const std::string& message) const {
  throw BadInput(file_.string() + ":" + std::to_string(line_) + ": " + message);
}

std::string ExactText(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr};
}

std::string ExactList(const std::vector<double>& values) {
  std::string text = "[";
  for (size_t i = 0; i < values.size(); ++i) text += (i ? ", " : "") + ExactText(values[i]);
  return text + "]";
}

std::string SecondsText(int64_t stamp_ns) {
  const bool negative = stamp_ns < 0;
  std::string digits = std::to_string(negative ? -uint64_t(stamp_ns) : uint64_t(stamp_ns));
  if (digits.size() <= kNsDigits) digits.insert(0, kNsDigits + 1 - digits.size(), '0');
  digits.insert(digits.size() - kNsDigits, ".");
  return (negative ? "-" : "") + digits;
}

bool ParseSeconds(std::string_view text, int64_t& stamp_ns) {
  bool negative = false;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    negative = text.front() == '-';
    text.remove_prefix(1);
  }
  int exponent = kNsDigits;
  const size_t e = text.find_first_of("eE");
  if (e != std::string_view::npos) {
    int power = 0;
    if (!Parse(text.substr(e + 1), power) || std::abs(power) > 100) return false;
    exponent += power;
    text = text.substr(0, e);
  }
  std::string digits;
  bool point = false;
  for (const char c : text) {
    if (c == '.' && !point) {
      point = true;
    } else if (c >= '0' && c <= '9') {
      digits += c;
      exponent -= point;
    } else {
      return false;
    }
  }
  if (digits.empty()) return false;
  bool round_up = false;  // what lies beyond the nanosecond
  for (; exponent < 0 && !digits.empty(); ++exponent) {
    round_up = digits.back() >= '5';
    digits.pop_back();
  }
  if (exponent < 0) round_up = false;
  digits.erase(0, digits.find_first_not_of('0'));
  if (digits.empty()) {
    stamp_ns = round_up ? (negative ? -1 : 1) : 0;
    return true;
  }
  if (digits.size() + size_t(std::max(exponent, 0)) > kMaxDigits) return false;
  digits.append(size_t(std::max(exponent, 0)), '0');
  if (!Parse(std::string_view(digits), stamp_ns)) return false;
  if (round_up && stamp_ns == std::numeric_limits<int64_t>::max()) return false;
  stamp_ns = (negative ? -1 : 1) * (stamp_ns + round_up);
  return true;
}

}  // namespace gaitcam
