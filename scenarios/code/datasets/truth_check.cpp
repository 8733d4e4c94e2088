#include "scenarios/code/datasets/truth_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "algorithms/core/errors.h"
#include "algorithms/core/median.h"
#include "algorithms/io/image_file.h"
#include "algorithms/io/text_table.h"
#include "models/code/yaml/yaml_reader.h"
#include "scenarios/code/datasets/frame_pairs.h"
#include "scenarios/code/runs/recorded_walk.h"
#include "sim/camera/camera_rig.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr double kUnit = 1e-6;       // of quaternions: they are written to all digits
constexpr double kSpeed_mps = 20;    // faster than any robot here moves its camera
constexpr int kGeometryFrames = 24;  // spread over the walk
constexpr double kMaxFloorHeight_m = 0.002;
constexpr double kFocalError = 0.005, kFocalCertain = 0.001;  // relative
constexpr double kBlur_px = 0.1, kBlurPart = 0.01;            // stored to 1/64 px
constexpr double kPair_px = 0.5;

class TruthCheck {
 public:
  TruthCheck(const DatasetFolders& folders, const std::vector<CheckedImage>& frames,
             const std::optional<Calibration>& calibration, SequenceReport& report)
      : folders_(folders),
        format_(FormatOfDataset(folders.sensors)),
        calibration_(calibration),
        report_(report),
        problems_(report.problems) {
    for (const CheckedImage& frame : frames) stamps_.push_back(frame.stamp_ns);
  }

  void Run() {
    CheckPoses(folders_.truth / "groundtruth.txt", ' ');
    const fs::path states = folders_.truth / "mav0" / "state_groundtruth_estimate0" / "data.csv";
    if (format_ == DatasetFormat::kEuroc || fs::exists(states)) CheckPoses(states, ',');
    if (format_ == DatasetFormat::kVslamlab) CheckPoses(folders_.truth / "groundtruth.csv", ',', true);
    CheckFrames();
    CheckSubposes();
    CheckImagesOfTruth();
    CheckScenario();
    try {
      CheckGeometry();
    } catch (const BadInput&) {
      // its tables or images are faulty: reported above
    }
  }

 private:
  std::string frames_name() const { return folders_.sensors.filename().string(); }

  /// Rows of a time, a position and a quaternion.
  void CheckPoses(const fs::path& file, char separator, bool names_columns = false) {
    constexpr size_t kQuaternion = 4;
    CheckedTable table(file, separator, 8, problems_, names_columns);
    if (!table.was_read()) return;
    if (separator == ' ') CheckTumHeader(table);
    const auto stamps = table.Stamps(separator == ' ');
    CompareStamps(stamps, table, stamps_, frames_name());
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
    bool last_known = false;
    for (size_t row = 0; row < table.size(); ++row) {
      table.UnitQuaternion(row, kQuaternion, kUnit, "the pose");
      const std::optional<Eigen::Vector3d> p = Position(table, row, 1, "the pose: a part of its position");
      if (p && last_known && stamps[row] && stamps[row - 1] && *stamps[row] > *stamps[row - 1]) {
        const double speed = (*p - last).norm() / (double(*stamps[row] - *stamps[row - 1]) * 1e-9);
        if (speed > kSpeed_mps)
          table.Fail(row, fmt::format("the pose is {:.2f} m from the one before it", (*p - last).norm()));
      }
      last_known = p.has_value();
      if (p) last = *p;
    }
  }

  static std::optional<Eigen::Vector3d> Position(CheckedTable& table, size_t row, size_t column,
                                                 const std::string& what) {
    const auto x = table.Number(row, column, what), y = table.Number(row, column + 1, what),
               z = table.Number(row, column + 2, what);
    if (!x || !y || !z) return std::nullopt;
    return Eigen::Vector3d(*x, *y, *z);
  }

  void CheckFrames() {
    CheckedTable table(folders_.truth / "frames.csv", ',', 29, problems_);
    if (!table.was_read()) return;
    CompareStamps(table.Stamps(false), table, stamps_, frames_name());
    for (size_t row = 0; row < table.size(); ++row) {
      for (const auto& [column, what] : {std::pair<size_t, const char*>{1, "the pose at shutter open"},
                                         {8, "the pose at shutter close"},
                                         {22, "the root's pose"}}) {
        if (table.Text(row, column).empty()) continue;
        Position(table, row, column, what);
        table.UnitQuaternion(row, column + 3, kUnit, what);
      }
      const auto median = table.Number(row, 15, "the median blur"), p90 = table.Number(row, 16, "the 90 % blur"),
                 most = table.Number(row, 17, "the largest blur");
      if (median && p90 && most && !(0 <= *median && *median <= *p90 && *p90 <= *most))
        table.Fail(row, fmt::format("blur of median {}, 90 % {} and maximum {} px is not in this order", *median, *p90,
                                    *most));
    }
  }

  void CheckSubposes() {
    CheckedTable table(folders_.truth / "subposes.csv", ',', 10, problems_);
    if (!table.was_read()) return;
    std::map<int64_t, double> weights;  // by frame
    for (size_t row = 0; row < table.size(); ++row) {
      const auto frame = table.Integer(row, 0, "the frame's time");
      table.Integer(row, 1, "the time in nanoseconds");
      const auto weight = table.Number(row, 2, "the weight");
      Position(table, row, 3, "the pose: a part of its position");
      table.UnitQuaternion(row, 6, kUnit, "the pose");
      if (frame && weight) weights[*frame] += *weight;
    }
    for (const int64_t stamp : stamps_) {
      const auto it = weights.find(stamp);
      if (it == weights.end()) {
        table.FailWhole(fmt::format("has no sub-frame of the frame at {} s", SecondsText(stamp)));
      } else if (std::abs(it->second - 1) > 1e-6) {
        table.FailWhole(fmt::format("the weights of the frame at {} s add up to {:.6g}, expected 1", SecondsText(stamp),
                                    it->second));
      }
    }
  }

  void CheckImagesOfTruth() {
    const CameraModel camera = calibration_ ? calibration_->camera : CameraModel();
    for (const auto& [name, kind] :
         {std::pair{"sharp", ImageKind::kPicture}, {"depth", ImageKind::kDepth}, {"blur", ImageKind::kVectors}}) {
      const ImageListing listing = TumListing(folders_.truth, name);
      if (!fs::exists(listing.table) && !fs::exists(listing.folder)) continue;  // recorded without truth images
      report_.images += int64_t(CheckImages(listing, kind, camera, true, problems_).size());
      CompareImages(listing, stamps_, frames_name(), problems_);
    }
  }

  /// The calibration must be that of the scenario which made the walk.
  void CheckScenario() {
    const fs::path file = folders_.truth / "scenario.yaml";
    try {
      const OptionValue root = LoadYaml(file);
      CameraOptions options;
      if (!root.Has("camera")) root.Fail("expected the key `camera`");
      ReadOption(root.Child("camera"), options);
      readout_ms_ = options.exposure.readout_ms;
      if (calibration_) CompareCalibration(CameraRig(options, 1).MakeCalibration(), file);
    } catch (const BadInput& e) {
      problems_.push_back({file, 0, e.what()});
    }
  }

  void CompareCalibration(const Calibration& wanted, const fs::path& file) {
    const auto compare = [&](const std::string& key, double is, double should_be) {
      if (std::abs(is - should_be) <= 1e-9 * std::max(1.0, std::abs(should_be))) return;
      problems_.push_back(
          {RightCalibrationFileOf(folders_, format_), 0,
           fmt::format("{} is {:.9g}, but the camera of {} has {:.9g}", key, is, file.string(), should_be)});
    };
    const auto compare_camera = [&](const std::string& key, const CameraModel& a, const CameraModel& b) {
      compare(key + ".width_px", a.width_px, b.width_px);
      compare(key + ".height_px", a.height_px, b.height_px);
      compare(key + ".fx", a.fx, b.fx);
      compare(key + ".fy", a.fy, b.fy);
      compare(key + ".cx", a.cx, b.cx);
      compare(key + ".cy", a.cy, b.cy);
      compare(key + ".k1", a.k1, b.k1);
      compare(key + ".k2", a.k2, b.k2);
      compare(key + ".k3", a.k3, b.k3);
      compare(key + ".p1", a.p1, b.p1);
      compare(key + ".p2", a.p2, b.p2);
    };
    compare_camera("camera", calibration_->camera, wanted.camera);
    compare("frame_rate_hz", calibration_->frame_rate_hz, wanted.frame_rate_hz);
    compare("has_depth", calibration_->has_depth, wanted.has_depth);
    compare("right", calibration_->right.has_value(), wanted.right.has_value());
    if (!calibration_->right || !wanted.right) return;
    compare_camera("right", *calibration_->right, *wanted.right);
    for (int i = 0; i < 3; ++i) compare("X_LR", calibration_->X_LR.translation[i], wanted.X_LR.translation[i]);
    compare("X_LR", RotationAngle(calibration_->X_LR.rotation, wanted.X_LR.rotation), 0);
  }

  /// Depth, poses, blur vectors, pairs and intrinsics must agree.
  void CheckGeometry() {
    if (!calibration_ || stamps_.empty()) return;
    RecordedWalk walk = ReadRecordedWalk(folders_);
    walk.calibration = *calibration_;
    FloorFit fit(calibration_->camera);
    const size_t stride = std::max<size_t>(1, walk.frames.size() / size_t(kGeometryFrames));
    std::vector<std::pair<const RecordedFrame*, double>> heights;
    for (size_t i = 0; i < walk.frames.size(); i += stride) {
      const RecordedFrame& frame = walk.frames[i];
      if (!Readable(frame.depth, ImageKind::kDepth)) continue;
      const cv::Mat depth = ReadTrueDepth(walk, frame);
      fit.Add(frame.X_WC, depth);
      if (const auto height = FloorFit::FloorHeight(calibration_->camera, frame.X_WC, depth))
        heights.emplace_back(&frame, *height);
      if (Readable(frame.blur, ImageKind::kVectors)) CheckBlur(frame, depth);
    }
    report_.floor = fit.Fit();
    if (!JudgeFocalLengths()) JudgeHeights(heights);
    CheckPairs(walk);
  }

  bool Readable(const fs::path& file, ImageKind kind) const {
    return !file.empty() && FaultOfImage(file, kind, calibration_->camera, nullptr).empty();
  }

  /// @returns whether there was a fault.
  bool JudgeFocalLengths() {
    if (!report_.floor) return false;
    const FloorIntrinsics& floor = *report_.floor;
    bool wrong = false;
    for (const auto& [key, is, should_be, std] : {std::tuple{"fx", calibration_->camera.fx, floor.fx, floor.fx_std},
                                                  {"fy", calibration_->camera.fy, floor.fy, floor.fy_std}}) {
      if (std > kFocalCertain * should_be || std::abs(is / should_be - 1) <= kFocalError) continue;
      problems_.push_back(
          {RightCalibrationFileOf(folders_, format_), 0,
           fmt::format("camera.{} is {:.2f} px, but {} points of the floor, by true depth and pose, lie in "
                       "the floor at {:.2f} px ({:+.1f} %)",
                       key, is, floor.points, should_be, 100 * (is / should_be - 1))});
      wrong = true;
    }
    return wrong;
  }

  void JudgeHeights(const std::vector<std::pair<const RecordedFrame*, double>>& heights) {
    for (const auto& [frame, height] : heights) {
      if (height <= kMaxFloorHeight_m) continue;
      problems_.push_back({frame->depth, 0,
                           fmt::format("by depth and pose (groundtruth.txt, {} s) the floor is {:.1f} mm off",
                                       SecondsText(frame->stamp_ns), 1e3 * height)});
    }
  }

  /// A blur vector is the displacement, from shutter open to close, of the image of the point observed at a pixel.
  void CheckBlur(const RecordedFrame& frame, const cv::Mat& depth) {
    const CameraModel& camera = calibration_->camera;
    const cv::Mat vectors = ReadVectorsPng(frame.blur, "");
    const Pose X_open = frame.X_WC_open.Inverse() * frame.X_WC, X_close = frame.X_WC_close.Inverse() * frame.X_WC;
    std::vector<double> errors, lengths;
    const int middle = depth.rows / 2;  // a rolling shutter's open and close are those of the middle row
    for (int v = readout_ms_ > 0 ? middle : 2; v < (readout_ms_ > 0 ? middle + 1 : depth.rows); v += 6) {
      for (int u = 2; u<depth.cols; u += readout_ms_> 0 ? 1 : 6) {
        const auto& given = vectors.at<cv::Vec2f>(v, u);
        const double z = double(depth.at<float>(v, u));
        if (std::isnan(given[0]) || !(z > 0)) continue;
        const Eigen::Vector3d p = z * camera.Unproject({double(u), double(v)});
        const auto open = camera.Project(X_open * p), close = camera.Project(X_close * p);
        if (!open || !close) continue;
        errors.push_back((*close - *open - Eigen::Vector2d(given[0], given[1])).norm());
        lengths.push_back(std::hypot(given[0], given[1]));
      }
    }
    if (errors.size() < 20) return;
    const double error = UpperMedian(std::move(errors)), length = UpperMedian(std::move(lengths));
    if (error <= kBlur_px + kBlurPart * length) return;
    problems_.push_back({frame.blur, 0,
                         fmt::format("its vectors ({:.1f} px) are {:.2f} px off what depth and the poses of "
                                     "frames.csv at shutter open and close imply",
                                     length, error)});
  }

  void CheckPairs(const RecordedWalk& walk) {
    const fs::path folder = folders_.truth / "pairs";
    if (!fs::is_directory(folder)) return;
    CheckedTable table(folder / "pairs.csv", ',', 9, problems_);
    std::map<int64_t, const RecordedFrame*> frames;
    for (const RecordedFrame& frame : walk.frames) frames[frame.stamp_ns] = &frame;
    for (size_t row = 0; row < table.size(); ++row) {
      const auto a = table.Integer(row, 3, "the time of a"), b = table.Integer(row, 4, "the time of b");
      const fs::path pair = folder / table.Text(row, 0);
      for (const char* name : {"a.png", "b.png", "a_sharp.png", "b_sharp.png", "a_blur.png", "b_blur.png"}) {
        const auto kind =
            std::string(name).find("blur") == std::string::npos ? ImageKind::kPicture : ImageKind::kVectors;
        const std::string fault = FaultOfImage(pair / name, kind, calibration_->camera, nullptr);
        if (!fault.empty()) problems_.push_back({pair / name, 0, fault});
      }
      if (a && b && frames.count(*a) > 0 && frames.count(*b) > 0) {
        CheckPair(pair, *frames[*a], *frames[*b]);
      } else {
        table.Fail(row, "names a frame that is not there");
      }
    }
  }

  void CheckPair(const fs::path& pair, const RecordedFrame& a, const RecordedFrame& b) {
    CheckedTable homography(pair / "H_floor.txt", ' ', 3, problems_), points(pair / "points.csv", ',', 8, problems_);
    Eigen::Matrix3d H = Eigen::Matrix3d::Identity();
    if (homography.was_read() && homography.size() != 3) homography.FailWhole("expected three rows of three numbers");
    for (size_t row = 0; row < std::min<size_t>(3, homography.size()); ++row) {
      for (size_t column = 0; column < 3; ++column)
        H(long(row), long(column)) = homography.Number(row, column, "an entry").value_or(NAN);
    }
    const CameraModel& camera = calibration_->camera;
    CameraModel plain = camera;
    plain.k1 = plain.k2 = plain.k3 = plain.p1 = plain.p2 = 0;
    for (size_t row = 0; row < points.size(); ++row) {
      double n[8];
      bool finite = true;
      for (size_t i = 0; i < 8; ++i) {
        const auto number = points.Number(row, i, "a number of a point");
        finite = finite && number;
        n[i] = number.value_or(0);
      }
      if (!finite) continue;
      const Eigen::Vector3d p_W(n[4], n[5], n[6]);
      const auto in_a = camera.Project(a.X_WC.Inverse() * p_W), in_b = camera.Project(b.X_WC.Inverse() * p_W);
      const double error = in_a && in_b ? std::max((*in_a - Eigen::Vector2d(n[0], n[1])).norm(),
                                                   (*in_b - Eigen::Vector2d(n[2], n[3])).norm())
                                        : HUGE_VAL;
      if (error > kPair_px) {
        points.Fail(row, fmt::format("the point projects {:.2f} px beside its pixel", error));
        return;  // with a wrong pose or camera all frames fail
      }
      if (n[7] == 0) continue;
      const Eigen::Vector3d from = plain.K() * camera.Unproject({n[0], n[1]}),
                            to = plain.K() * camera.Unproject({n[2], n[3]});
      const double off = ((H * from).hnormalized() - to.hnormalized()).norm();
      if (off > kPair_px || std::isnan(off)) {
        homography.FailWhole(fmt::format("maps the floor point of {}:{} {:.2f} px beside its match",
                                         points.file().string(), points.line(row), off));
        return;
      }
    }
  }

  const DatasetFolders& folders_;
  const DatasetFormat format_;
  const std::optional<Calibration>& calibration_;
  SequenceReport& report_;
  Problems& problems_;
  std::vector<int64_t> stamps_;
  double readout_ms_ = 0;
};

}  // namespace

void CheckTruth(const DatasetFolders& folders, const std::vector<CheckedImage>& frames,
                const std::optional<Calibration>& calibration, SequenceReport& report) {
  TruthCheck(folders, frames, calibration, report).Run();
}

}  // namespace gaitcam
