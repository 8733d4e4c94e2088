#include "algorithms/io/dataset_layout.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "algorithms/core/did_you_mean.h"
#include "algorithms/core/errors.h"
#include "algorithms/io/text_table.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExpected = "expected rgb.txt (TUM RGB-D), mav0/cam0/data.csv (EuRoC ASL) or rgb.csv (VSLAM-LAB)";

std::optional<DatasetFormat> LayoutOf(const fs::path& folder) {
  if (fs::exists(folder / "mav0" / "cam0" / "data.csv")) return DatasetFormat::kEuroc;
  if (fs::exists(folder / "rgb.txt")) return DatasetFormat::kTum;
  if (fs::exists(folder / "rgb.csv")) return DatasetFormat::kVslamlab;
  return std::nullopt;
}

ImageListing EurocListing(const fs::path& mav0, const std::string& camera) {
  ImageListing listing;
  listing.folder = listing.base = mav0 / camera / "data";
  listing.table = mav0 / camera / "data.csv";
  return listing;
}

ImageListing VslamlabListing(const fs::path& dataset, const std::string& stream) {
  ImageListing listing;
  listing.folder = dataset / stream;
  listing.base = dataset;
  listing.table = dataset / "rgb.csv";
  listing.stamp_column = "ts_" + stream + " (ns)";
  listing.file_column = "path_" + stream;
  return listing;
}

}  // namespace

std::string ToString(DatasetFormat format) { return std::string(ToWord(format)); }

std::string NameOfLayout(DatasetFormat format) {
  switch (format) {
    case DatasetFormat::kTum: return "TUM RGB-D layout";
    case DatasetFormat::kEuroc: return "EuRoC ASL layout";
    case DatasetFormat::kVslamlab: return "VSLAM-LAB layout";
  }
  GAITCAM_ASSERT(false);
  return {};
}

DatasetFormat DatasetFormatFromText(const std::string& text) {
  if (const auto format = FromWord<DatasetFormat>(text)) return *format;
  throw BadInput("dataset format " + text + ": expected one of " + JoinWords(EnumWords<DatasetFormat>::List()));
}

std::string ImageListing::FileName(int64_t stamp_ns) const {
  return (in_seconds ? SecondsText(stamp_ns) : std::to_string(stamp_ns)) + ".png";
}

ImageListing TumListing(const fs::path& root, const std::string& name) {
  ImageListing listing;
  listing.folder = root / name;
  listing.base = root;
  listing.table = root / (name + ".txt");
  listing.separator = ' ';
  listing.in_seconds = true;
  return listing;
}

ImageListing ListingOf(const fs::path& dataset, DatasetFormat format, ImageStream stream) {
  const auto pick = [&](const char* left, const char* right, const char* depth) {
    return stream == ImageStream::kLeft ? left : stream == ImageStream::kRight ? right : depth;
  };
  switch (format) {
    case DatasetFormat::kTum: return TumListing(dataset, pick("rgb", "rgb_right", "depth"));
    case DatasetFormat::kEuroc: return EurocListing(dataset / "mav0", pick("cam0", "cam1", "depth0"));
    case DatasetFormat::kVslamlab: return VslamlabListing(dataset, pick("rgb_0", "rgb_1", "depth_0"));
  }
  GAITCAM_ASSERT(false);
  return {};
}

fs::path CalibrationFileOf(const fs::path& dataset, DatasetFormat format) {
  return dataset / (format == DatasetFormat::kVslamlab ? "calibration_gaitcam.yaml" : "calibration.yaml");
}

fs::path TimesFileOf(const fs::path& dataset, DatasetFormat format) {
  return ListingOf(dataset, format, ImageStream::kLeft).folder.parent_path() / "times.txt";
}

fs::path ImuFileOf(const fs::path& dataset, DatasetFormat format) {
  switch (format) {
    case DatasetFormat::kTum: return dataset / "imu.csv";
    case DatasetFormat::kEuroc: return dataset / "mav0" / "imu0" / "data.csv";
    case DatasetFormat::kVslamlab: return dataset / "imu_0.csv";
  }
  GAITCAM_ASSERT(false);
  return {};
}

DatasetFolders DatasetFolders::In(const fs::path& out, const std::string& name) {
  return {out / name, out / (name + "-truth")};
}

fs::path TrueCalibrationFileOf(const DatasetFolders& folders) { return folders.truth / "calibration.yaml"; }

fs::path RightCalibrationFileOf(const DatasetFolders& folders, DatasetFormat format) {
  const fs::path right = TrueCalibrationFileOf(folders);
  return fs::exists(right) ? right : CalibrationFileOf(folders.sensors, format);
}

fs::path FindDataset(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw BadInput(folder.string() + ": there is no such folder");
  if (LayoutOf(folder)) return folder;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory() && LayoutOf(entry.path())) found.push_back(entry.path());
  }
  if (found.size() == 1) return found[0];
  if (found.empty()) throw BadInput(folder.string() + ": is no dataset; " + kExpected);
  std::sort(found.begin(), found.end());
  throw BadInput(folder.string() + ": holds several datasets; say which, for example " + found[0].string());
}

DatasetFormat FormatOfDataset(const fs::path& folder) {
  if (const auto format = LayoutOf(folder)) return *format;
  throw BadInput(folder.string() + ": is no dataset; " + kExpected);
}

}  // namespace gaitcam
