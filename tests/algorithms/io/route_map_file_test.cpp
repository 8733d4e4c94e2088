#include "algorithms/io/route_map_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include "algorithms/io/checksum.h"
#include "tests/algorithms/io/file_test.h"

namespace gaitcam {
namespace {

std::string BytesOf(const std::filesystem::path& file) {
  std::ostringstream out;
  out << std::ifstream(file, std::ios::binary).rdbuf();
  return out.str();
}

/// A map's bytes with one text of its head in place of another, and the lengths and the checksum that belong to them.
std::string WithNumber(const std::string& bytes, const std::string& from, const std::string& to) {
  constexpr size_t kChecksum = 64;
  const size_t begin = bytes.find('\n') + 1, line = bytes.find('\n', begin);
  const size_t head = std::stoull(bytes.substr(begin, line - begin)), at = bytes.find(from, line);
  EXPECT_NE(at, std::string::npos) << from;
  std::string rest = bytes.substr(line, bytes.size() - kChecksum - line);
  rest.replace(at - line, from.size(), to);
  const std::string checked = bytes.substr(0, begin) + std::to_string(head + to.size() - from.size()) + rest;
  return checked + Sha256(checked);
}

/// Three views with floats or bytes for descriptors, the last without any; a link along the way and a loop.
RouteMap SmallMap(int descriptor_type) {
  RouteMap map;
  map.camera = CameraModel::FromHorizontalFov(320, 240, 60);
  map.feature = "surf";
  map.X_BC = Pose(RotZ(0.1), {0.1, 0, 0.5});
  for (int n = 0; n < 3; ++n) {
    GraphNode node{1'000'000'000 + n, Pose(RotZ(0.2 * n), {0.3 * n, 0.1, 0}), 0.01 * Matrix6d::Identity()};
    map.graph.nodes.push_back(node);
  }
  map.graph.nodes.front().covariance.setZero();
  map.graph.candidates = 30;
  map.graph.links.push_back({0, 1, Pose(RotZ(0.2), {0.3, 0, 0}), Matrix6d::Identity(), false, 1, true});
  map.graph.links.push_back({0, 2, Pose(RotZ(0.4), {0.6, 0, 0}), 2 * Matrix6d::Identity(), true, 0.25, false});
  cv::RNG random(3);
  for (int v = 0; v < 2; ++v) {
    MappedView view;
    for (int i = 0; i < 5 + v; ++i) {
      view.keypoints.emplace_back(float(10 * i) + 0.25F, float(20 + v), 7.5F, 33.0F, 0.125F, 2, 1);
      view.depth_m.push_back(0.5 + i);
    }
    view.descriptors = cv::Mat(5 + v, 16, descriptor_type);
    random.fill(view.descriptors, cv::RNG::UNIFORM, descriptor_type == CV_8UC1 ? 0 : -1,
                descriptor_type == CV_8UC1 ? 256 : 1);
    map.views.push_back(view);
  }
  map.views.emplace_back();
  map.sessions = {0, 2};
  return map;
}

class RouteMapFile : public FileTest {
 protected:
  std::filesystem::path Written(int descriptor_type = CV_32FC1) const {
    WriteRouteMap(folder_ / "route.map", SmallMap(descriptor_type));
    return folder_ / "route.map";
  }
  /// What reading the file says, if these are its bytes.
  std::string ErrorWith(const std::string& bytes) const {
    const std::filesystem::path file = Write("bad.map", bytes);
    return ErrorOf([&] { ReadRouteMap(file); });
  }
};

TEST_F(RouteMapFile, KeepsAllButTheLastDigitsOfDescriptors) {
  for (const int type : {CV_32FC1, CV_8UC1}) {
    const RouteMap map = SmallMap(type), read = ReadRouteMap(Written(type));
    EXPECT_EQ(read.feature, map.feature);
    EXPECT_EQ(read.camera.fx, map.camera.fx);
    EXPECT_EQ(read.X_BC.translation, map.X_BC.translation);
    EXPECT_EQ(read.graph.candidates, 30);
    EXPECT_EQ(read.sessions, map.sessions);
    ASSERT_EQ(read.graph.nodes.size(), 3u);
    EXPECT_EQ(read.graph.nodes[2].stamp_ns, 1'000'000'002);
    EXPECT_EQ(read.graph.nodes[2].X_WC.rotation.coeffs(), map.graph.nodes[2].X_WC.rotation.coeffs());
    EXPECT_EQ(read.graph.nodes[1].covariance, map.graph.nodes[1].covariance);
    ASSERT_EQ(read.graph.links.size(), 2u);
    EXPECT_TRUE(read.graph.links[0].dead_reckoned);
    EXPECT_EQ(read.graph.links[1].trust, 0.25);
    EXPECT_EQ(read.graph.links[1].covariance, map.graph.links[1].covariance);
    ASSERT_EQ(read.views.size(), 3u);
    for (size_t v = 0; v < 2; ++v) {
      const MappedView &a = map.views[v], &b = read.views[v];
      ASSERT_EQ(a.keypoints.size(), b.keypoints.size());
      EXPECT_EQ(a.keypoints.back().pt, b.keypoints.back().pt);
      EXPECT_EQ(a.keypoints.back().octave, b.keypoints.back().octave);
      EXPECT_EQ(a.depth_m, b.depth_m);
      ASSERT_EQ(b.descriptors.type(), type);
      // Half a step of a signed byte, of numbers up to 1; bytes as they were.
      EXPECT_LE(cv::norm(a.descriptors, b.descriptors, cv::NORM_INF), type == CV_8UC1 ? 0 : 0.5 / 127 + 1e-6);
    }
    EXPECT_TRUE(read.views[2].keypoints.empty());
  }
}

TEST_F(RouteMapFile, IsTheSameBytesWhenItIsWrittenAgain) {
  const std::string first = BytesOf(Written());
  WriteRouteMap(folder_ / "again.map", ReadRouteMap(folder_ / "route.map"));
  EXPECT_EQ(BytesOf(folder_ / "again.map"), first);
}

TEST_F(RouteMapFile, ThatIsDamagedOrCutOffIsRefused) {
  const std::string whole = BytesOf(Written());
  for (size_t at = 25; at < whole.size(); at += 101) {
    std::string damaged = whole;
    damaged[at] = char(damaged[at] ^ 1);
    EXPECT_NE(ErrorWith(damaged).find("bad.map: it is damaged or cut off"), std::string::npos) << at;
    EXPECT_NE(ErrorWith(whole.substr(0, at)).find("cut off"), std::string::npos) << at;
  }
}

/// Found by fuzzing: converting a number that does not fit is undefined.
TEST_F(RouteMapFile, CountsAndStampsThatDoNotFitAreRefusedByName) {
  const std::string whole = BytesOf(Written());
  for (const auto& [key, value] : {std::pair("candidates", "30"), std::pair("from", "0"), std::pair("to", "2"),
                                   std::pair("stamp_ns", "1000000002"), std::pair("features", "6")}) {
    const std::string entry = "\"" + std::string(key) + "\":";
    for (const std::string number : {"1e21", "0.5", "-1e300", "\"1\""})
      EXPECT_NE(ErrorWith(WithNumber(whole, entry + value, entry + number))
                    .find("bad.map: " + std::string(key) + ": expected a whole number"),
                std::string::npos)
          << key << " " << number;
  }
}

TEST_F(RouteMapFile, OfAnotherKindOrVersionIsRefused) {
  std::string other = BytesOf(Written());
  other.replace(other.find(" 1\n"), 3, " 2\n");
  EXPECT_NE(ErrorWith(other).find("another version; expected 1"), std::string::npos);
  EXPECT_NE(ErrorWith("stamp_ns,x\n").find("no route map"), std::string::npos);
  EXPECT_NE(ErrorWith("").find("no route map"), std::string::npos);
  EXPECT_NE(ErrorOf([&] { ReadRouteMap(folder_ / "none.map"); }).find("cannot read this file"), std::string::npos);
  EXPECT_NE(ErrorOf([&] { ReadRouteMap(folder_); }).find("cannot read this file"), std::string::npos);
}

}  // namespace
}  // namespace gaitcam
