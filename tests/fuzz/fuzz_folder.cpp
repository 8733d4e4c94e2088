#include "tests/fuzz/fuzz_folder.h"

#include <unistd.h>

#include <fstream>
#include <map>

#include "algorithms/core/clock.h"
#include "algorithms/io/dataset_writer.h"
#include "algorithms/io/occupancy_grid_file.h"
#include "tests/data_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kFrame_ns = 100'000'000, kImu_ns = 50'000'000;

Calibration TinyRig() {
  Calibration rig;
  rig.camera.width_px = 8;
  rig.camera.height_px = 6;
  rig.camera.fx = rig.camera.fy = 7;
  rig.camera.cx = 3.5;
  rig.camera.cy = 2.5;
  rig.right = rig.camera;
  rig.X_LR.translation = {0.2, 0, 0};
  rig.frame_rate_hz = 10;
  rig.imu.rate_hz = 20;
  rig.odometry.rate_hz = 20;
  return rig;
}

Observation TinyFrame(int frame) {
  Observation o;
  o.stamp_ns = kClockStart_ns + frame * kFrame_ns;
  o.exposure_ms = 5;
  o.image = {o.stamp_ns, cv::Mat::zeros(6, 8, CV_8UC1)};
  o.right = o.image;
  for (int64_t k = 0; k < kFrame_ns / kImu_ns; ++k) {
    const int64_t stamp = o.stamp_ns - kFrame_ns + (k + 1) * kImu_ns;
    o.imu.push_back({stamp, {0, 0, 0.1}, {0, 0, 9.81}});
    o.odometry.push_back({stamp, {0.01 * double(k), 0}, 0.1});
  }
  return o;
}

/// Gone when the process ends.
class Folder {
 public:
  Folder()
      : path_((fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path()) /
              fs::path("gaitcam_fuzz_" + std::to_string(getpid()))) {
    fs::remove_all(path_);  // of an earlier process of that number
    fs::create_directories(path_);
    OccupancyGrid grid;
    grid.cell_m = 0.05;
    grid.log_odds = cv::Mat::zeros(3, 4, CV_32FC1);
    WriteOccupancyGrid(path_ / "grid.yaml", grid);
    std::ofstream(path_ / "base.yaml") << "robot: omni_base\nscene: plain\nduration_s: 0.5\nsystem: orb_vo\n"
                                          "camera: {width_px: 64, height_px: 48, rate_hz: 10}\n";
    for (const std::string name : {"omni_base", "khr1hv"}) {
      fs::copy_file(kModels / "robots" / name / (name + ".urdf"), path_ / (name + ".urdf"));
    }
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

  const fs::path& Dataset(DatasetFormat format, const std::string& table) {
    fs::path& dataset = datasets_[table];
    if (!dataset.empty()) return dataset;
    dataset = path_ / ("dataset" + std::to_string(datasets_.size()));
    DatasetWriterOptions options;
    options.format = format;
    options.threads = 0;
    DatasetWriter writer({dataset, path_ / "no_truth"}, TinyRig(), options);
    constexpr int kFrames = 4;
    for (int frame = 0; frame < kFrames; ++frame) writer.Add(TinyFrame(frame), std::nullopt);
    writer.Finish("finished");
    fs::remove_all(path_ / "no_truth");
    return dataset;
  }

 private:
  fs::path path_;
  std::map<std::string, fs::path> datasets_;
};

Folder& TheFolder() {
  static Folder folder;
  return folder;
}

void Write(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
}

}  // namespace

fs::path FuzzFile(const std::string& bytes, const std::string& name) {
  fs::path file = TheFolder().path() / name;
  Write(file, bytes);
  return file;
}

fs::path FuzzDataset(const std::string& bytes, DatasetFormat format, const std::string& table) {
  const fs::path& dataset = TheFolder().Dataset(format, table);
  Write(dataset / table, bytes);
  return dataset;
}

}  // namespace gaitcam
