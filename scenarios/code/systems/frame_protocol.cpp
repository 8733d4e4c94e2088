#include "scenarios/code/systems/frame_protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/json_whole.h"
#include "scenarios/code/systems/foreign_words.h"

namespace gaitcam {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

Json JsonOf(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json JsonOf(const Pose& X) {
  const Eigen::Quaterniond& q = X.rotation;
  return {X.translation.x(), X.translation.y(), X.translation.z(), q.x(), q.y(), q.z(), q.w()};
}

Json JsonOf(const CameraModel& c) {
  return {{"width_px", c.width_px},
          {"height_px", c.height_px},
          {"fx", c.fx},
          {"fy", c.fy},
          {"cx", c.cx},
          {"cy", c.cy},
          {"k1", c.k1},
          {"k2", c.k2},
          {"p1", c.p1},
          {"p2", c.p2},
          {"k3", c.k3}};
}

Json JsonOf(const Calibration& c) {
  const ImuCalibration& i = c.imu;
  Json json{{"camera", JsonOf(c.camera)}};
  if (c.right) json["right"] = JsonOf(*c.right);
  json["X_LR"] = JsonOf(c.X_LR);
  json["lens"] = {{"focal", c.lens.focal}, {"centre_px", c.lens.centre_px}, {"right_focal", c.lens.right_focal}};
  json["has_depth"] = c.has_depth;
  if (c.has_depth) json["depth"] = {{"sigma_m", c.depth.sigma_m}, {"sigma_per_m", c.depth.sigma_per_m}};
  json["frame_rate_hz"] = c.frame_rate_hz;
  json["readout_ms"] = c.readout_ms;
  json["imu"] = {{"rate_hz", i.rate_hz},
                 {"gyro_noise_density", i.gyro_noise_density},
                 {"gyro_random_walk", i.gyro_random_walk},
                 {"accel_noise_density", i.accel_noise_density},
                 {"accel_random_walk", i.accel_random_walk},
                 {"X_CI", JsonOf(i.X_CI)}};
  if (const OdometryCalibration& b = c.odometry; b.rate_hz > 0) {
    json["odometry"] = {{"rate_hz", b.rate_hz},
                        {"X_BC", JsonOf(b.X_BC)},
                        {"position_per_sqrt_m", b.position_per_sqrt_m},
                        {"heading_per_sqrt_m", b.heading_per_sqrt_m},
                        {"heading_per_sqrt_rad", b.heading_per_sqrt_rad},
                        {"rocking_m", b.rocking_m},
                        {"rocking_rad", b.rocking_rad}};
  }
  if (c.standing) {
    json["standing"] = {{"height_m", c.standing->height_m},
                        {"up_C", JsonOf(c.standing->up_C)},
                        {"height_sigma", c.standing->height_sigma},
                        {"pitch_sigma", c.standing->pitch_sigma}};
  }
  return json;
}

/// One that may be left out: 0 then.
int CountOf(const Json& json, const char* key) { return json.contains(key) ? WholeOf<int>(json.at(key), key) : 0; }

/// A list of exactly `count` finite numbers.
std::vector<double> Numbers(const Json& json, size_t count, const char* what) {
  const auto fail = [&] { throw BadInput(fmt::format("{}: expected {} finite numbers", what, count)); };
  if (!json.is_array() || json.size() != count) fail();
  std::vector<double> numbers;
  for (const Json& number : json) {
    if (!number.is_number() || !std::isfinite(number.get<double>())) fail();
    numbers.push_back(number.get<double>());
  }
  return numbers;
}

Eigen::Vector3d VectorOf(const Json& json, const char* what) {
  const std::vector<double> v = Numbers(json, 3, what);
  return {v[0], v[1], v[2]};
}

Pose PoseOf(const Json& json, const char* what) {
  const std::vector<double> v = Numbers(json, 7, what);
  Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  constexpr double kMaxRounding = 1e-12, kMaxError = 1e-3;  // of the norm: ours come back to the bit
  const double error = std::abs(q.norm() - 1);
  if (error > kMaxError) throw BadInput(fmt::format("{}: expected x, y, z and a unit quaternion x, y, z, w", what));
  if (error > kMaxRounding) q.normalize();
  const Eigen::Vector3d translation(v[0], v[1], v[2]);
  if (!(translation.norm() <= kMaxForeignDistance_m)) {
    throw BadInput(fmt::format("{}: expected x, y, z within {:g} m", what, kMaxForeignDistance_m));
  }
  return {q, translation};
}

CameraModel CameraOf(const Json& json) {
  CameraModel c;
  c.width_px = WholeOf<int>(json.at("width_px"), "width_px");
  c.height_px = WholeOf<int>(json.at("height_px"), "height_px");
  for (const auto& [key, member] : {std::pair{"fx", &c.fx},
                                    {"fy", &c.fy},
                                    {"cx", &c.cx},
                                    {"cy", &c.cy},
                                    {"k1", &c.k1},
                                    {"k2", &c.k2},
                                    {"p1", &c.p1},
                                    {"p2", &c.p2},
                                    {"k3", &c.k3}}) {
    *member = json.at(key);
  }
  return c;
}

Calibration CalibrationOf(const Json& json) {
  Calibration c;
  c.camera = CameraOf(json.at("camera"));
  if (json.contains("right")) c.right = CameraOf(json.at("right"));
  c.X_LR = PoseOf(json.at("X_LR"), "X_LR");
  const Json& lens = json.at("lens");
  c.lens = {lens.at("focal"), lens.at("centre_px"), lens.at("right_focal")};
  c.has_depth = json.at("has_depth");
  if (c.has_depth) c.depth = {json.at("depth").at("sigma_m"), json.at("depth").at("sigma_per_m")};
  c.frame_rate_hz = json.at("frame_rate_hz");
  c.readout_ms = json.at("readout_ms");
  const Json& imu = json.at("imu");
  c.imu.rate_hz = imu.at("rate_hz");
  c.imu.gyro_noise_density = imu.at("gyro_noise_density");
  c.imu.gyro_random_walk = imu.at("gyro_random_walk");
  c.imu.accel_noise_density = imu.at("accel_noise_density");
  c.imu.accel_random_walk = imu.at("accel_random_walk");
  c.imu.X_CI = PoseOf(imu.at("X_CI"), "X_CI");
  if (json.contains("odometry")) {
    const Json& body = json.at("odometry");
    c.odometry = {body.at("rate_hz"),
                  PoseOf(body.at("X_BC"), "X_BC"),
                  body.at("position_per_sqrt_m"),
                  body.at("heading_per_sqrt_m"),
                  body.at("heading_per_sqrt_rad"),
                  body.at("rocking_m"),
                  body.at("rocking_rad")};
  }
  if (json.contains("standing")) {
    const Json& standing = json.at("standing");
    c.standing = {standing.at("height_m"), VectorOf(standing.at("up_C"), "up_C"), standing.at("height_sigma"),
                  standing.at("pitch_sigma")};
  }
  return c;
}

Json SettingJson(const OptionValue& value) {
  if (const std::optional<double> number = value.AsNumber()) return *number;
  return value.text();
}

/// Copies the pixels to `offset`, which moves on. @returns the words for them.
Json PutImage(const cv::Mat& pixels, SharedFrames& frames, size_t& offset) {
  const cv::Mat packed = pixels.isContinuous() ? pixels : pixels.clone();
  const size_t bytes = packed.total() * packed.elemSize();
  GAITCAM_ASSERT(offset + bytes <= frames.size());
  std::memcpy(frames.data() + offset, packed.data, bytes);
  const Json json{{"offset", offset},
                  {"height", packed.rows},
                  {"width", packed.cols},
                  {"channels", packed.channels()},
                  {"type", packed.depth() == CV_32F ? "float32" : "uint8"}};
  offset += bytes;
  return json;
}

Image GetImage(const Json& json, const SharedFrames& frames, int64_t stamp_ns) {
  const auto whole = [&](const char* key) { return WholeOf<int64_t>(json.at(key), key); };
  const int64_t channels = whole("channels"), height = whole("height"), width = whole("width");
  const int64_t offset = whole("offset"), room = int64_t(frames.size()) - std::max<int64_t>(0, offset);
  constexpr int64_t kMostChannels = 4, kMostPixels = 1 << 16;
  const auto is_within = [](int64_t value, int64_t most) { return value >= 1 && value <= most; };
  if (!is_within(channels, kMostChannels) || !is_within(height, kMostPixels) || !is_within(width, kMostPixels)) {
    throw BadInput("an image of no size: expected channels, height and width");
  }
  const bool is_float = json.at("type") == "float32";
  const int64_t bytes = channels * height * width * (is_float ? int64_t(sizeof(float)) : 1);
  if (offset < 0 || room < bytes) throw BadInput("an image beyond the shared file");
  const int type = is_float ? CV_32FC(int(channels)) : CV_8UC(int(channels));
  const cv::Mat shared(int(height), int(width), type, frames.data() + offset);
  return {stamp_ns, shared.clone()};
}

Json JsonOf(const Matrix6d& covariance) {
  Json rows = Json::array();
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) rows.push_back(covariance(row, column));
  }
  return rows;
}

Matrix6d CovarianceOf(const Json& json, const char* name) {
  const std::vector<double> values = Numbers(json, 36, name);
  return Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(values.data());
}

CommonErrors CommonErrorsOf(const Json& json) {
  if (!json.is_array()) throw BadInput("common_errors: expected a list of lists of 6 finite numbers");
  CommonErrors errors(6, long(json.size()));
  for (size_t i = 0; i < json.size(); ++i) {
    errors.col(long(i)) = Eigen::Map<const Vector6d>(Numbers(json[i], 6, "common_errors").data());
  }
  return errors;
}

Json JsonOf(const FrameEstimate& frame) {
  Json json{{"status", ToString(frame.status)}};
  if (frame.pose) json["pose"] = JsonOf(*frame.pose);
  if (frame.covariance) json["covariance"] = JsonOf(*frame.covariance);
  if (frame.own_covariance) json["own_covariance"] = JsonOf(*frame.own_covariance);
  for (const auto& error : frame.common_errors.colwise()) {
    json["common_errors"].push_back(std::vector<double>(error.begin(), error.end()));
  }
  if (frame.predicted) json["predicted"] = JsonOf(*frame.predicted);
  if (frame.restarted) json["restarted"] = true;
  json["features"] = frame.features;
  json["inliers"] = frame.inliers;
  if (frame.matches > 0) json["matches"] = frame.matches;
  return json;
}

TrackingStatus StatusOf(const Json& json) {
  for (const TrackingStatus status :
       {TrackingStatus::kInitializing, TrackingStatus::kTracking, TrackingStatus::kLost}) {
    if (json.is_string() && json == ToString(status)) return status;
  }
  throw BadInput("status: expected initializing, tracking or lost");
}

FrameEstimate EstimateOf(const Json& json, int64_t stamp_ns) {
  if (!json.is_object() || !json.contains("status")) throw BadInput("expected an object with the key status");
  FrameEstimate frame;
  frame.stamp_ns = stamp_ns;
  frame.status = StatusOf(json.at("status"));
  if (frame.status == TrackingStatus::kTracking) {
    if (!json.contains("pose")) throw BadInput("status is tracking and there is no pose");
    frame.pose = PoseOf(json.at("pose"), "pose");
    if (json.contains("covariance")) frame.covariance = CovarianceOf(json.at("covariance"), "covariance");
    if (json.contains("own_covariance")) {
      if (!frame.covariance) throw BadInput("own_covariance is a part of covariance, which is not there");
      frame.own_covariance = CovarianceOf(json.at("own_covariance"), "own_covariance");
    }
    if (json.contains("common_errors")) {
      if (!frame.own_covariance) throw BadInput("common_errors need an own_covariance beside them");
      frame.common_errors = CommonErrorsOf(json.at("common_errors"));
    }
  } else if (json.contains("predicted")) {
    frame.predicted = PoseOf(json.at("predicted"), "predicted");
  }
  frame.restarted = json.value("restarted", false);
  frame.features = CountOf(json, "features");
  frame.inliers = CountOf(json, "inliers");
  frame.matches = CountOf(json, "matches");
  return frame;
}

struct CommandJson {
  Json operator()(FollowPath) const { return "follow_path"; }
  Json operator()(Scan) const { return "scan"; }
  Json operator()(const Velocity& v) const { return {{"velocity", {v.forward_mps, v.left_mps, v.turn_rad_s}}}; }
  Json operator()(EndWalk) const { return "end_walk"; }
  Json operator()(const GoTo& g) const { return {{"go_to", {g.x_m, g.y_m, g.heading_rad}}}; }
};

BodyCommand CommandOf(const Json& json) {
  if (json == "follow_path") return FollowPath();
  if (json == "scan") return Scan();
  if (json == "end_walk") return EndWalk();
  if (json.is_object() && json.contains("velocity")) {
    const Eigen::Vector3d v = VectorOf(json.at("velocity"), "velocity");
    return Velocity{v.x(), v.y(), v.z()};
  }
  if (json.is_object() && json.contains("go_to")) {
    const Eigen::Vector3d v = VectorOf(json.at("go_to"), "go_to");
    return GoTo{v.x(), v.y(), v.z()};
  }
  throw BadInput("command: expected follow_path, scan, end_walk, {velocity: ...} or {go_to: ...}");
}

void AddMap(const LandmarkMap& map, Json& maps) {
  Json points = Json::array();
  for (const MapPoint& point : map.points) points.push_back(JsonOf(point.p_W));
  maps.push_back({{"landmarks", points}});
}

void AddMap(const OccupancyGrid& grid, Json& maps) {
  Json rows = Json::array();
  for (int y = 0; y < grid.log_odds.rows; ++y) {
    const float* row = grid.log_odds.ptr<float>(y);
    rows.push_back(std::vector<double>(row, row + grid.log_odds.cols));
  }
  maps.push_back(
      {{"occupancy",
        {{"cell_m", grid.cell_m}, {"corner_m", {grid.corner_m.x(), grid.corner_m.y()}}, {"log_odds", rows}}}});
}

template <class Other>
void AddMap(const Other&, Json&) {}

Map LandmarksOf(const Json& json) {
  LandmarkMap map;
  for (const Json& point : json)
    map.points.push_back({int64_t(map.points.size()), VectorOf(point, "landmarks"), {}, {}});
  return map;
}

Map OccupancyOf(const Json& json) {
  OccupancyGrid grid;
  grid.cell_m = json.at("cell_m");
  const std::vector<double> corner = Numbers(json.at("corner_m"), 2, "corner_m");
  grid.corner_m = {corner[0], corner[1]};
  const Json& rows = json.at("log_odds");
  if (!(grid.cell_m > 0) || !rows.is_array() || rows.empty()) throw BadInput("occupancy: expected cells of a size");
  grid.log_odds.create(int(rows.size()), int(rows[0].size()), CV_32FC1);
  for (int y = 0; y < grid.log_odds.rows; ++y) {
    const std::vector<double> row = Numbers(rows[size_t(y)], rows[0].size(), "log_odds");
    std::copy(row.begin(), row.end(), grid.log_odds.ptr<float>(y));
  }
  return grid;
}

Map MapOf(const Json& json) {
  if (json.contains("landmarks")) return LandmarksOf(json.at("landmarks"));
  if (json.contains("occupancy")) return OccupancyOf(json.at("occupancy"));
  throw BadInput("maps: expected landmarks or occupancy");
}

/// Does `read` with the parsed line; every fault of the line is a BadInput.
template <class Read>
auto Parsed(const std::string& line, Read read) {
  try {
    return read(Json::parse(line));
  } catch (const nlohmann::json::parse_error&) {
    constexpr size_t kShown = 60;
    throw BadInput("no JSON: " + (line.size() > kShown ? line.substr(0, kShown) + "..." : line));
  } catch (const nlohmann::json::exception& e) {
    throw BadInput(e.what());
  }
}

}  // namespace

std::string StartMessage(const SystemSetup& setup, const fs::path& frames) {
  Json settings = Json::object();
  for (const auto& [key, value] : setup.settings) settings[key] = SettingJson(value);
  return Json{{"event", "start"},          {"protocol", 1},        {"seed", setup.seed},
              {"frames", frames.string()}, {"settings", settings}, {"calibration", JsonOf(setup.calibration)}}
      .dump();
}

std::string FrameMessage(const Observation& o, SharedFrames& frames) {
  size_t offset = 0;
  Json json{{"event", "frame"}, {"stamp_ns", o.stamp_ns}, {"exposure_ms", o.exposure_ms}};
  json["image"] = PutImage(o.image.pixels, frames, offset);
  if (o.right) json["right"] = PutImage(o.right->pixels, frames, offset);
  if (o.depth) json["depth"] = PutImage(o.depth->pixels, frames, offset);
  json["imu"] = Json::array();
  for (const ImuSample& s : o.imu) {
    const Eigen::Vector3d &w = s.angular_rate, &a = s.specific_force;
    json["imu"].push_back({s.stamp_ns, w.x(), w.y(), w.z(), a.x(), a.y(), a.z()});
  }
  json["joints"] = Json::array();
  for (const JointSample& s : o.joints) {
    json["joints"].push_back({{"stamp_ns", s.stamp_ns},
                              {"position", s.position},
                              {"left_contact", s.left_contact},
                              {"right_contact", s.right_contact}});
  }
  if (!o.odometry.empty()) json["odometry"] = Json::array();
  for (const OdometrySample& s : o.odometry) {
    const Eigen::Vector2d& p = s.position;
    json["odometry"].push_back({s.stamp_ns, p.x(), p.y(), s.heading});
  }
  if (o.scan) json["scan"] = {{"pan_rad", o.scan->pan_rad}, {"body_turn_rad", o.scan->body_turn_rad}};
  return json.dump();
}

std::string FinishMessage() { return Json{{"event", "finish"}}.dump(); }

std::string AnswerMessage(const FrameAnswer& answer) {
  Json json = JsonOf(answer.frame);
  if (answer.command != BodyCommand(FollowPath())) json["command"] = std::visit(CommandJson(), answer.command);
  return json.dump();
}

std::string FinalMessage(const FinalEstimate& final_estimate) {
  Json json{{"frames", Json::array()}, {"maps", Json::array()}, {"failure", final_estimate.failure}};
  for (const FrameEstimate& frame : final_estimate.frames) {
    Json entry = JsonOf(frame);
    entry["stamp_ns"] = frame.stamp_ns;
    json["frames"].push_back(entry);
  }
  for (const Map& map : final_estimate.maps) std::visit([&](const auto& kind) { AddMap(kind, json["maps"]); }, map);
  return json.dump();
}

FrameEvent EventOf(const std::string& line) {
  return Parsed(line, [](const Json& json) {
    const std::string event = json.at("event");
    if (event == "start") return FrameEvent::kStart;
    if (event == "frame") return FrameEvent::kFrame;
    if (event == "finish") return FrameEvent::kFinish;
    throw BadInput("event: expected start, frame or finish");
  });
}

SystemSetup ReadStart(const std::string& line, fs::path& frames) {
  return Parsed(line, [&](const Json& json) {
    if (json.at("protocol") != 1) throw BadInput("protocol: this program speaks 1");
    SystemSetup setup;
    setup.calibration = CalibrationOf(json.at("calibration"));
    setup.seed = WholeOf<uint64_t>(json.at("seed"), "seed");
    frames = json.at("frames").get<std::string>();
    for (const auto& [key, value] : json.at("settings").items()) {
      if (value.is_number()) {
        setup.settings[key] = OptionValue(value.get<double>());
      } else {
        setup.settings[key] = OptionValue(value.get<std::string>());
      }
    }
    return setup;
  });
}

Observation ReadFrame(const std::string& line, const SharedFrames& frames) {
  return Parsed(line, [&](const Json& json) {
    Observation o;
    o.stamp_ns = WholeOf<int64_t>(json.at("stamp_ns"), "stamp_ns");
    o.exposure_ms = json.at("exposure_ms");
    o.image = GetImage(json.at("image"), frames, o.stamp_ns);
    if (json.contains("right")) o.right = GetImage(json.at("right"), frames, o.stamp_ns);
    if (json.contains("depth")) o.depth = GetImage(json.at("depth"), frames, o.stamp_ns);
    for (const Json& s : json.at("imu")) {
      const std::vector<double> v = Numbers(s, 7, "imu");
      o.imu.push_back({WholeOf<int64_t>(s.at(0), "stamp_ns"), {v[1], v[2], v[3]}, {v[4], v[5], v[6]}});
    }
    for (const Json& s : json.at("joints")) {
      o.joints.push_back({WholeOf<int64_t>(s.at("stamp_ns"), "stamp_ns"), s.at("position"), s.at("left_contact"),
                          s.at("right_contact")});
    }
    for (const Json& s : json.value("odometry", Json::array())) {
      const std::vector<double> v = Numbers(s, 4, "odometry");
      o.odometry.push_back({WholeOf<int64_t>(s.at(0), "stamp_ns"), {v[1], v[2]}, v[3]});
    }
    if (json.contains("scan")) {
      o.scan = ScanState{json.at("scan").at("pan_rad"), json.at("scan").at("body_turn_rad")};
    }
    return o;
  });
}

std::string ReadReady(const std::string& line) {
  return Parsed(line, [](const Json& json) {
    if (json.contains("error")) return json.at("error").get<std::string>();
    if (!json.is_object() || !json.value("ready", false)) throw BadInput("expected {\"ready\": true}");
    return std::string();
  });
}

FrameAnswer ReadAnswer(const std::string& line, int64_t stamp_ns) {
  return Parsed(line, [&](const Json& json) {
    FrameAnswer answer{EstimateOf(json, stamp_ns), FollowPath()};
    if (json.contains("command")) answer.command = CommandOf(json.at("command"));
    return answer;
  });
}

FinalEstimate ReadFinal(const std::string& line) {
  return Parsed(line, [](const Json& json) {
    if (!json.is_object()) throw BadInput("expected an object");
    FinalEstimate answer;
    for (const Json& frame : json.value("frames", Json::array())) {
      answer.frames.push_back(EstimateOf(frame, WholeOf<int64_t>(frame.at("stamp_ns"), "stamp_ns")));
    }
    for (const Json& map : json.value("maps", Json::array())) answer.maps.push_back(MapOf(map));
    answer.failure = json.value("failure", "");
    return answer;
  });
}

}  // namespace gaitcam
