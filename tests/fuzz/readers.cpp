#include "tests/fuzz/readers.h"

#include "algorithms/io/calibration_file.h"
#include "algorithms/io/checksum.h"
#include "algorithms/io/covariance_file.h"
#include "algorithms/io/dataset_reader.h"
#include "algorithms/io/landmark_map_file.h"
#include "algorithms/io/occupancy_grid_file.h"
#include "algorithms/io/place_graph_file.h"
#include "algorithms/io/route_map_file.h"
#include "algorithms/io/trajectory_file.h"
#include "models/code/robots/robot.h"
#include "models/code/robots/robot_urdf.h"
#include "models/code/scenes/scene.h"
#include "models/code/yaml/yaml_reader.h"
#include "results/scoring/baseline.h"
#include "scenarios/code/systems/command_system.h"
#include "scenarios/code/systems/frame_protocol.h"
#include "tests/data_folder.h"
#include "tests/fuzz/fuzz_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

/// A map ends with the checksum of all before, which no fuzzer guesses: it is put there.
void ReadMapOf(const std::string& bytes) { ReadRouteMap(FuzzFile(bytes + Sha256(bytes), "input.map")); }

/// As ours reads it beside the frames of a rig.
void ReadFrameOf(const std::string& line) {
  static const SharedFrames frames = [] {
    Calibration rig;
    rig.camera.width_px = 8;
    rig.camera.height_px = 6;
    const fs::path file = FuzzFile("", "frames");
    fs::remove(file);
    return SharedFrames(file, rig);
  }();
  ReadFrame(line, frames);
}

void ReadKeyFramesOf(const std::string& bytes) {
  ReadKeyFrames(FuzzFile(bytes, "00000_KeyFrameTrajectory.txt").parent_path());
}

FuzzReader OfTable(const std::string& name, DatasetFormat format, const std::string& table) {
  return {name, [format, table](const std::string& bytes) {
            AnswerOrRefuse([&] {
              DatasetReader reader(FuzzDataset(bytes, format, table));
              while (reader.Next()) continue;
            });
          }};
}

void ReadStartOf(const std::string& line) {
  fs::path frames;
  ReadStart(line, frames);
}

}  // namespace

std::vector<FuzzReader> FuzzReaders() {
  return {
      FuzzReaderOfFile("trajectory", ".txt", [](const fs::path& file) { ReadTrajectory(file); }),
      FuzzReaderOfFile("covariances", ".csv", [](const fs::path& file) { ReadCovariances(file); }),
      FuzzReaderOfFile("calibration", ".yaml", [](const fs::path& file) { ReadCalibration(file); }),
      FuzzReaderOfFile("vslamlab_calibration", ".yaml", [](const fs::path& file) { ReadVslamlabCalibration(file); }),
      FuzzReaderOfFile("landmark_map", ".csv", [](const fs::path& file) { ReadLandmarkMap(file); }),
      FuzzReaderOfFile("occupancy_grid", ".yaml", [](const fs::path& file) { ReadOccupancyGrid(file); }),
      FuzzReaderOfFile("place_graph", ".graphml", [](const fs::path& file) { ReadPlaceGraph(file); }),
      FuzzReaderOfText("route_map", ReadMapOf),
      FuzzReaderOfFile("baseline", ".json", [](const fs::path& file) { ReadBaseline(file); }),
      OfTable("tum_images", DatasetFormat::kTum, "rgb.txt"),
      OfTable("tum_exposures", DatasetFormat::kTum, "exposure.csv"),
      OfTable("tum_imu", DatasetFormat::kTum, "imu.csv"),
      OfTable("tum_odometry", DatasetFormat::kTum, "odometry.csv"),
      OfTable("euroc_images", DatasetFormat::kEuroc, "mav0/cam0/data.csv"),
      OfTable("vslamlab_images", DatasetFormat::kVslamlab, "rgb.csv"),
      FuzzReaderOfText("key_frames", ReadKeyFramesOf),
      FuzzReaderOfFile("robot", ".yaml", [](const fs::path& file) { ReadRobot(file.string(), kModels); }),
      FuzzReaderOfFile("scene", ".yaml", [](const fs::path& file) { ReadScene(file.string(), kModels); }),
      FuzzReaderOfFile("urdf", ".urdf", [](const fs::path& file) { ReadUrdf(file, {}); }),
      FuzzReaderOfText("yaml", [](const std::string& text) { ParseYaml(text, "fuzzed.yaml"); }),
      FuzzReaderOfText("live_start", ReadStartOf),
      FuzzReaderOfText("live_frame", ReadFrameOf),
      FuzzReaderOfText("live_ready", [](const std::string& line) { ReadReady(line); }),
      FuzzReaderOfText("live_answer", [](const std::string& line) { ReadAnswer(line, 1'000'000'000); }),
      FuzzReaderOfText("live_final", [](const std::string& line) { ReadFinal(line); }),
  };
}

}  // namespace gaitcam
