#include "algorithms/io/trajectory_file.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <charconv>
#include <cmath>
#include <fstream>
#include <vector>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

using Columns = std::vector<std::string>;

/// The words of a line, split at blanks and commas; a comment yields none.
Columns Split(const std::string& line) {
  Columns columns(1);
  for (const char c : line.substr(0, line.find('#'))) {
    if (c == ' ' || c == '\t' || c == ',' || c == '\r') {
      if (!columns.back().empty()) columns.emplace_back();
    } else {
      columns.back() += c;
    }
  }
  if (columns.back().empty()) columns.pop_back();
  return columns;
}

/// One line of a file, and how to complain about it.
struct Line {
  const std::filesystem::path& file;
  int number = 0;
  Columns columns;

  [[noreturn]] void Fail(const std::string& message) const {
    throw BadInput(fmt::format("{}:{}: {}", file.string(), number, message));
  }

  double Number(size_t column) const {
    const std::string& text = columns[column];
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      Fail(fmt::format("column {}: \"{}\" is not a finite number", column + 1, text));
    }
    return value;
  }

  Eigen::Quaterniond Quaternion(size_t w, size_t x, size_t y, size_t z) const {
    const Eigen::Quaterniond q(Number(w), Number(x), Number(y), Number(z));
    if (std::abs(q.norm() - 1) > 1e-2) Fail(fmt::format("the quaternion's length is {:g}, not 1", q.norm()));
    return q.normalized();
  }
};

StampedPose ParseTum(const Line& line) {
  StampedPose pose;
  if (!ParseSeconds(line.columns[0], pose.stamp_ns)) {
    line.Fail("column 1: \"" + line.columns[0] + "\" is not a time in seconds");
  }
  pose.pose = {line.Quaternion(7, 4, 5, 6), {line.Number(1), line.Number(2), line.Number(3)}};
  return pose;
}

StampedPose ParseEuroc(const Line& line) {
  StampedPose pose;
  const std::string& text = line.columns[0];
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), pose.stamp_ns);
  if (error != std::errc() || end != text.data() + text.size()) {
    line.Fail("column 1: \"" + text + "\" is not a time in whole nanoseconds");
  }
  pose.pose = {line.Quaternion(4, 5, 6, 7), {line.Number(1), line.Number(2), line.Number(3)}};
  return pose;
}

StampedPose ParseKitti(const Line& line, size_t index) {
  Eigen::Matrix<double, 3, 4> m;
  for (int i = 0; i < 12; ++i) m(i / 4, i % 4) = line.Number(size_t(i));
  const Eigen::Matrix3d R = m.leftCols<3>();
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-2 || R.determinant() < 0) {
    line.Fail("columns 1-3, 5-7, 9-11 are not a rotation matrix");
  }
  return {int64_t(index) * 1'000'000'000, {R, m.col(3)}};
}

TrajectoryFormat GuessFormat(const Line& line, const std::string& text) {
  if (text.find(',') != std::string::npos && line.columns.size() >= 8) return TrajectoryFormat::kEuroc;
  if (line.columns.size() == 8) return TrajectoryFormat::kTum;
  if (line.columns.size() == 12) return TrajectoryFormat::kKitti;
  line.Fail(
      fmt::format("{} columns; expected 8 (TUM: stamp tx ty tz qx qy qz qw), 12 (KITTI: a 3 x 4 matrix), or "
                  "comma-separated EuRoC (stamp, position, quaternion w first)",
                  line.columns.size()));
}

StampedPose ParseLine(const Line& line, TrajectoryFormat format, size_t index) {
  const size_t expected = format == TrajectoryFormat::kKitti ? 12 : 8;
  if (format == TrajectoryFormat::kEuroc ? line.columns.size() < expected : line.columns.size() != expected) {
    line.Fail(fmt::format("{} columns; expected {} as in the lines before", line.columns.size(), expected));
  }
  switch (format) {
    case TrajectoryFormat::kTum: return ParseTum(line);
    case TrajectoryFormat::kEuroc: return ParseEuroc(line);
    case TrajectoryFormat::kKitti: return ParseKitti(line, index);
  }
  GAITCAM_ASSERT(false);
  return {};
}

}  // namespace

std::string ToString(TrajectoryFormat format) {
  switch (format) {
    case TrajectoryFormat::kTum: return "tum";
    case TrajectoryFormat::kKitti: return "kitti";
    case TrajectoryFormat::kEuroc: return "euroc";
  }
  GAITCAM_ASSERT(false);
  return {};
}

bool ParseSeconds(const std::string& text, int64_t& stamp_ns) {
  const size_t dot = text.find('.');
  if (dot == std::string::npos || text.find_first_of("eE") != std::string::npos) {
    double seconds = 0;  // no decimals to lose, or an exponent: binary floating point has to do
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
    if (error != std::errc() || end != text.data() + text.size() || !(std::abs(seconds) < 9e9)) return false;
    stamp_ns = std::llround(seconds * 1e9);
    return true;
  }
  std::string digits = text.substr(0, dot), decimals = text.substr(dot + 1);
  const bool negative = !digits.empty() && digits[0] == '-';
  if (negative) digits.erase(0, 1);
  if ((digits + decimals).empty() || (digits + decimals).find_first_not_of("0123456789") != std::string::npos)
    return false;
  if (digits.size() > 9 + 1) return false;
  const bool round_up = decimals.size() > 9 && decimals[9] >= '5';
  decimals.resize(9, '0');
  stamp_ns = (digits.empty() ? 0 : std::stoll(digits)) * 1'000'000'000 + std::stoll(decimals) + (round_up ? 1 : 0);
  if (negative) stamp_ns = -stamp_ns;
  return true;
}

std::string SecondsText(int64_t stamp_ns) {
  const int64_t magnitude = std::abs(stamp_ns);
  return fmt::format("{}{}.{:09d}", stamp_ns < 0 ? "-" : "", magnitude / 1'000'000'000, magnitude % 1'000'000'000);
}

TrajectoryFile ReadTrajectory(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream || std::filesystem::is_directory(file)) throw BadInput(file.string() + ": cannot read this file");
  TrajectoryFile result;
  std::string text;
  for (int number = 1; std::getline(stream, text); ++number) {
    const Line line{file, number, Split(text)};
    if (line.columns.empty()) continue;
    if (result.trajectory.empty()) result.format = GuessFormat(line, text);
    result.trajectory.push_back(ParseLine(line, result.format, result.trajectory.size()));
    const size_t n = result.trajectory.size();
    if (n > 1 && result.trajectory[n - 1].stamp_ns <= result.trajectory[n - 2].stamp_ns) {
      line.Fail("this stamp does not follow the one before; stamps must increase");
    }
  }
  if (result.trajectory.empty()) throw BadInput(file.string() + ": no pose in this file");
  return result;
}

std::string TrajectoryToText(const Trajectory& trajectory, TrajectoryFormat format) {
  std::string text;
  if (format == TrajectoryFormat::kTum) text = "# stamp_s tx ty tz qx qy qz qw (X_WC, stamp is mid-exposure)\n";
  if (format == TrajectoryFormat::kEuroc)
    text = "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []\n";
  for (const auto& [stamp_ns, pose] : trajectory) {
    const Eigen::Vector3d& t = pose.translation;
    const Eigen::Quaterniond& q = pose.rotation;
    switch (format) {
      case TrajectoryFormat::kTum:
        text += fmt::format("{} {} {} {} {} {} {} {}\n", SecondsText(stamp_ns), t.x(), t.y(), t.z(), q.x(), q.y(),
                            q.z(), q.w());
        break;
      case TrajectoryFormat::kEuroc:
        text += fmt::format("{},{},{},{},{},{},{},{}\n", stamp_ns, t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z());
        break;
      case TrajectoryFormat::kKitti: {
        const Eigen::Matrix4d m = pose.Matrix();
        for (int i = 0; i < 12; ++i) text += fmt::format("{}{}", m(i / 4, i % 4), i == 11 ? "\n" : " ");
        break;
      }
    }
  }
  return text;
}

void WriteTrajectory(const std::filesystem::path& file, const Trajectory& trajectory, TrajectoryFormat format) {
  const std::filesystem::path temporary = file.string() + ".part";
  std::ofstream stream(temporary, std::ios::binary);
  stream << TrajectoryToText(trajectory, format);
  stream.close();
  std::error_code error;
  if (stream) std::filesystem::rename(temporary, file, error);
  if (stream && !error) return;
  std::filesystem::remove(temporary, error);
  throw MissingResource("cannot write " + file.string() + " (disk full, or no permission)");
}

}  // namespace gaitcam
