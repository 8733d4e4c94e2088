#include "algorithms/io/dataset_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <opencv2/core.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/io/calibration_file.h"
#include "algorithms/io/image_file.h"
#include "algorithms/io/program_settings.h"
#include "algorithms/io/text_table.h"
#include "algorithms/io/trajectory_file.h"
#include "algorithms/io/whole_file.h"
#include "algorithms/io/writer_pool.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

std::string Csv(const Pose& X) {
  const Eigen::Vector3d& t = X.translation;
  const Eigen::Quaterniond& q = X.rotation;
  std::string text;
  for (const double number : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) text += ',' + ExactText(number);
  return text;
}

std::string CsvOrEmpty(const std::optional<Pose>& X) { return X ? Csv(*X) : std::string(7, ','); }

std::string PoseColumns(const std::string& of) {
  std::string text;
  for (const char* name : {"x", "y", "z", "qx", "qy", "qz", "qw"}) text += "," + of + "_" + name;
  return text;
}

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw MissingResource(folder.string() + ": cannot make this folder: " + error.message());
}

void WriteText(const fs::path& file, const std::string& text) {
  MakeFolder(file.parent_path());
  WriteWholeFile(file, text);
}

/// A folder that gets its name when it is whole; until then it has one of this process's own, and is removed if
/// abandoned.
class PendingFolder {
 public:
  explicit PendingFolder(fs::path wanted) : wanted_(std::move(wanted)), path_(UnfinishedNameFor(wanted_)) {
    if (fs::exists(wanted_)) throw BadInput(wanted_.string() + ": exists already; remove it or choose another name");
    RemoveAbandoned(wanted_);
    MakeFolder(path_);
  }
  ~PendingFolder() {
    std::error_code ignored;
    if (!kept_) fs::remove_all(named_ ? wanted_ : path_, ignored);
  }
  PendingFolder(const PendingFolder&) = delete;
  PendingFolder& operator=(const PendingFolder&) = delete;

  const fs::path& path() const { return path_; }
  const fs::path& wanted() const { return wanted_; }
  void Name() {
    std::error_code error;
    fs::rename(path_, wanted_, error);
    if (error == std::errc::directory_not_empty || error == std::errc::file_exists) {
      throw BadInput(wanted_.string() + ": another process has made it meanwhile; remove it or choose another name");
    }
    if (error) throw MissingResource(wanted_.string() + ": cannot name this folder: " + error.message());
    named_ = true;
  }
  /// Until then it is removed again: a folder that belongs to it may not get its own name.
  void Keep() { kept_ = true; }

 private:
  fs::path wanted_, path_;
  bool named_ = false, kept_ = false;
};

/// A table that grows by rows.
class RowFile {
 public:
  /// @param header without its last line end; nothing: the table begins with its first row.
  explicit RowFile(fs::path file, const std::optional<std::string>& header = {}) : file_(std::move(file)) {
    MakeFolder(file_.parent_path());
    stream_.open(file_, std::ios::binary);
    if (!stream_) throw MissingResource(file_.string() + ": cannot write this file");
    if (header) Row(*header);
  }
  void Row(const std::string& row) {
    stream_ << row << '\n';
    if (!stream_) throw MissingResource(file_.string() + ": cannot write this file");
  }
  void Close() {
    stream_.close();
    if (!stream_) throw MissingResource(file_.string() + ": cannot write this file");
  }

 private:
  fs::path file_;
  std::ofstream stream_;
};

/// The three lines of comment that begin TUM's tables; its readers skip so many.
std::string TumHeader(const std::string& what, const std::string& columns) {
  return "# " + what + "\n# times in s, by the clock of all sensors; an image's is the middle of its exposure\n# " +
         columns;
}

const char* const kPoseColumns = "timestamp tx ty tz qx qy qz qw";
const char* const kPoseNote = "poses X_WC of the left camera";
const char* const kVslamlabPoseHeader = "ts (ns),tx (m),ty (m),tz (m),qx,qy,qz,qw";

/// A folder of images and, unless the layout lists all streams in one, the table of them.
class ImageFiles {
 public:
  ImageFiles(const ImageListing& listing, const std::string& what) : listing_(listing) {
    MakeFolder(listing.folder);
    if (listing.names_columns()) return;
    table_.emplace(listing.table, listing.in_seconds ? TumHeader(what, "timestamp filename")
                                                     : std::string("#timestamp [ns],filename"));
  }

  /// Lists an image and @returns where to write it.
  fs::path Add(int64_t stamp_ns) {
    if (table_) table_->Row(Entry(stamp_ns));
    return listing_.folder / listing_.FileName(stamp_ns);
  }
  /// Its stamp and file, as tables say them.
  std::string Entry(int64_t stamp_ns) const {
    const std::string stamp = listing_.in_seconds ? SecondsText(stamp_ns) : std::to_string(stamp_ns);
    const fs::path file = (listing_.folder / listing_.FileName(stamp_ns)).lexically_relative(listing_.base);
    return stamp + listing_.separator + file.string();
  }
  /// The names of the two columns, where all streams are in one table.
  std::string Columns() const { return listing_.stamp_column + listing_.separator + listing_.file_column; }
  void Close() {
    if (table_) table_->Close();
  }

 private:
  ImageListing listing_;
  std::optional<RowFile> table_;
};

bool TooFarForPng(const cv::Mat& depth) {
  double farthest = 0;
  cv::minMaxLoc(depth, nullptr, &farthest);
  return farthest > std::numeric_limits<uint16_t>::max() / kDepthUnitsPerMetre;
}

/// The images of one recording on their way to the disk.
class ImageJobs {
 public:
  explicit ImageJobs(const DatasetWriterOptions& options)
      : level_(options.png_compression), pool_(std::clamp(options.threads, 0, 64)) {}

  void Png(const fs::path& file, const cv::Mat& image) {
    pool_.Do([=, level = level_] { WritePng(file, image, level); });
  }
  void Vectors(const fs::path& file, const cv::Mat& vectors) {
    pool_.Do([=, level = level_] { WriteVectorsPng(file, vectors, level); });
  }
  /// Without a lossless twin.
  void PlainDepth(const fs::path& file, const cv::Mat& depth) {
    pool_.Do([=, level = level_] { WriteDepthPng(file, depth, level); });
  }
  void Depth(const fs::path& root, const fs::path& file, int64_t stamp_ns, const cv::Mat& depth, bool measured) {
    pool_.Do([=, level = level_] {
      const bool exact = WriteDepthPng(file, depth, level);
      if (measured ? exact : !TooFarForPng(depth)) return;
      MakeFolder(root / "depth_exact");
      WriteDepthTiff(root / "depth_exact" / (std::to_string(stamp_ns) + ".tiff"), depth);
    });
  }
  void Finish() { pool_.Finish(); }

 private:
  int level_;
  WriterPool pool_;
};

const char* const kSensorsText =
    "What a walking robot's sensors recorded ({}). The truth lies beside this folder{}.\n"
    "Stamps are nanoseconds on one clock, which counts from an epoch. An image's stamp is the middle of its exposure;\n"
    "{} and exposure.csv give the exposure in ms. Camera frame: x right, y down, z forward; pixel (0, 0) is the\n"
    "centre of the first pixel, row 0 the top. {} holds intrinsics, extrinsics and IMU noise. IMU readings\n"
    "are in the IMU's own frame. Depth PNGs: metres times 5000, 0 where nothing was measured.\n"
    "Frames: {}. Recording: {}.\n\n";

const char* const kTruthText =
    "What is true of the recording beside this folder; keep it from what is being evaluated.\n"
    "X_AB maps points of B into A. World W: x forward, y left, z up. C: left camera (x right, y down, z forward).\n"
    "groundtruth.txt: X_WC at mid-exposure. frames.csv: X_WC at shutter open and close, blur over the image (path\n"
    "lengths, px), gait phase, foot contacts, X_WB of the robot's root. subposes.csv: the instants that were "
    "averaged.\n"
    "sharp/: one instant at mid-exposure without noise. depth/: metres times 5000. blur/: how far the point seen at a\n"
    "pixel moved while the shutter was open: (red - 32768) / 64 px to the right, (green - 32768) / 64 px down, known "
    "where\n"
    "blue is 1. mav0/ (if there): pose of the body, which is the IMU, or the left camera if there is no IMU.\n"
    "groundtruth.csv (if there): the poses of groundtruth.txt as VSLAM-LAB has them.\n"
    "Frames: {}. Recording: {}.\n";

/// In the truth's folder, with the name of the process behind it, until the sensors' folder has its name.
const std::string kHalfNamed = ".half-named-";

/// What a process left that was killed between the two names.
const DatasetFolders& WithoutHalfNamed(const DatasetFolders& folders) {
  if (!HoldsAbandoned(folders.truth, kHalfNamed)) return folders;
  std::error_code ignored;
  fs::remove_all(folders.sensors, ignored);
  fs::remove_all(folders.truth, ignored);
  return folders;
}

/// The part that no SLAM system is given.
class TruthFiles {
 public:
  TruthFiles(const fs::path& folder, const fs::path& sensors, const Calibration& calibration,
             const DatasetWriterOptions& options)
      : calibration_(calibration),
        options_(options),
        folder_(folder),
        frames_(folder_.path() / "frames.csv",
                "#stamp_ns" + PoseColumns("X_WC_open") + PoseColumns("X_WC_close") +
                    ",blur_median_px,blur_p90_px,blur_max_px,step,step_phase,left_contact,right_contact" +
                    PoseColumns("X_WB")),
        subposes_(folder_.path() / "subposes.csv", "#frame_stamp_ns,stamp_ns,weight" + PoseColumns("X_WC")) {
    AddPoses(folder_.path());
    if (options.format != DatasetFormat::kTum) AddLayoutsOwn(folder_.path());
    if (options.truth_inside) AddLayoutsOwn(sensors);
  }

  void Add(int64_t stamp_ns, const FilmedTruth& truth, ImageJobs& jobs) {
    for (RowFile& file : poses_) file.Row(TrajectoryRow({stamp_ns, truth.X_WC}, TrajectoryFormat::kTum));
    const Pose X_WI = truth.X_WI ? *truth.X_WI : truth.X_WC * calibration_.imu.X_CI;
    const Pose body = calibration_.imu.rate_hz > 0 ? X_WI : truth.X_WC;
    for (RowFile& file : states_) file.Row(TrajectoryRow({stamp_ns, body}, TrajectoryFormat::kEuroc));
    for (RowFile& file : rows_) file.Row(std::to_string(stamp_ns) + Csv(truth.X_WC));
    const GaitState gait = truth.gait.value_or(GaitState());
    frames_.Row(std::to_string(stamp_ns) + Csv(truth.X_WC_open) + Csv(truth.X_WC_close) +
                fmt::format(",{},{},{},{},{},{},{}", truth.blur_median_px, truth.blur_p90_px, truth.blur_max_px,
                            gait.step, gait.phase, int(truth.left_contact), int(truth.right_contact)) +
                CsvOrEmpty(truth.X_WB));
    for (const auto& sub : truth.subframes) {
      subposes_.Row(fmt::format("{},{},{}", stamp_ns, sub.stamp_ns, sub.weight) + Csv(sub.X_WC));
    }
    AddImages(stamp_ns, truth, jobs);
  }

  void Finish(int64_t frames, const std::string& ending) {
    for (auto* files : {&poses_, &states_, &rows_}) {
      for (RowFile& file : *files) file.Close();
    }
    frames_.Close();
    subposes_.Close();
    for (auto* files : {&sharp_, &depth_, &blur_}) {
      if (*files) (*files)->Close();
    }
    WriteText(folder_.path() / "about.txt", fmt::format(fmt::runtime(kTruthText), frames, ending));
    WriteText(folder_.path() / (kHalfNamed + NameOfProcess()), "");
    folder_.Name();
  }
  void AddText(const std::string& name, const std::string& text) const { WriteText(folder_.path() / name, text); }
  /// The sensors' folder has its name, too.
  void Keep() {
    std::error_code ignored;
    fs::remove(folder_.wanted() / (kHalfNamed + NameOfProcess()), ignored);
    folder_.Keep();
  }

 private:
  /// The table in which the layout keeps its truth.
  void AddLayoutsOwn(const fs::path& root) {
    switch (options_.format) {
      case DatasetFormat::kTum: return AddPoses(root);
      case DatasetFormat::kEuroc: return AddStates(root);
      case DatasetFormat::kVslamlab: rows_.emplace_back(root / "groundtruth.csv", kVslamlabPoseHeader);
    }
  }

  void AddPoses(const fs::path& root) {
    poses_.emplace_back(root / "groundtruth.txt", TumHeader(kPoseNote, kPoseColumns));
  }

  void AddStates(const fs::path& root) {
    const fs::path folder = root / "mav0" / "state_groundtruth_estimate0";
    states_.emplace_back(
        folder / "data.csv",
        "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []");
    WriteText(folder / "sensor.yaml", EurocTruthText());
  }

  void AddImages(int64_t stamp_ns, const FilmedTruth& truth, ImageJobs& jobs) {
    const auto files = [&](std::optional<ImageFiles>& of, const char* name, const char* what) -> ImageFiles& {
      if (!of) of.emplace(TumListing(folder_.path(), name), what);
      return *of;
    };
    if (!truth.sharp.empty()) jobs.Png(files(sharp_, "sharp", "sharp twins").Add(stamp_ns), truth.sharp);
    if (!truth.blur.empty()) jobs.Vectors(files(blur_, "blur", "blur vectors").Add(stamp_ns), truth.blur);
    if (!truth.depth.empty()) {
      const fs::path file = files(depth_, "depth", "true depth images").Add(stamp_ns);
      jobs.Depth(folder_.path(), file, stamp_ns, truth.depth, false);
    }
  }

  Calibration calibration_;
  DatasetWriterOptions options_;
  PendingFolder folder_;
  std::vector<RowFile> poses_, states_, rows_;  ///< TUM's, EuRoC's, VSLAM-LAB's.
  RowFile frames_, subposes_;
  std::optional<ImageFiles> sharp_, depth_, blur_;
};

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
      jobs_(options) {
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
  if (!truth_) truth_.emplace(folders_.truth, folder_.path(), calibration_, options_);
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
