#include "algorithms/io/truth_files.h"

#include <fmt/format.h>

#include <system_error>

#include "algorithms/io/calibration_file.h"
#include "algorithms/io/trajectory_file.h"
#include "algorithms/io/whole_file.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

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

std::string CellsOrEmpty(const std::optional<Pose>& X) { return X ? PoseCells(*X) : std::string(7, ','); }

}  // namespace

TruthFiles::TruthFiles(const fs::path& folder, DatasetFormat format, const Calibration& calibration,
                       const std::optional<fs::path>& inside)
    : format_(format),
      calibration_(calibration),
      folder_(folder),
      frames_(folder_.path() / "frames.csv",
              "#stamp_ns" + PoseColumns("X_WC_open") + PoseColumns("X_WC_close") +
                  ",blur_median_px,blur_p90_px,blur_max_px,step,step_phase,left_contact,right_contact" +
                  PoseColumns("X_WB")),
      subposes_(folder_.path() / "subposes.csv", "#frame_stamp_ns,stamp_ns,weight" + PoseColumns("X_WC")) {
  AddPoses(folder_.path());
  if (format_ != DatasetFormat::kTum) AddLayoutsOwn(folder_.path());
  if (inside) AddLayoutsOwn(*inside);
}

/// The table in which the layout keeps its truth.
void TruthFiles::AddLayoutsOwn(const fs::path& root) {
  switch (format_) {
    case DatasetFormat::kTum: return AddPoses(root);
    case DatasetFormat::kEuroc: return AddStates(root);
    case DatasetFormat::kVslamlab:
      rows_.emplace_back(root / "groundtruth.csv", "ts (ns),tx (m),ty (m),tz (m),qx,qy,qz,qw");
  }
}

void TruthFiles::AddPoses(const fs::path& root) {
  poses_.emplace_back(root / "groundtruth.txt",
                      TumHeader("poses X_WC of the left camera", "timestamp tx ty tz qx qy qz qw"));
}

void TruthFiles::AddStates(const fs::path& root) {
  const fs::path folder = root / "mav0" / "state_groundtruth_estimate0";
  states_.emplace_back(
      folder / "data.csv",
      "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []");
  WriteText(folder / "sensor.yaml", EurocTruthText());
}

void TruthFiles::Add(int64_t stamp_ns, const FilmedTruth& truth, ImageJobs& jobs) {
  for (RowFile& file : poses_) file.Row(TrajectoryRow({stamp_ns, truth.X_WC}, TrajectoryFormat::kTum));
  const Pose X_WI = truth.X_WI ? *truth.X_WI : truth.X_WC * calibration_.imu.X_CI;
  const Pose body = calibration_.imu.rate_hz > 0 ? X_WI : truth.X_WC;
  for (RowFile& file : states_) file.Row(TrajectoryRow({stamp_ns, body}, TrajectoryFormat::kEuroc));
  for (RowFile& file : rows_) file.Row(std::to_string(stamp_ns) + PoseCells(truth.X_WC));
  const GaitState gait = truth.gait.value_or(GaitState());
  frames_.Row(std::to_string(stamp_ns) + PoseCells(truth.X_WC_open) + PoseCells(truth.X_WC_close) +
              fmt::format(",{},{},{},{},{},{},{}", truth.blur_median_px, truth.blur_p90_px, truth.blur_max_px,
                          gait.step, gait.phase, int(truth.left_contact), int(truth.right_contact)) +
              CellsOrEmpty(truth.X_WB));
  for (const auto& sub : truth.subframes) {
    subposes_.Row(fmt::format("{},{},{}", stamp_ns, sub.stamp_ns, sub.weight) + PoseCells(sub.X_WC));
  }
  AddImages(stamp_ns, truth, jobs);
}

void TruthFiles::AddImages(int64_t stamp_ns, const FilmedTruth& truth, ImageJobs& jobs) {
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

void TruthFiles::Finish(int64_t frames, const std::string& ending) {
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

void TruthFiles::Keep() {
  std::error_code ignored;
  fs::remove(folder_.wanted() / (kHalfNamed + NameOfProcess()), ignored);
  folder_.Keep();
}

const DatasetFolders& WithoutHalfNamed(const DatasetFolders& folders) {
  if (!HoldsAbandoned(folders.truth, kHalfNamed)) return folders;
  std::error_code ignored;
  fs::remove_all(folders.sensors, ignored);
  fs::remove_all(folders.truth, ignored);
  return folders;
}

}  // namespace gaitcam
