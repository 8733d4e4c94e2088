#include "algorithms/io/dataset_reader.h"

#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/io/calibration_file.h"
#include "algorithms/io/image_file.h"
#include "algorithms/io/image_table.h"
#include "algorithms/io/text_table.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

/// The images of another camera, to be found by stamps that increase.
class NearestImage {
 public:
  explicit NearestImage(const ImageListing& listing) : table_(listing) { next_ = table_.Next(); }

  /// The row whose stamp is nearest, if near enough.
  std::optional<ListedImage> At(int64_t stamp_ns, int64_t tolerance_ns) {
    const auto distance = [&](const ListedImage& image) { return std::abs(image.stamp_ns - stamp_ns); };
    while (next_ && (!current_ || distance(*next_) <= distance(*current_))) {
      current_ = std::move(next_);
      next_ = table_.Next();
    }
    return current_ && distance(*current_) <= tolerance_ns ? current_ : std::nullopt;
  }

 private:
  ImageTable table_;
  std::optional<ListedImage> current_, next_;
};

ImuSample ParseImu(const TextTable& table) {
  ImuSample sample;
  sample.stamp_ns = table.Integer(0, "the time in nanoseconds");
  for (size_t i = 0; i < 3; ++i) {
    sample.angular_rate[long(i)] = table.Number(1 + i, "an angular rate in rad/s");
    sample.specific_force[long(i)] = table.Number(4 + i, "a specific force in m/s^2");
  }
  return sample;
}

JointSample ParseJoints(const TextTable& table) {
  JointSample sample;
  sample.stamp_ns = table.Integer(0, "the time in nanoseconds");
  sample.left_contact = table.Integer(1, "the left foot's contact, 0 or 1") != 0;
  sample.right_contact = table.Integer(2, "the right foot's contact, 0 or 1") != 0;
  for (size_t i = 3; i < table.size(); ++i) sample.position.push_back(table.Number(i, "a joint's position"));
  return sample;
}

OdometrySample ParseOdometry(const TextTable& table) {
  if (table.size() != 4) {
    table.Fail("has " + std::to_string(table.size()) +
               " fields; expected stamp_ns, x in m, y in m and heading in rad, separated by commas");
  }
  OdometrySample sample;
  sample.stamp_ns = table.Integer(0, "the time in nanoseconds");
  sample.position = {table.Number(1, "the body's x in m"), table.Number(2, "the body's y in m")};
  sample.heading = table.Number(3, "the body's heading in rad");
  return sample;
}

/// Samples from a table, handed out as frames come.
template <class Sample>
class SampleTable {
 public:
  using Parser = Sample (*)(const TextTable&);
  /// @param names_columns the table's first row names its columns.
  SampleTable(const fs::path& file, Parser parse, bool names_columns = false) : table_(file, ','), parse_(parse) {
    if (names_columns) table_.Next();
    Advance();
  }

  std::vector<Sample> TakeUntil(int64_t stamp_ns) {
    std::vector<Sample> taken;
    for (; next_ && next_->stamp_ns <= stamp_ns; Advance()) taken.push_back(*next_);
    return taken;
  }

  std::vector<Sample> Take(int64_t count) {
    std::vector<Sample> taken;
    for (int64_t i = 0; i < count; ++i, Advance()) {
      if (!next_) table_.Fail("the table ends; exposure.csv says that there are more samples");
      taken.push_back(*next_);
    }
    return taken;
  }

 private:
  void Advance() {
    if (!table_.Next()) {
      next_.reset();
      return;
    }
    const Sample sample = parse_(table_);
    if (next_ && sample.stamp_ns <= next_->stamp_ns) table_.Fail("its time does not come after the row before it");
    next_ = sample;
  }

  TextTable table_;
  Parser parse_;
  std::optional<Sample> next_;
};

int64_t CountRows(const ImageListing& listing) {
  ImageTable table(listing);
  int64_t rows = 0;
  while (table.Next()) ++rows;
  return rows;
}

}  // namespace

class DatasetReader::Source {
 public:
  Source(const fs::path& folder, const DatasetReaderOptions& options);
  std::optional<Observation> Next();

  const DatasetFormat format_;
  Calibration calibration_;
  int64_t frames_ = 0;

 private:
  ImageListing Listing(ImageStream stream) const { return ListingOf(folder_, format_, stream); }
  Calibration FindCalibration(const fs::path& given) const;
  void OpenOthers();
  cv::Mat ReadPixels(const ListedImage& listed, const CameraModel& camera) const;
  Image ReadDepth(const ListedImage& listed) const;
  void AddSamples(Observation& observation);

  fs::path folder_;
  int64_t tolerance_ns_;
  ImageTable left_;
  std::optional<NearestImage> right_, depth_;
  std::optional<TextTable> exposures_;
  std::optional<SampleTable<ImuSample>> imu_;
  std::optional<SampleTable<JointSample>> joints_;
  std::optional<SampleTable<OdometrySample>> odometry_;
};

DatasetReader::Source::Source(const fs::path& folder, const DatasetReaderOptions& options)
    : format_(FormatOfDataset(folder)),
      folder_(folder),
      tolerance_ns_(int64_t(std::llround(options.max_stamp_difference_s * 1e9))),
      left_(Listing(ImageStream::kLeft)) {
  calibration_ = FindCalibration(options.calibration);
  frames_ = CountRows(Listing(ImageStream::kLeft));
  if (frames_ == 0) throw BadInput(folder.string() + ": lists no image");
  OpenOthers();
}

Calibration DatasetReader::Source::FindCalibration(const fs::path& given) const {
  const fs::path ours = CalibrationFileOf(folder_, format_);
  if (!given.empty()) return ReadCalibration(given);
  if (fs::exists(ours)) return ReadCalibration(ours);
  switch (format_) {
    case DatasetFormat::kTum: break;
    case DatasetFormat::kEuroc: return ReadEurocCalibration(folder_ / "mav0");
    case DatasetFormat::kVslamlab: return ReadVslamlabCalibration(folder_ / "calibration.yaml");
  }
  throw BadInput(ours.string() + ": there is no such file; a TUM folder does not say its intrinsics otherwise");
}

void DatasetReader::Source::OpenOthers() {
  if (calibration_.right) right_.emplace(Listing(ImageStream::kRight));
  if (calibration_.has_depth) depth_.emplace(Listing(ImageStream::kDepth));
  if (fs::exists(folder_ / "exposure.csv")) exposures_.emplace(folder_ / "exposure.csv", ',');
  const fs::path imu = ImuFileOf(folder_, format_);
  if (calibration_.imu.rate_hz > 0 && fs::exists(imu))
    imu_.emplace(imu, &ParseImu, format_ == DatasetFormat::kVslamlab);
  if (fs::exists(folder_ / "joints.csv")) joints_.emplace(folder_ / "joints.csv", &ParseJoints);
  const fs::path odometry = folder_ / "odometry.csv";
  if (calibration_.odometry.rate_hz > 0 && fs::exists(odometry)) odometry_.emplace(odometry, &ParseOdometry);
}

cv::Mat DatasetReader::Source::ReadPixels(const ListedImage& listed, const CameraModel& camera) const {
  cv::Mat pixels = ReadImage(listed.file, listed.listed_at);
  if (pixels.cols != camera.width_px || pixels.rows != camera.height_px) {
    throw BadInput(listed.file.string() + ": has " + std::to_string(pixels.cols) + " x " + std::to_string(pixels.rows) +
                   " pixels, but the calibration says " + std::to_string(camera.width_px) + " x " +
                   std::to_string(camera.height_px) + " (listed at " + listed.listed_at + ")");
  }
  return pixels;
}

Image DatasetReader::Source::ReadDepth(const ListedImage& listed) const {
  const fs::path exact = folder_ / "depth_exact" / (std::to_string(listed.stamp_ns) + ".tiff");
  if (fs::exists(exact)) return {listed.stamp_ns, ReadDepthTiff(exact, listed.listed_at)};
  return {listed.stamp_ns, ReadDepthPng(listed.file, listed.listed_at)};
}

/// By the counts that we recorded, otherwise by the shutter's close.
void DatasetReader::Source::AddSamples(Observation& observation) {
  if (!exposures_) {
    if (imu_) observation.imu = imu_->TakeUntil(observation.stamp_ns);
    if (odometry_) observation.odometry = odometry_->TakeUntil(observation.stamp_ns);
    return;
  }
  if (!exposures_->Next()) exposures_->Fail("the table ends; there are more images");
  if (exposures_->Integer(0, "the time in nanoseconds") != observation.stamp_ns) {
    exposures_->Fail("its time is not that of the image, " + std::to_string(observation.stamp_ns) + " ns");
  }
  observation.exposure_ms = exposures_->Number(1, "the exposure in ms");
  const int64_t imu_samples = exposures_->Integer(2, "the number of IMU samples");
  const int64_t joint_samples = exposures_->Integer(3, "the number of joint samples");
  if (imu_samples > 0 && !imu_) exposures_->Fail("says IMU samples, but there are none");
  if (joint_samples > 0 && !joints_) exposures_->Fail("says joint samples, but there are none");
  if (imu_) observation.imu = imu_->Take(imu_samples);
  if (joints_) observation.joints = joints_->Take(joint_samples);
  if (calibration_.odometry.rate_hz <= 0) return;
  const int64_t odometry_samples = exposures_->Integer(4, "the number of samples of odometry");
  if (odometry_samples > 0 && !odometry_) exposures_->Fail("says samples of odometry, but there is no odometry.csv");
  if (odometry_) observation.odometry = odometry_->Take(odometry_samples);
}

std::optional<Observation> DatasetReader::Source::Next() {
  const std::optional<ListedImage> listed = left_.Next();
  if (!listed) return std::nullopt;
  Observation observation;
  observation.stamp_ns = listed->stamp_ns;
  observation.image = {listed->stamp_ns, ReadPixels(*listed, calibration_.camera)};
  if (right_) {
    if (const auto right = right_->At(listed->stamp_ns, tolerance_ns_)) {
      observation.right = Image{right->stamp_ns, ReadPixels(*right, *calibration_.right)};
    }
  }
  if (depth_) {
    if (const auto depth = depth_->At(listed->stamp_ns, tolerance_ns_)) observation.depth = ReadDepth(*depth);
  }
  AddSamples(observation);
  return observation;
}

DatasetReader::DatasetReader(const fs::path& folder, const DatasetReaderOptions& options)
    : source_(std::make_unique<Source>(FindDataset(folder), options)) {}

DatasetReader::~DatasetReader() = default;

DatasetFormat DatasetReader::format() const { return source_->format_; }
const Calibration& DatasetReader::calibration() const { return source_->calibration_; }
int64_t DatasetReader::frames() const { return source_->frames_; }
std::optional<Observation> DatasetReader::Next() { return source_->Next(); }

}  // namespace gaitcam
