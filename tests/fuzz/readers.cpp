#include "tests/fuzz/readers.h"

#include <unistd.h>

#include <fstream>

#include "algorithms/core/errors.h"
#include "algorithms/io/calibration_file.h"
#include "algorithms/io/checksum.h"
#include "algorithms/io/covariance_file.h"
#include "algorithms/io/landmark_map_file.h"
#include "algorithms/io/occupancy_grid_file.h"
#include "algorithms/io/place_graph_file.h"
#include "algorithms/io/route_map_file.h"
#include "algorithms/io/trajectory_file.h"
#include "models/code/robots/robot_urdf.h"
#include "models/code/yaml/yaml_reader.h"
#include "results/scoring/baseline.h"
#include "scenarios/code/systems/frame_protocol.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

/// A folder of this process, in memory where there is such a place; gone when the process ends.
class Folder {
 public:
  Folder()
      : path_((fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path()) /
              fs::path("gaitcam_fuzz_" + std::to_string(getpid()))) {
    fs::create_directories(path_);
    OccupancyGrid grid;  // the picture that grid.yaml of the corpus names
    grid.cell_m = 0.05;
    grid.log_odds = cv::Mat::zeros(3, 4, CV_32FC1);
    WriteOccupancyGrid(path_ / "grid.yaml", grid);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

fs::path FileOf(const std::string& bytes, const std::string& suffix) {
  static const Folder folder;
  fs::path file = folder.path() / ("input" + suffix);
  std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
  return file;
}

/// Those are the answers to bad input that errors.h knows; anything else is not caught.
void Try(const std::function<void()>& read) {
  try {
    read();
  } catch (const BadInput&) {
  } catch (const TooLittleData&) {
  }
}

template <class Read>
FuzzReader OfFile(const std::string& name, const std::string& suffix, Read read) {
  return {name, [suffix, read](const std::string& bytes) { Try([&] { read(FileOf(bytes, suffix)); }); }};
}

template <class Read>
FuzzReader OfText(const std::string& name, Read read) {
  return {name, [read](const std::string& bytes) { Try([&] { read(bytes); }); }};
}

/// A map ends with the checksum of all before, which no fuzzer guesses: it is put there.
void ReadMapOf(const std::string& bytes) { ReadRouteMap(FileOf(bytes + Sha256(bytes), ".map")); }

}  // namespace

const std::vector<FuzzReader>& FuzzReaders() {
  static const std::vector<FuzzReader> readers = {
      OfFile("trajectory", ".txt", [](const fs::path& file) { ReadTrajectory(file); }),
      OfFile("covariances", ".csv", [](const fs::path& file) { ReadCovariances(file); }),
      OfFile("calibration", ".yaml", [](const fs::path& file) { ReadCalibration(file); }),
      OfFile("vslamlab_calibration", ".yaml", [](const fs::path& file) { ReadVslamlabCalibration(file); }),
      OfFile("landmark_map", ".csv", [](const fs::path& file) { ReadLandmarkMap(file); }),
      OfFile("occupancy_grid", ".yaml", [](const fs::path& file) { ReadOccupancyGrid(file); }),
      OfFile("place_graph", ".graphml", [](const fs::path& file) { ReadPlaceGraph(file); }),
      OfText("route_map", ReadMapOf),
      OfFile("baseline", ".json", [](const fs::path& file) { ReadBaseline(file); }),
      OfFile("urdf", ".urdf", [](const fs::path& file) { ReadUrdf(file, {}); }),
      OfText("yaml", [](const std::string& text) { ParseYaml(text, "fuzzed.yaml"); }),
      OfText("live_ready", [](const std::string& line) { ReadReady(line); }),
      OfText("live_answer", [](const std::string& line) { ReadAnswer(line, 1'000'000'000); }),
      OfText("live_final", [](const std::string& line) { ReadFinal(line); }),
  };
  return readers;
}

}  // namespace gaitcam
