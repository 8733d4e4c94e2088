#include "algorithms/io/trajectory_file.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/fields.h"
#include "algorithms/io/text_table.h"
#include "algorithms/io/whole_file.h"

namespace gaitcam {
namespace {

constexpr size_t kTumFields = 8, kKittiFields = 12, kEurocFields = 8;
constexpr double kMaxUnitError = 0.01;  // published files round quaternions to four digits and matrices to six

TrajectoryFormat FormatOf(const std::filesystem::path& file) {
  TextTable table(file, ' ');
  if (!table.Next()) throw BadInput(file.string() + ": holds no pose; expected a TUM, KITTI or EuRoC trajectory");
  for (size_t i = 0; i < table.size(); ++i) {
    if (table.Text(i, "a number").find(',') != std::string_view::npos) return TrajectoryFormat::kEuroc;
  }
  if (table.size() == kTumFields) return TrajectoryFormat::kTum;
  if (table.size() == kKittiFields) return TrajectoryFormat::kKitti;
  table.Fail("a row of " + std::to_string(table.size()) +
             " fields; expected 8 (TUM: t x y z qx qy qz qw), 12 (KITTI: a 3 x 4 matrix) or commas (EuRoC)");
}

/// A quaternion as it stands in the file if it already is of unit length, else normalised.
Eigen::Quaterniond Rotation(const TextTable& table, double w, double x, double y, double z) {
  Eigen::Quaterniond q(w, x, y, z);
  const double norm = q.norm();
  if (std::abs(norm - 1) > kMaxUnitError) {
    table.Fail("the quaternion's length is " + ExactText(norm) + "; expected 1");
  }
  constexpr double kRounding = 1e-14;
  if (std::abs(norm - 1) > kRounding) q.coeffs() /= norm;
  return q;
}

void CheckSize(const TextTable& table, size_t expected, const char* format) {
  if (table.size() == expected) return;
  table.Fail("a row of " + std::to_string(table.size()) + " fields; expected " + std::to_string(expected) + " (" +
             format + ")");
}

StampedPose TumPose(const TextTable& table) {
  CheckSize(table, kTumFields, "TUM: t x y z qx qy qz qw");
  StampedPose pose;
  pose.stamp_ns = table.SecondsAsNs(0, "the time in seconds");
  for (int i = 0; i < 3; ++i) pose.pose.translation[i] = table.Number(size_t(1 + i), "a coordinate in metres");
  const auto q = [&](size_t column) { return table.Number(column, "a part of a quaternion x y z w"); };
  pose.pose.rotation = Rotation(table, q(7), q(4), q(5), q(6));
  return pose;
}

StampedPose EurocPose(const TextTable& table) {
  StampedPose pose;
  pose.stamp_ns = table.Integer(0, "the time in nanoseconds");
  for (int i = 0; i < 3; ++i) pose.pose.translation[i] = table.Number(size_t(1 + i), "a coordinate in metres");
  const auto q = [&](size_t column) { return table.Number(column, "a part of a quaternion w, x, y, z"); };
  pose.pose.rotation = Rotation(table, q(4), q(5), q(6), q(7));
  return pose;
}

Pose KittiPose(const TextTable& table) {
  CheckSize(table, kKittiFields, "KITTI: the upper 3 x 4 of a pose matrix");
  Eigen::Matrix<double, 3, 4> M;
  for (int i = 0; i < 12; ++i) M(i / 4, i % 4) = table.Number(size_t(i), "a number of a 3 x 4 pose matrix");
  const Eigen::Matrix3d R = M.leftCols<3>();
  if ((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > kMaxUnitError || R.determinant() < 0) {
    table.Fail("columns 1-3, 5-7 and 9-11 are not a rotation matrix");
  }
  return {R, M.col(3)};
}

void CheckIncreases(const TextTable& table, const Trajectory& trajectory, int64_t stamp_ns) {
  if (trajectory.empty() || stamp_ns > trajectory.back().stamp_ns) return;
  table.Fail("time " + SecondsText(stamp_ns) + " s does not come after the row before it (" +
             SecondsText(trajectory.back().stamp_ns) + " s)");
}

Trajectory ReadStamped(const std::filesystem::path& file, TrajectoryFormat format, StampOrder order) {
  TextTable table(file, format == TrajectoryFormat::kTum ? ' ' : ',');
  Trajectory trajectory;
  while (table.Next()) {
    const StampedPose pose = format == TrajectoryFormat::kTum ? TumPose(table) : EurocPose(table);
    if (order == StampOrder::kStrict) CheckIncreases(table, trajectory, pose.stamp_ns);
    trajectory.push_back(pose);
  }
  return trajectory;
}

Trajectory ReadKitti(const std::filesystem::path& file, const std::filesystem::path& times_file, StampOrder order) {
  TextTable table(file, ' ');
  std::optional<TextTable> times;
  if (!times_file.empty()) times.emplace(times_file, ' ');
  Trajectory trajectory;
  while (table.Next()) {
    int64_t stamp_ns = int64_t(trajectory.size()) * 1'000'000'000;
    if (times) {
      if (!times->Next()) table.Fail("has no time: " + times_file.string() + " has fewer rows");
      stamp_ns = times->SecondsAsNs(0, "a time in seconds");
      if (order == StampOrder::kStrict) CheckIncreases(*times, trajectory, stamp_ns);
    }
    trajectory.push_back({stamp_ns, KittiPose(table)});
  }
  if (times && times->Next()) times->Fail("has no pose: " + file.string() + " has fewer rows");
  return trajectory;
}

}  // namespace

std::string ToString(TrajectoryFormat format) { return std::string(ToWord(format)); }

TrajectoryFormat TrajectoryFormatFromText(const std::string& text) {
  for (const auto format : {TrajectoryFormat::kTum, TrajectoryFormat::kKitti, TrajectoryFormat::kEuroc}) {
    if (text == ToString(format)) return format;
  }
  throw BadInput("trajectory format " + text + ": expected one of tum, kitti, euroc");
}

std::vector<std::string> RepairStamps(const std::string& name, Trajectory& trajectory) {
  std::vector<std::string> remarks;
  const auto earlier = [](const StampedPose& a, const StampedPose& b) { return a.stamp_ns < b.stamp_ns; };
  size_t back = 0;
  for (size_t i = 1; i < trajectory.size(); ++i) back += earlier(trajectory[i], trajectory[i - 1]) ? 1 : 0;
  if (back > 0) {
    std::stable_sort(trajectory.begin(), trajectory.end(), earlier);
    remarks.push_back(fmt::format("{}: {} row{} earlier than the one before: sorted by time", name, back,
                                  back == 1 ? " is" : "s are"));
  }
  const size_t rows = trajectory.size();
  const auto same = [](const StampedPose& a, const StampedPose& b) { return a.stamp_ns == b.stamp_ns; };
  trajectory.erase(std::unique(trajectory.begin(), trajectory.end(), same), trajectory.end());
  if (const size_t twice = rows - trajectory.size(); twice > 0) {
    remarks.push_back(fmt::format("{}: {} row{} the stamp of another: the first is kept", name, twice,
                                  twice == 1 ? " has" : "s have"));
  }
  return remarks;
}

TrajectoryFile ReadTrajectory(const std::filesystem::path& file, std::optional<TrajectoryFormat> format,
                              const std::filesystem::path& kitti_times, StampOrder order) {
  TrajectoryFile result;
  result.format = format ? *format : FormatOf(file);
  result.trajectory = result.format == TrajectoryFormat::kKitti ? ReadKitti(file, kitti_times, order)
                                                                : ReadStamped(file, result.format, order);
  if (order == StampOrder::kRepaired) result.remarks = RepairStamps(file.string(), result.trajectory);
  if (result.trajectory.empty()) throw BadInput(file.string() + ": holds no pose");
  return result;
}

std::string TrajectoryHeader(TrajectoryFormat format) {
  switch (format) {
    case TrajectoryFormat::kTum: return "# timestamp tx ty tz qx qy qz qw\n";
    case TrajectoryFormat::kKitti: return "";
    case TrajectoryFormat::kEuroc: return "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []\n";
  }
  GAITCAM_ASSERT(false);
  return {};
}

std::string TrajectoryRow(const StampedPose& pose, TrajectoryFormat format) {
  const Eigen::Vector3d& t = pose.pose.translation;
  const Eigen::Quaterniond& q = pose.pose.rotation;
  std::string row;
  std::vector<double> numbers;
  const char separator = format == TrajectoryFormat::kEuroc ? ',' : ' ';
  switch (format) {
    case TrajectoryFormat::kTum:
      row = SecondsText(pose.stamp_ns);
      numbers = {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
      break;
    case TrajectoryFormat::kEuroc:
      row = std::to_string(pose.stamp_ns);
      numbers = {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()};
      break;
    case TrajectoryFormat::kKitti: {
      const Eigen::Matrix4d M = pose.pose.Matrix();
      for (int i = 0; i < 12; ++i) numbers.push_back(M(i / 4, i % 4));
      break;
    }
  }
  for (const double number : numbers) {
    if (!row.empty()) row += separator;
    row += ExactText(number);
  }
  return row;
}

void WriteTrajectory(const std::filesystem::path& file, const Trajectory& trajectory, TrajectoryFormat format) {
  std::string text = TrajectoryHeader(format);
  for (const StampedPose& pose : trajectory) text += TrajectoryRow(pose, format) + "\n";
  WriteWholeFile(file, text);
}

}  // namespace gaitcam
