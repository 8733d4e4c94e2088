#include "scenarios/code/datasets/sequence_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "algorithms/core/errors.h"
#include "algorithms/core/median.h"
#include "algorithms/io/calibration_file.h"
#include "algorithms/io/text_table.h"
#include "scenarios/code/datasets/image_check.h"
#include "scenarios/code/datasets/settings_check.h"
#include "scenarios/code/datasets/truth_check.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

std::vector<int64_t> StampsOf(const std::vector<CheckedImage>& images) {
  std::vector<int64_t> stamps;
  for (const CheckedImage& image : images) stamps.push_back(image.stamp_ns);
  return stamps;
}

/// Readers throw "file:line: message".
Problem ProblemOf(const BadInput& e, const fs::path& file) {
  const std::string text = e.what(), prefix = file.string() + ":";
  if (!text.starts_with(prefix)) return {file, 0, text};
  size_t at = prefix.size();
  int line = 0;
  for (; at < text.size() && std::isdigit(static_cast<unsigned char>(text[at])) != 0; ++at)
    line = 10 * line + text[at] - '0';
  if (line > 0 && at < text.size() && text[at] == ':') ++at;
  return {file, line, text.substr(std::min(text.size(), text.find_first_not_of(' ', at)))};
}

class SensorCheck {
 public:
  SensorCheck(fs::path folder, SequenceReport& report)
      : folder_(std::move(folder)),
        format_(FormatOfDataset(folder_)),
        by_ours_(fs::exists(folder_ / "about.txt") && fs::exists(folder_ / "exposure.csv")),
        report_(report),
        problems_(report.problems) {}

  void Run() {
    Calibrate();
    const CameraModel camera = calibration_ ? calibration_->camera : CameraModel();
    frames_ = CheckImages(Listing(ImageStream::kLeft), ImageKind::kPicture, camera, by_ours_, problems_);
    report_.frames = int64_t(frames_.size());
    report_.images = report_.frames;
    FindCopies();
    CheckOtherCameras(camera);
    CheckExposures({CheckImu(), CheckJoints(), CheckOdometry()});
    CheckTimes();
    if (!by_ours_) return;
    CheckEpoch();
    if (calibration_) CheckSettings(folder_, format_, *calibration_, StampsOf(frames_), problems_);
  }

  const std::vector<CheckedImage>& frames() const { return frames_; }
  const std::optional<Calibration>& calibration() const { return calibration_; }

 private:
  ImageListing Listing(ImageStream stream) const { return ListingOf(folder_, format_, stream); }
  std::string frames_name() const { return Listing(ImageStream::kLeft).table.lexically_relative(folder_).string(); }

  void Calibrate() {
    const fs::path file = CalibrationFileOf(folder_, format_);
    try {
      if (fs::exists(file) || format_ == DatasetFormat::kTum) calibration_ = ReadCalibration(file);
      if (format_ == DatasetFormat::kEuroc) CompareSensorYaml(ReadEurocCalibration(folder_ / "mav0"));
      if (format_ == DatasetFormat::kVslamlab && !calibration_)
        calibration_ = ReadVslamlabCalibration(folder_ / "calibration.yaml");
    } catch (const BadInput& e) {
      problems_.push_back(ProblemOf(e, file));
    }
  }

  /// The EuRoC layout holds the calibration twice.
  void CompareSensorYaml(const Calibration& other) {
    if (!calibration_) {
      calibration_ = other;
      return;
    }
    const auto compare = [&](const CameraModel& a, const CameraModel& b, const char* name) {
      const double ours[] = {a.fx, a.fy, a.cx, a.cy, a.k1, a.k2, a.p1, a.p2},
                   theirs[] = {b.fx, b.fy, b.cx, b.cy, b.k1, b.k2, b.p1, b.p2};
      const char* keys[] = {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"};
      for (size_t i = 0; i < std::size(keys); ++i) {
        if (std::abs(ours[i] - theirs[i]) <= 1e-9 * std::max(1.0, std::abs(ours[i]))) continue;
        problems_.push_back({folder_ / "mav0" / name / "sensor.yaml", 0,
                             fmt::format("{} is {:g}, but calibration.yaml says {:g}", keys[i], theirs[i], ours[i])});
      }
    };
    compare(calibration_->camera, other.camera, "cam0");
    if (calibration_->right && other.right) compare(*calibration_->right, *other.right, "cam1");
  }

  /// Duplicate images. Consecutive ones may be equal: a robot that stands still, without noise.
  void FindCopies() {
    std::map<uint64_t, size_t> seen;
    for (size_t i = 0; i < frames_.size(); ++i) {
      if (frames_[i].content == 0) continue;
      const auto [it, is_new] = seen.emplace(frames_[i].content, i);
      if (!is_new && i > it->second + 1) {
        problems_.push_back({Listing(ImageStream::kLeft).table, frames_[i].line,
                             fmt::format("{}: holds the very pixels of {}", frames_[i].file.string(),
                                         frames_[it->second].file.filename().string())});
      }
      it->second = i;
    }
  }

  void CheckOtherCameras(const CameraModel& camera) {
    const auto check = [&](ImageStream stream, ImageKind kind, const CameraModel& model) {
      const ImageListing listing = Listing(stream);
      report_.images += int64_t(CheckImages(listing, kind, model, by_ours_, problems_).size());
      if (by_ours_) CompareImages(listing, StampsOf(frames_), frames_name(), problems_);
    };
    if (calibration_ && calibration_->right) check(ImageStream::kRight, ImageKind::kPicture, *calibration_->right);
    const bool has_depth = calibration_ && calibration_->has_depth;
    const ImageListing depth = Listing(ImageStream::kDepth);
    if (has_depth || (!depth.names_columns() && fs::exists(depth.table)))
      check(ImageStream::kDepth, ImageKind::kDepth, camera);
    if (fs::exists(folder_ / "associations.txt")) CheckAssociations();
  }

  void CheckAssociations() {
    CheckedTable table(folder_ / "associations.txt", ' ', 4, problems_);
    const auto stamps = table.Stamps(true);
    if (by_ours_) CompareStamps(stamps, table, StampsOf(frames_), frames_name());
    if (by_ours_ && table.leading_comments() > 0)
      table.FailWhole("begins with a comment, which readers take for a frame");
    for (size_t row = 0; row < table.size(); ++row) {
      for (const size_t column : {1, 3}) {
        if (!fs::exists(folder_ / table.Text(row, column)))
          table.Fail(row, table.Text(row, column) + ": there is no such file");
      }
    }
  }

  /// @returns how many samples there are; -1 if there is no IMU.
  int64_t CheckImu() {
    const fs::path file = ImuFileOf(folder_, format_);
    if (!(calibration_ && calibration_->imu.rate_hz > 0) && !fs::exists(file)) return -1;
    CheckedTable table(file, ',', 7, problems_, format_ == DatasetFormat::kVslamlab);
    imu_stamps_ = table.Stamps(false);
    for (size_t row = 0; row < table.size(); ++row) {
      for (size_t column = 1; column < 7; ++column)
        table.Number(row, column, column < 4 ? "an angular rate" : "a specific force");
    }
    CheckRate(table);
    if (format_ == DatasetFormat::kTum && fs::exists(folder_ / "accelerometer.txt")) {
      CheckedTable forces(folder_ / "accelerometer.txt", ' ', 4, problems_);
      if (by_ours_) CheckTumHeader(forces);
      forces.Stamps(true);
      if (forces.size() != table.size())
        forces.FailWhole(fmt::format("has {} samples, imu.csv {}", forces.size(), table.size()));
    }
    return table.was_read() ? int64_t(table.size()) : -1;
  }

  void CheckRate(CheckedTable& table) {
    std::vector<int64_t> steps;
    for (size_t i = 1; i < imu_stamps_.size(); ++i) {
      if (imu_stamps_[i] && imu_stamps_[i - 1]) steps.push_back(*imu_stamps_[i] - *imu_stamps_[i - 1]);
    }
    if (steps.empty() || !calibration_ || calibration_->imu.rate_hz <= 0) return;
    const double rate_hz = 1e9 / double(std::max<int64_t>(1, UpperMedian(std::move(steps))));
    if (std::abs(rate_hz / calibration_->imu.rate_hz - 1) > 0.1)
      table.FailWhole(fmt::format("comes at {:.1f} Hz, the calibration says {:g}", rate_hz, calibration_->imu.rate_hz));
  }

  int64_t CheckJoints() {
    const fs::path file = folder_ / "joints.csv";
    if (!fs::exists(file)) return -1;
    CheckedTable table(file, ',', 3, problems_);
    table.Stamps(false);
    for (size_t row = 0; row < table.size(); ++row) {
      if (table.columns(row) != table.columns(0))
        table.Fail(row, fmt::format("has {} fields, the first row has {}", table.columns(row), table.columns(0)));
      for (size_t column = 3; column < table.columns(row); ++column) table.Number(row, column, "a joint's position");
    }
    return int64_t(table.size());
  }

  int64_t CheckOdometry() {
    const fs::path file = folder_ / "odometry.csv";
    if (!(calibration_ && calibration_->odometry.rate_hz > 0) && !fs::exists(file)) return -1;
    CheckedTable table(file, ',', 4, problems_);
    table.Stamps(false);
    for (size_t row = 0; row < table.size(); ++row) {
      for (const size_t column : {1, 2}) table.Number(row, column, "the body's position");
      table.Number(row, 3, "the body's heading");
    }
    return table.was_read() ? int64_t(table.size()) : -1;
  }

  /// How many samples there are; -1 where there is no such table.
  struct SampleCounts {
    int64_t imu, joints, odometry;
  };

  void CheckExposures(const SampleCounts& samples) {
    const fs::path file = folder_ / "exposure.csv";
    if (!by_ours_ && !fs::exists(file)) return;
    CheckedTable table(file, ',', samples.odometry < 0 ? 4 : 5, problems_);
    CompareStamps(table.Stamps(false), table, StampsOf(frames_), frames_name());
    int64_t imu = 0, joints = 0, odometry = 0;
    for (size_t row = 0; row < table.size(); ++row) {
      const auto exposure_ms = table.Number(row, 1, "the exposure in ms");
      if (exposure_ms && *exposure_ms < 0) table.Fail(row, "the exposure is negative");
      exposures_ms_.push_back(exposure_ms.value_or(0));
      const int64_t before = imu;
      imu += table.Integer(row, 2, "the number of IMU samples").value_or(0);
      joints += table.Integer(row, 3, "the number of joint samples").value_or(0);
      if (samples.odometry >= 0) odometry += table.Integer(row, 4, "the number of samples of odometry").value_or(0);
      CheckShare(table, row, before, imu, exposures_ms_.back());
    }
    const auto compare = [&](const char* what, int64_t said, int64_t there) {
      if (table.was_read() && there >= 0 && said != there)
        table.FailWhole(fmt::format("says {} {} in all, but there are {}", said, what, there));
    };
    compare("IMU samples", imu, samples.imu);
    compare("joint samples", joints, samples.joints);
    compare("samples of odometry", odometry, samples.odometry);
  }

  /// A frame's samples end when its shutter closes: at a constant time after mid-exposure, to one sample.
  void CheckShare(CheckedTable& table, size_t row, int64_t begin, int64_t end, double exposure_ms) {
    const auto stamp_ns = FrameStamp(table, row);
    if (!stamp_ns || !calibration_ || calibration_->imu.rate_hz <= 0) return;
    if (end <= begin || end > int64_t(imu_stamps_.size()) || !imu_stamps_[size_t(end - 1)] || shares_told_) return;
    const int64_t last_ns = *imu_stamps_[size_t(end - 1)];
    const double after_ms = double(last_ns - *stamp_ns) * 1e-6 - exposure_ms / 2;
    if (!after_close_ms_) after_close_ms_ = after_ms;
    if (std::abs(after_ms - *after_close_ms_) <= 1.5e3 / calibration_->imu.rate_hz) return;
    table.Fail(row, fmt::format("says {} IMU samples, the last of {} s: that is not when the shutter closes",
                                end - begin, SecondsText(last_ns)));
    shares_told_ = true;  // all later frames are affected as well
  }
  static std::optional<int64_t> FrameStamp(CheckedTable& table, size_t row) {
    int64_t ns = 0;
    return std::sscanf(table.Text(row, 0).c_str(), "%ld", &ns) == 1 ? std::optional(ns) : std::nullopt;
  }

  void CheckTimes() {
    const fs::path file = TimesFileOf(folder_, format_);
    if (!by_ours_ && !fs::exists(file)) return;
    CheckedTable table(file, ' ', 3, problems_);
    if (!table.was_read()) return;
    if (table.size() != frames_.size())
      table.FailWhole(fmt::format("has {} rows, {} has {} frames", table.size(), frames_name(), frames_.size()));
    for (size_t row = 0; row < std::min(table.size(), frames_.size()); ++row) {
      int64_t ns = 0;
      if (!ParseSeconds(table.Text(row, 1), ns) || ns != frames_[row].stamp_ns) {
        table.Fail(
            row, fmt::format("its time is {}, the frame's {}", table.Text(row, 1), SecondsText(frames_[row].stamp_ns)));
        return;  // the rows below are affected as well
      }
      const auto exposure_ms = table.Number(row, 2, "the exposure in ms");
      if (exposure_ms && row < exposures_ms_.size() && *exposure_ms != exposures_ms_[row])
        table.Fail(row, fmt::format("the exposure is {:g} ms, in exposure.csv {:g}", *exposure_ms, exposures_ms_[row]));
    }
  }

  /// Names made of stamps must have one length, whatever the walk's.
  void CheckEpoch() {
    constexpr int64_t kTenDigits_ns = 1'000'000'000'000'000'000;
    if (frames_.empty() || frames_.front().stamp_ns >= kTenDigits_ns) return;
    problems_.push_back({Listing(ImageStream::kLeft).table, frames_.front().line,
                         fmt::format("the clock begins at {} s; expected an epoch of ten digits of seconds, so that "
                                     "names of images sort by time",
                                     SecondsText(frames_.front().stamp_ns))});
  }

  const fs::path folder_;
  const DatasetFormat format_;
  const bool by_ours_;  ///< Recorded by gaitcam, which guarantees more than the layout asks for.
  SequenceReport& report_;
  Problems& problems_;
  std::optional<Calibration> calibration_;
  std::vector<CheckedImage> frames_;
  std::vector<std::optional<int64_t>> imu_stamps_;
  std::vector<double> exposures_ms_;
  std::optional<double> after_close_ms_;  ///< The first frame's last IMU sample; with a rolling shutter some ms.
  bool shares_told_ = false;
};

}  // namespace

SequenceReport CheckSequence(const DatasetFolders& folders) {
  SequenceReport report;
  SensorCheck sensors(folders.sensors, report);
  sensors.Run();
  report.with_truth = fs::is_directory(folders.truth);
  if (!report.with_truth) return report;
  std::optional<Calibration> right = sensors.calibration();
  const fs::path file = TrueCalibrationFileOf(folders);
  try {
    if (fs::exists(file)) right = ReadCalibration(file);
  } catch (const BadInput& e) {
    report.problems.push_back(ProblemOf(e, file));
  }
  CheckTruth(folders, sensors.frames(), right, report);
  return report;
}

}  // namespace gaitcam
