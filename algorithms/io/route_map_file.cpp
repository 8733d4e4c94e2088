#include "algorithms/io/route_map_file.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/core/json_whole.h"
#include "algorithms/core/se3.h"
#include "algorithms/io/checksum.h"
#include "algorithms/io/whole_file.h"

namespace gaitcam {
namespace {

using Json = nlohmann::ordered_json;
static_assert(std::endian::native == std::endian::little);  // numbers are written as they lie in memory

constexpr std::string_view kMagic = "gaitcam route map 1\n";
constexpr size_t kChecksum = 64, kKeypointNumbers = 8, kMaxFeatures = 1'000'000;

// ---------------------------------------------------------------------------------------------------------------------
// The graph and what the map is of, as JSON.

Json NumbersOf(const Pose& X) {
  const auto& t = X.translation;
  const auto& q = X.rotation;
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

/// Upper triangle, row by row.
Json NumbersOf(const Matrix6d& covariance) {
  Json numbers = Json::array();
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) numbers.push_back(covariance(row, column));
  }
  return numbers;
}

double FiniteIn(const Json& json) {
  const double value = json.get<double>();
  if (!std::isfinite(value)) throw BadInput("a number that is not finite");
  return value;
}

Pose PoseIn(const Json& json) {
  const auto at = [&](size_t i) { return FiniteIn(json.at(i)); };
  const Eigen::Quaterniond q(at(6), at(3), at(4), at(5));
  if (!(std::abs(q.norm() - 1) < 1e-6)) throw BadInput("a rotation that is none");
  return {q.normalized(), Eigen::Vector3d(at(0), at(1), at(2))};
}

Matrix6d CovarianceIn(const Json& json) {
  Matrix6d covariance;
  size_t i = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column)
      covariance(row, column) = covariance(column, row) = FiniteIn(json.at(i++));
  }
  return covariance;
}

Json CameraJson(const CameraModel& c) {
  return {{"size_px", {c.width_px, c.height_px}},
          {"f", {c.fx, c.fy}},
          {"c", {c.cx, c.cy}},
          {"k1_k2_p1_p2_k3", {c.k1, c.k2, c.p1, c.p2, c.k3}}};
}

CameraModel CameraIn(const Json& json) {
  CameraModel c;
  const Json& size = json.at("size_px");
  c.width_px = WholeOf<int>(size.at(0), "size_px"), c.height_px = WholeOf<int>(size.at(1), "size_px");
  c.fx = FiniteIn(json.at("f").at(0)), c.fy = FiniteIn(json.at("f").at(1));
  c.cx = FiniteIn(json.at("c").at(0)), c.cy = FiniteIn(json.at("c").at(1));
  const Json& k = json.at("k1_k2_p1_p2_k3");
  double* const coefficients[] = {&c.k1, &c.k2, &c.p1, &c.p2, &c.k3};
  for (size_t i = 0; i < 5; ++i) *coefficients[i] = FiniteIn(k.at(i));
  c.Check();
  return c;
}

Json LinkJson(const GraphLink& link) {
  return {{"from", link.from},
          {"to", link.to},
          {"X_FT", NumbersOf(link.X_FT)},
          {"covariance", NumbersOf(link.covariance)},
          {"loop", link.loop},
          {"trust", link.trust},
          {"dead_reckoned", link.dead_reckoned}};
}

GraphLink LinkIn(const Json& json, size_t nodes) {
  GraphLink link;
  link.from = WholeOf<int>(json.at("from"), "from"), link.to = WholeOf<int>(json.at("to"), "to");
  if (link.from < 0 || link.to < 0 || size_t(link.from) >= nodes || size_t(link.to) >= nodes)
    throw BadInput("a link with a node that is not there");
  link.X_FT = PoseIn(json.at("X_FT"));
  link.covariance = CovarianceIn(json.at("covariance"));
  link.loop = json.at("loop");
  link.trust = FiniteIn(json.at("trust"));
  link.dead_reckoned = json.at("dead_reckoned");
  return link;
}

PoseGraph GraphIn(const Json& json) {
  PoseGraph graph;
  graph.candidates = WholeOf<int>(json.at("candidates"), "candidates");
  for (const Json& node : json.at("nodes")) {
    graph.nodes.push_back({WholeOf<int64_t>(node.at("stamp_ns"), "stamp_ns"), PoseIn(node.at("X_WC")),
                           CovarianceIn(node.at("covariance"))});
  }
  for (const Json& link : json.at("links")) graph.links.push_back(LinkIn(link, graph.nodes.size()));
  return graph;
}

std::vector<int> SessionsIn(const Json& json, size_t nodes) {
  if (!json.is_array()) throw BadInput("sessions: expected a list");
  std::vector<int> sessions;
  for (const Json& begin : json) sessions.push_back(WholeOf<int>(begin, "sessions"));
  const bool rise = std::adjacent_find(sessions.begin(), sessions.end(), std::greater_equal<>()) == sessions.end();
  if (sessions.empty() || sessions.front() != 0 || !rise || (nodes > 0 && size_t(sessions.back()) >= nodes))
    throw BadInput("sessions that begin nowhere");
  return sessions;
}

// ---------------------------------------------------------------------------------------------------------------------
// Views, as bytes.

template <class Number>
void Append(std::string& bytes, Number number) {
  static_assert(sizeof(Number) == 4);
  bytes.append(reinterpret_cast<const char*>(&number), 4);
}

/// The bytes that follow, from front to back.
class Bytes {
 public:
  explicit Bytes(std::string_view left) : left_(left) {}
  std::string_view Take(size_t count) {
    if (left_.size() < count) throw BadInput("it is cut off");
    const std::string_view taken = left_.substr(0, count);
    left_.remove_prefix(count);
    return taken;
  }
  template <class Number>
  Number Take() {
    Number number;
    std::memcpy(&number, Take(sizeof(Number)).data(), sizeof(Number));
    return number;
  }
  float TakeFinite() {
    const float number = Take<float>();
    if (!std::isfinite(number)) throw BadInput("a number that is not finite");
    return number;
  }
  bool empty() const { return left_.empty(); }

 private:
  std::string_view left_;
};

void AppendDescriptor(std::string& bytes, const cv::Mat& row) {
  if (row.type() == CV_8UC1) {
    bytes.append(row.ptr<char>(), size_t(row.cols));
    return;
  }
  const float scale = float(cv::norm(row, cv::NORM_INF));
  Append(bytes, scale);
  for (int i = 0; i < row.cols; ++i)
    bytes.push_back(char(scale > 0 ? std::lround(127 * double(row.at<float>(i)) / double(scale)) : 0));
}

void TakeDescriptor(Bytes& bytes, cv::Mat row) {
  if (row.type() == CV_8UC1) {
    std::memcpy(row.ptr(), bytes.Take(size_t(row.cols)).data(), size_t(row.cols));
    return;
  }
  const float scale = bytes.TakeFinite();
  const std::string_view numbers = bytes.Take(size_t(row.cols));
  for (int i = 0; i < row.cols; ++i)
    row.at<float>(i) = scale * float(static_cast<signed char>(numbers[size_t(i)])) / 127;
}

void AppendView(std::string& bytes, const MappedView& view) {
  for (size_t i = 0; i < view.keypoints.size(); ++i) {
    const cv::KeyPoint& k = view.keypoints[i];
    for (const float number : {k.pt.x, k.pt.y, k.size, k.angle, k.response}) Append(bytes, number);
    Append(bytes, int32_t(k.octave));
    Append(bytes, int32_t(k.class_id));
    Append(bytes, float(view.depth_m[i]));
  }
  for (int i = 0; i < view.descriptors.rows; ++i) AppendDescriptor(bytes, view.descriptors.row(i));
}

/// How many features a view has, and of what kind its descriptors are.
Json SizeJson(const MappedView& view) {
  GAITCAM_ASSERT(view.depth_m.size() == view.keypoints.size() && view.descriptors.rows == int(view.keypoints.size()));
  if (view.keypoints.empty()) return {{"features", 0}};
  return {{"features", view.keypoints.size()},
          {"numbers", view.descriptors.cols},
          {"floats", view.descriptors.type() == CV_32FC1}};
}

MappedView TakeView(const Json& size, Bytes& bytes) {
  constexpr int kMaxNumbers = 4096;
  MappedView view;
  const auto features = WholeOf<size_t>(size.at("features"), "features");
  if (features == 0) return view;
  const int numbers = WholeOf<int>(size.at("numbers"), "numbers");
  if (features > kMaxFeatures || numbers < 1 || numbers > kMaxNumbers) throw BadInput("a view of an impossible size");
  view.keypoints.resize(features);
  view.depth_m.resize(features);
  for (size_t i = 0; i < features; ++i) {
    cv::KeyPoint& k = view.keypoints[i];
    for (float* number : {&k.pt.x, &k.pt.y, &k.size, &k.angle, &k.response}) *number = bytes.TakeFinite();
    k.octave = bytes.Take<int32_t>();
    k.class_id = bytes.Take<int32_t>();
    view.depth_m[i] = double(bytes.TakeFinite());
    if (!(view.depth_m[i] > 0)) throw BadInput("a depth that is not positive");
  }
  view.descriptors.create(int(features), numbers, size.at("floats").get<bool>() ? CV_32FC1 : CV_8UC1);
  for (int i = 0; i < int(features); ++i) TakeDescriptor(bytes, view.descriptors.row(i));
  return view;
}

/// What lies between the first line and the checksum. @throws BadInput without the file's name.
std::string_view Checked(std::string_view bytes) {
  constexpr std::string_view kAnyVersion = "gaitcam route map ";
  if (!bytes.starts_with(kAnyVersion)) throw BadInput("no route map; one begins with \"gaitcam route map 1\"");
  if (!bytes.starts_with(kMagic)) throw BadInput("a route map of another version; expected 1");
  if (bytes.size() < kMagic.size() + kChecksum) throw BadInput("it is cut off");
  const std::string_view checked = bytes.substr(0, bytes.size() - kChecksum);
  if (Sha256(checked) != bytes.substr(checked.size()))
    throw BadInput("it is damaged or cut off: its checksum is wrong");
  return checked.substr(kMagic.size());
}

RouteMap MapIn(std::string_view content) {
  const size_t line = content.find('\n');
  if (line == std::string_view::npos || line > 18) throw BadInput("it does not say how long its head is");
  const size_t head = std::stoull(std::string(content.substr(0, line)));
  Bytes bytes(content.substr(line + 1));
  const Json json = Json::parse(bytes.Take(head));
  RouteMap map;
  map.feature = json.at("feature");
  map.camera = CameraIn(json.at("camera"));
  map.X_BC = PoseIn(json.at("X_BC"));
  map.graph = GraphIn(json);
  if (json.at("views").size() != map.graph.nodes.size()) throw BadInput("it has not as many views as nodes");
  map.sessions = SessionsIn(json.at("sessions"), map.graph.nodes.size());
  for (const Json& size : json.at("views")) map.views.push_back(TakeView(size, bytes));
  if (!bytes.empty()) throw BadInput("it is longer than its views");
  return map;
}

}  // namespace

void WriteRouteMap(const std::filesystem::path& file, const RouteMap& map) {
  GAITCAM_ASSERT(map.views.size() == map.graph.nodes.size());
  Json json{{"feature", map.feature},      {"camera", CameraJson(map.camera)},
            {"X_BC", NumbersOf(map.X_BC)}, {"candidates", map.graph.candidates},
            {"sessions", map.sessions},    {"nodes", Json::array()},
            {"links", Json::array()},      {"views", Json::array()}};
  std::string data;
  for (const GraphNode& node : map.graph.nodes)
    json["nodes"].push_back(
        {{"stamp_ns", node.stamp_ns}, {"X_WC", NumbersOf(node.X_WC)}, {"covariance", NumbersOf(node.covariance)}});
  for (const GraphLink& link : map.graph.links) json["links"].push_back(LinkJson(link));
  for (const MappedView& view : map.views) {
    json["views"].push_back(SizeJson(view));
    AppendView(data, view);
  }
  const std::string head = json.dump();
  const std::string content = std::string(kMagic) + std::to_string(head.size()) + "\n" + head + data;
  WriteWholeFile(file, content + Sha256(content));
}

RouteMap ReadRouteMap(const std::filesystem::path& file) {
  const std::string bytes = FileContent(file);
  try {
    return MapIn(Checked(bytes));
  } catch (const BadInput& e) {
    throw BadInput(file.string() + ": " + e.what());
  } catch (const std::exception& e) {  // of JSON, of a number
    throw BadInput(file.string() + ": it is no route map: " + e.what());
  }
}

}  // namespace gaitcam
