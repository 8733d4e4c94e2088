#include "scenarios/code/runs/recorded_walk.h"

#include <algorithm>
#include <map>

#include "algorithms/core/errors.h"
#include "algorithms/io/calibration_file.h"
#include "algorithms/io/dataset_reader.h"
#include "algorithms/io/image_file.h"
#include "algorithms/io/image_table.h"
#include "algorithms/io/text_table.h"
#include "algorithms/io/trajectory_file.h"
#include "results/scoring/statistics.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

using FilesByStamp = std::map<int64_t, fs::path>;

FilesByStamp ReadImageTable(const ImageListing& listing) {
  FilesByStamp files;
  if (!fs::exists(listing.table)) return files;
  ImageTable table(listing);
  while (const auto image = table.Next()) files[image->stamp_ns] = image->file;
  return files;
}

std::map<int64_t, double> ReadExposures(const fs::path& file) {
  std::map<int64_t, double> exposures;
  if (!fs::exists(file)) return exposures;
  TextTable table(file, ',');
  while (table.Next()) exposures[table.Integer(0, "the time in ns")] = table.Number(1, "the exposure in ms");
  return exposures;
}

Pose ReadPose(const TextTable& table, size_t column) {
  double n[7];
  for (size_t i = 0; i < 7; ++i) n[i] = table.Number(column + i, "a pose's number");
  return Pose(Eigen::Quaterniond(n[6], n[3], n[4], n[5]), {n[0], n[1], n[2]});
}

constexpr size_t kOpen = 1, kClose = 8, kBlur = 15;  // columns of frames.csv

template <class Map>
typename Map::mapped_type At(const Map& map, int64_t stamp_ns) {
  const auto it = map.find(stamp_ns);
  return it == map.end() ? typename Map::mapped_type() : it->second;
}

}  // namespace

std::vector<FrameTruth> ReadRecordedTruth(const DatasetFolders& folders) {
  std::vector<FrameTruth> frames;
  TextTable table(folders.truth / "frames.csv", ',');
  while (table.Next()) {
    FrameTruth& frame = frames.emplace_back();
    frame.stamp_ns = table.Integer(0, "the time in ns");
    frame.X_WC_open = ReadPose(table, kOpen);
    frame.X_WC_close = ReadPose(table, kClose);
    frame.blur_median_px = table.Number(kBlur, "blur_median_px");
    frame.blur_p90_px = table.Number(kBlur + 1, "blur_p90_px");
    frame.blur_max_px = table.Number(kBlur + 2, "blur_max_px");
  }
  return frames;
}

RecordedWalk ReadRecordedWalk(const DatasetFolders& folders) {
  const fs::path &sensors = folders.sensors, &truth = folders.truth;
  const DatasetFormat format = FormatOfDataset(sensors);
  RecordedWalk walk{folders, ReadCalibration(RightCalibrationFileOf(folders, format)), {}};
  const FilesByStamp images = ReadImageTable(ListingOf(sensors, format, ImageStream::kLeft));
  const FilesByStamp sharp = ReadImageTable(TumListing(truth, "sharp"));
  const FilesByStamp depth = ReadImageTable(TumListing(truth, "depth")),
                     blur = ReadImageTable(TumListing(truth, "blur"));
  const std::map<int64_t, double> exposures = ReadExposures(sensors / "exposure.csv");
  std::map<int64_t, Pose> poses;
  for (const StampedPose& p : ReadTrajectory(truth / "groundtruth.txt", TrajectoryFormat::kTum).trajectory)
    poses[p.stamp_ns] = p.pose;
  for (const FrameTruth& row : ReadRecordedTruth(folders)) {
    RecordedFrame frame;
    static_cast<FrameTruth&>(frame) = row;
    if (images.count(frame.stamp_ns) == 0 || poses.count(frame.stamp_ns) == 0) continue;
    frame.exposure_ms = At(exposures, frame.stamp_ns);
    frame.image = At(images, frame.stamp_ns);
    frame.sharp = At(sharp, frame.stamp_ns);
    frame.depth = At(depth, frame.stamp_ns);
    frame.blur = At(blur, frame.stamp_ns);
    frame.X_WC = poses[frame.stamp_ns];
    walk.frames.push_back(std::move(frame));
  }
  return walk;
}

cv::Mat ReadTrueDepth(const RecordedWalk& walk, const RecordedFrame& frame) {
  const fs::path exact = walk.folders.truth / "depth_exact" / (std::to_string(frame.stamp_ns) + ".tiff");
  return fs::exists(exact) ? ReadDepthTiff(exact, "") : ReadDepthPng(frame.depth, "");
}

BlurSummary SummariseBlur(const RecordedWalk& walk) {
  std::vector<double> medians;
  for (const RecordedFrame& frame : walk.frames) medians.push_back(frame.blur_median_px);
  if (medians.empty()) return {};
  return {QuantileOf(medians, 0.5), QuantileOf(medians, 0.9), QuantileOf(medians, 1)};
}

}  // namespace gaitcam
