#include "algorithms/io/dataset_writer.h"

#include <fmt/format.h>

#include <opencv2/core.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/io/calibration_file.h"
#include "algorithms/io/dataset_files.h"
#include "algorithms/io/program_settings.h"
#include "algorithms/io/text_table.h"
#include "algorithms/io/truth_files.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

const char* const kSensorsText =
    "What a walking robot's sensors recorded ({}). The truth lies beside this folder{}.\n"
    "Stamps are nanoseconds on one clock, which counts from an epoch. An image's stamp is the middle of its exposure;\n"
    "{} and exposure.csv give the exposure in ms. Camera frame: x right, y down, z forward; pixel (0, 0) is the\n"
    "centre of the first pixel, row 0 the top. {} holds intrinsics, extrinsics and IMU noise. IMU readings\n"
    "are in the IMU's own frame. Depth PNGs: metres times 5000, 0 where nothing was measured.\n"
    "Frames: {}. Recording: {}.\n\n";

}  // namespace

class DatasetWriter::Files {
 public:
  Files(const DatasetFolders& folders, const Calibration& calibration, const DatasetWriterOptions& options);
  void Add(const Observation& observation, const std::optional<FilmedTruth>& truth);
  void Finish(const std::string& ending);
  int64_t frames() const { return frames_; }

  /// Made when it is first needed.
  TruthFiles& Truth();

 private:
  void CheckOptions() const;
  void Check(const Observation& observation) const;
  void WriteCalibrations() const;
  void OpenImu();
  void AddImages(const Observation& observation);
  void AddTrueDepth(const FilmedTruth& truth, int64_t stamp_ns);
  void AddSamples(const Observation& observation);
  std::string About(const std::string& ending) const;

  bool tum() const { return options_.format == DatasetFormat::kTum; }
  bool euroc() const { return options_.format == DatasetFormat::kEuroc; }
  bool vslamlab() const { return options_.format == DatasetFormat::kVslamlab; }
  ImageListing Listing(ImageStream stream) const { return ListingOf(folder_.path(), options_.format, stream); }

  DatasetFolders folders_;
  Calibration calibration_;
  DatasetWriterOptions options_;
  PendingFolder folder_;
  ImageFiles left_;
  std::optional<ImageFiles> right_, depth_;
  RowFile times_, exposures_;
  std::optional<RowFile> streams_, associations_, stamps_, imu_, accelerometer_, joints_, odometry_;
  std::optional<TruthFiles> truth_;
  bool grey_ = false;
  int64_t frames_ = 0, last_stamp_ns_ = 0;
  ImageJobs jobs_;  // last: its threads end before the folders go
};

DatasetWriter::Files::Files(const DatasetFolders& folders, const Calibration& calibration,
                            const DatasetWriterOptions& options)
    : folders_(folders),
      calibration_(calibration),
      options_(options),
      folder_(folders.sensors),
      left_(Listing(ImageStream::kLeft), "images"),
      times_(TimesFileOf(folder_.path(), options.format)),
      exposures_(folder_.path() / "exposure.csv", std::string("#stamp_ns,exposure_ms,imu_samples,joint_samples") +
                                                      (calibration.odometry.rate_hz > 0 ? ",odometry_samples" : "")),
      jobs_(options.png_compression, options.threads) {
  CheckOptions();
  WriteCalibrations();
  if (calibration.right) right_.emplace(Listing(ImageStream::kRight), "images of the right camera");
  if (calibration.has_depth) depth_.emplace(Listing(ImageStream::kDepth), "depth images");
  if (tum() && depth_) associations_.emplace(folder_.path() / "associations.txt");
  if (euroc()) stamps_.emplace(StampListOf(folder_.path()));
  if (vslamlab()) {
    std::string columns = left_.Columns();
    if (right_) columns += "," + right_->Columns();
    if (depth_) columns += "," + depth_->Columns();
    streams_.emplace(Listing(ImageStream::kLeft).table, columns);
  }
  if (calibration.imu.rate_hz > 0) OpenImu();
  if (calibration.odometry.rate_hz > 0) {
    odometry_.emplace(folder_.path() / "odometry.csv",
                      "# the body as its wheels or legs reckon it, where it stood at first: m, m, rad (not wrapped)\n"
                      "#stamp_ns,x_m,y_m,heading_rad");
  }
}

TruthFiles& DatasetWriter::Files::Truth() {
  if (!truth_) {
    std::optional<fs::path> inside;
    if (options_.truth_inside) inside = folder_.path();
    truth_.emplace(folders_.truth, options_.format, calibration_, inside);
  }
  return *truth_;
}

void DatasetWriter::Files::CheckOptions() const {
  if (options_.png_compression < 0 || options_.png_compression > 9) {
    throw BadOption("png_compression: " + std::to_string(options_.png_compression) +
                    " is not permitted; expected 0 to 9");
  }
  if (options_.threads < 0 || options_.threads > 64) {
    throw BadOption("threads: " + std::to_string(options_.threads) + " is not permitted; expected 0 to 64");
  }
  if (fs::exists(folders_.truth)) {
    throw BadInput(folders_.truth.string() + ": exists already; remove it or choose another name");
  }
}

/// Ours, the layout's, other programs'. VSLAM-LAB's waits for the first image, which tells its colours.
void DatasetWriter::Files::WriteCalibrations() const {
  WriteText(CalibrationFileOf(folder_.path(), options_.format), CalibrationText(calibration_));
  for (const ProgramSettings& settings : SettingsOf(calibration_, options_.format)) {
    WriteText(folder_.path() / settings.file, settings.text);
  }
  if (!euroc()) return;
  const fs::path mav0 = folder_.path() / "mav0";
  WriteText(mav0 / "cam0" / "sensor.yaml", EurocCameraText(calibration_, false));
  if (calibration_.right) WriteText(mav0 / "cam1" / "sensor.yaml", EurocCameraText(calibration_, true));
  if (calibration_.imu.rate_hz > 0) WriteText(mav0 / "imu0" / "sensor.yaml", EurocImuText(calibration_));
}

void DatasetWriter::Files::OpenImu() {
  const char* const header =
      vslamlab() ? "ts (ns),wx (rad s^-1),wy (rad s^-1),wz (rad s^-1),ax (m s^-2),ay (m s^-2),az (m s^-2)"
                 : "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],"
                   "a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]";
  imu_.emplace(ImuFileOf(folder_.path(), options_.format), header);
  if (tum()) {
    accelerometer_.emplace(folder_.path() / "accelerometer.txt",
                           TumHeader("specific forces in the IMU's frame, m/s^2", "timestamp ax ay az"));
  }
}

void DatasetWriter::Files::Check(const Observation& o) const {
  const std::string where = "frame at " + SecondsText(o.stamp_ns) + " s: ";
  if (frames_ > 0 && o.stamp_ns <= last_stamp_ns_) throw BadInput(where + "its stamp does not increase");
  const auto check_size = [&](const cv::Mat& image, const CameraModel& camera, const char* what) {
    if (image.cols == camera.width_px && image.rows == camera.height_px) return;
    throw BadInput(where + fmt::format("the {} has {} x {} pixels, but the calibration says {} x {}", what, image.cols,
                                       image.rows, camera.width_px, camera.height_px));
  };
  check_size(o.image.pixels, calibration_.camera, "image");
  if (calibration_.right.has_value() != o.right.has_value() || calibration_.has_depth != o.depth.has_value()) {
    throw BadInput(where + "has not just the images that the calibration says");
  }
  if (o.right) check_size(o.right->pixels, *calibration_.right, "right image");
  if (o.depth) check_size(o.depth->pixels, calibration_.camera, "depth image");
  if (!imu_ && !o.imu.empty()) throw BadInput(where + "has IMU samples, but the calibration says that there is no IMU");
  if (!odometry_ && !o.odometry.empty())
    throw BadInput(where + "has samples of odometry, but the calibration says that there is none");
}

void DatasetWriter::Files::AddImages(const Observation& o) {
  jobs_.Png(left_.Add(o.stamp_ns), o.image.pixels);
  if (o.right) jobs_.Png(right_->Add(o.right->stamp_ns), o.right->pixels);
  if (o.depth) {
    jobs_.Depth(folder_.path(), depth_->Add(o.depth->stamp_ns), o.depth->stamp_ns, o.depth->pixels, true);
    if (associations_) associations_->Row(left_.Entry(o.stamp_ns) + " " + depth_->Entry(o.depth->stamp_ns));
  }
  if (stamps_) stamps_->Row(std::to_string(o.stamp_ns));
  if (!streams_) return;
  std::string row = left_.Entry(o.stamp_ns);
  if (o.right) row += "," + right_->Entry(o.right->stamp_ns);
  if (o.depth) row += "," + depth_->Entry(o.depth->stamp_ns);
  streams_->Row(row);
}

/// True depth in place of a sensor's, for tools that want an RGB-D folder whole.
void DatasetWriter::Files::AddTrueDepth(const FilmedTruth& truth, int64_t stamp_ns) {
  if (!options_.truth_inside || !tum() || calibration_.has_depth || truth.depth.empty()) return;
  if (!depth_) {
    depth_.emplace(Listing(ImageStream::kDepth), "true depth images");
    associations_.emplace(folder_.path() / "associations.txt");
  }
  jobs_.PlainDepth(depth_->Add(stamp_ns), truth.depth);
  associations_->Row(left_.Entry(stamp_ns) + " " + depth_->Entry(stamp_ns));
}

void DatasetWriter::Files::AddSamples(const Observation& o) {
  for (const ImuSample& sample : o.imu) {
    std::string row = std::to_string(sample.stamp_ns), force = SecondsText(sample.stamp_ns);
    for (int i = 0; i < 3; ++i) row += "," + ExactText(sample.angular_rate[i]);
    for (int i = 0; i < 3; ++i) {
      row += "," + ExactText(sample.specific_force[i]);
      force += " " + ExactText(sample.specific_force[i]);
    }
    imu_->Row(row);
    if (accelerometer_) accelerometer_->Row(force);
  }
  for (const JointSample& sample : o.joints) {
    if (!joints_) {
      std::string header = "#stamp_ns,left_contact,right_contact";
      for (size_t i = 0; i < sample.position.size(); ++i) header += ",joint_" + std::to_string(i);
      joints_.emplace(folder_.path() / "joints.csv", header);
    }
    std::string row = fmt::format("{},{},{}", sample.stamp_ns, int(sample.left_contact), int(sample.right_contact));
    for (const double position : sample.position) row += "," + ExactText(position);
    joints_->Row(row);
  }
  for (const OdometrySample& sample : o.odometry) {
    std::string row = std::to_string(sample.stamp_ns);
    const Eigen::Vector2d& p = sample.position;
    for (const double number : {p.x(), p.y(), sample.heading}) row += "," + ExactText(number);
    odometry_->Row(row);
  }
}

void DatasetWriter::Files::Add(const Observation& o, const std::optional<FilmedTruth>& truth) {
  Check(o);
  if (frames_ == 0) grey_ = o.image.pixels.channels() == 1;
  AddImages(o);
  AddSamples(o);
  times_.Row(fmt::format("{:05d} {} {}", frames_, SecondsText(o.stamp_ns), ExactText(o.exposure_ms)));
  exposures_.Row(fmt::format("{},{},{},{}", o.stamp_ns, ExactText(o.exposure_ms), o.imu.size(), o.joints.size()) +
                 (odometry_ ? fmt::format(",{}", o.odometry.size()) : ""));
  if (truth) {
    Truth().Add(o.stamp_ns, *truth, jobs_);
    AddTrueDepth(*truth, o.stamp_ns);
  }
  last_stamp_ns_ = o.stamp_ns;
  ++frames_;
}

void DatasetWriter::Files::Finish(const std::string& ending) {
  jobs_.Finish();
  for (auto* files : {&right_, &depth_}) {
    if (*files) (*files)->Close();
  }
  for (auto* file : {&streams_, &associations_, &stamps_, &imu_, &accelerometer_, &joints_, &odometry_}) {
    if (*file) (*file)->Close();
  }
  left_.Close();
  times_.Close();
  exposures_.Close();
  if (vslamlab()) {
    WriteText(folder_.path() / "calibration.yaml", VslamlabCalibrationText(calibration_, grey_));
  }
  WriteText(folder_.path() / "about.txt", About(ending));
  if (truth_) truth_->Finish(frames_, ending);
  folder_.Name();
  if (truth_) truth_->Keep();
  folder_.Keep();
}

std::string DatasetWriter::Files::About(const std::string& ending) const {
  const auto name = [&](const fs::path& file) { return file.lexically_relative(folder_.path()).string(); };
  return fmt::format(fmt::runtime(kSensorsText), NameOfLayout(options_.format),
                     options_.truth_inside ? ", and in part in it, as was asked for" : "",
                     name(TimesFileOf(folder_.path(), options_.format)),
                     name(CalibrationFileOf(folder_.path(), options_.format)), frames_, ending) +
         SettingsGuide(calibration_, options_.format);
}

DatasetWriter::DatasetWriter(const DatasetFolders& folders, const Calibration& calibration,
                             const DatasetWriterOptions& options)
    : files_(std::make_unique<Files>(WithoutHalfNamed(folders), calibration, options)) {}

DatasetWriter::~DatasetWriter() = default;

void DatasetWriter::Add(const Observation& observation, const std::optional<FilmedTruth>& truth) {
  files_->Add(observation, truth);
}

void DatasetWriter::AddToTruth(const std::string& name, const std::string& text) {
  files_->Truth().AddText(name, text);
}

void DatasetWriter::Finish(const std::string& ending) { files_->Finish(ending); }

int64_t DatasetWriter::frames() const { return files_->frames(); }

}  // namespace gaitcam
