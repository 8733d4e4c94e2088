#include "models/code/scenes/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

/// What a file with `text` describes; the pictures that it names lie in `folder`.
Scene SceneOfText(const std::string& text, const TemporaryFolder& folder = {}) {
  return ReadScene(folder.Write("scene_test.yaml", text).string(), kModels);
}

/// A scene with a small floor and `more`.
Scene SmallScene(const std::string& more, const TemporaryFolder& folder = {}) {
  return SceneOfText(
      "floor: {extent: [[-2, -1], [2, 1]], texture: {kind: carpet, size_m: [1, 1], px_per_m: 128}}\n" + more, folder);
}

const SceneBox& FindBox(const Scene& scene, const std::string& name) {
  for (const SceneBox& box : scene.boxes) {
    if (box.name == name) return box;
  }
  throw std::runtime_error("no box " + name);
}

std::string SceneError(const std::string& text) {
  try {
    SceneOfText(text);
  } catch (const BadInput& e) {
    const std::string what = e.what();  // without the folder
    return what.substr(std::min(what.size(), what.find("scene_test.yaml")));
  }
  return "";
}

/// What a robot of 0.6 m height could touch.
class Obstacles {
 public:
  explicit Obstacles(const Scene& scene) {
    for (const SceneBox& box : scene.boxes) {
      if (box.collides) boxes_.emplace_back(box.X_WB.Inverse(), box.size / 2);
    }
  }

  /// Whether something stands within `reach` of a point of the floor.
  bool Block(const Eigen::Vector2d& at, double reach) const {
    for (const auto& [X_BW, half] : boxes_) {
      for (double z = 0.01; z < 0.6; z += 0.05) {
        const Eigen::Vector3d p = X_BW * Eigen::Vector3d(at.x(), at.y(), z);
        if ((p.cwiseAbs() - half).cwiseMax(0.0).norm() < reach) return true;
      }
    }
    return false;
  }

 private:
  std::vector<std::pair<Pose, Eigen::Vector3d>> boxes_;
};

TEST(Scene, AllShippedScenesAreListed) {
  EXPECT_THAT(ListScenes(kModels),
              testing::ElementsAre("cafeteria", "corridor", "floor_trials", "hall", "lab", "lab_dim", "lab_plain",
                                   "plain", "robocup_field", "station", "station_empty", "station_evening",
                                   "station_later", "street", "street_empty", "tabletop", "twin_corridors"));
  EXPECT_TRUE(ListScenes("/no/such/folder").empty());
}

TEST(Scene, ShippedScenesAreReadyWithinTwoSecondsOfOneCoreAndFitTheRenderer) {
  for (const std::string& name : ListScenes(kModels)) {
    const std::clock_t before = std::clock();
    const Scene scene = ReadScene(name, kModels);
    const double cpu_s = double(std::clock() - before) / CLOCKS_PER_SEC;
    RecordProperty(name + "_cpu_ms", int(1000 * cpu_s));
#if defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__)
    EXPECT_LT(cpu_s, 2.0) << name;  // 0.05 to 0.9 s when measured
#endif
    EXPECT_EQ(scene.name, name);
    EXPECT_LE(scene.textures.size(), 99u) << name;  // what MuJoCo can draw beside the sky
    EXPECT_LE(scene.boxes.size(), 150u) << name;    // each costs time in software rendering
    size_t bytes = 0;
    std::set<std::string> names;
    for (const SceneTexture& texture : scene.textures) {
      bytes += size_t(texture.size_px.area()) * 3;
      EXPECT_TRUE(names.insert(texture.name).second) << texture.name;
    }
    EXPECT_LT(bytes, 100u << 20) << name;
    for (const SceneBox& box : scene.boxes) {
      EXPECT_GT(box.size.minCoeff(), 0) << name << " " << box.name;
      EXPECT_LT(box.texture, int(scene.textures.size())) << name << " " << box.name;
      EXPECT_NEAR(box.X_WB.rotation.norm(), 1, 1e-12);
    }
  }
}

TEST(Scene, ReadingTwiceGivesTheSameBits) {
  const Scene a = ReadScene("tabletop", kModels), b = ReadScene("tabletop", kModels);
  ASSERT_EQ(a.textures.size(), b.textures.size());
  for (size_t i = 0; i < a.textures.size(); ++i) {
    const cv::Mat picture = a.textures[i].Bgr();
    EXPECT_EQ(picture.size(), a.textures[i].size_px) << a.textures[i].name;
    EXPECT_EQ(cv::norm(picture, a.textures[i].Bgr(), cv::NORM_INF), 0) << a.textures[i].name;
    EXPECT_EQ(cv::norm(picture, b.textures[i].Bgr(), cv::NORM_INF), 0) << a.textures[i].name;
  }
  ASSERT_EQ(a.boxes.size(), b.boxes.size());
  for (size_t i = 0; i < a.boxes.size(); ++i) EXPECT_EQ(a.boxes[i].X_WB.Matrix(), b.boxes[i].X_WB.Matrix());
}

TEST(Scene, TheSeedChangesTexturesAndRandomPlaces) {
  const std::string scatter = "walls: [{points: [[-2, -1], [2, -1]], posters: {count: 3, top_m: 2}}]\n";
  const Scene a = SmallScene("seed: 1\n" + scatter), b = SmallScene("seed: 2\n" + scatter);
  EXPECT_GT(cv::norm(a.textures[0].Bgr(), b.textures[0].Bgr(), cv::NORM_INF), 0);
  EXPECT_GT((FindBox(a, "poster0").X_WB.translation - FindBox(b, "poster0").X_WB.translation).norm(), 0.01);
}

TEST(Scene, PathsOfTheShippedScenesAreFree) {
  constexpr double kReach = 0.25;  // half the width of the widest robot, and room to sway
  const Scene lab = ReadScene("lab", kModels);
  const Obstacles in_lab(lab);
  for (double angle = 0; angle < 2 * M_PI; angle += 0.05) {
    for (const double radius : {2.0, 2.25}) {  // circles of 4 m and 4.5 m
      const double center = lab.start.y() + radius;
      const Eigen::Vector2d at(lab.start.x() + radius * std::sin(angle), center - radius * std::cos(angle));
      EXPECT_FALSE(in_lab.Block(at, kReach)) << at.transpose();
    }
  }
  for (double s = -2.5; s <= 2.5; s += 0.05) {  // the square of 5 m
    for (const Eigen::Vector2d& at : {Eigen::Vector2d(s, 2.5), {s, -2.5}, {2.5, s}, {-2.5, s}}) {
      EXPECT_FALSE(in_lab.Block(at, 0.2)) << at.transpose();
    }
  }
  const Scene corridor = ReadScene("corridor", kModels);
  const Obstacles in_corridor(corridor);
  EXPECT_EQ(corridor.start, Eigen::Vector3d(-6.5, -3.5, 0));
  for (double s = 0; s <= 13; s += 0.05) {
    for (const double y : {-3.5, 3.5}) EXPECT_FALSE(in_corridor.Block({s - 6.5, y}, 0.45)) << s;
    for (const double x : {-6.5, 6.5}) EXPECT_FALSE(in_corridor.Block({x, 7 * s / 13 - 3.5}, 0.45)) << s;
  }
  const Scene hall = ReadScene("hall", kModels), field = ReadScene("robocup_field", kModels);
  const Obstacles in_hall(hall), in_field(field);
  for (double s = 0; s <= 18; s += 0.05) EXPECT_FALSE(in_hall.Block({hall.start.x() + s, hall.start.y()}, 0.6)) << s;
  for (double s = 0; s <= 4.4; s += 0.05) EXPECT_FALSE(in_field.Block({field.start.x() + s, 0}, kReach)) << s;
  const Scene table = ReadScene("tabletop", kModels), plain = ReadScene("plain", kModels);
  const Obstacles in_table(table), in_plain(plain);
  for (double s = 0; s <= 2; s += 0.05) EXPECT_FALSE(in_table.Block({table.start.x() + s, table.start.y()}, kReach));
  for (double angle = 0; angle < 2 * M_PI; angle += 0.05) {
    EXPECT_FALSE(in_plain.Block({2.25 * std::sin(angle), -2.25 * std::cos(angle)}, kReach)) << angle;
  }
}

/// Where a robot goes by the corners of its path, every tenth of a metre.
std::vector<Eigen::Vector2d> Along(const Eigen::Vector2d& start, const std::vector<Eigen::Vector2d>& corners) {
  std::vector<Eigen::Vector2d> points;
  Eigen::Vector2d from{0, 0};
  for (const Eigen::Vector2d& to : corners) {
    for (double s = 0; s <= 1; s += 0.1 / (to - from).norm()) points.push_back(start + from + s * (to - from));
    from = to;
  }
  return points;
}

/// Nobody walks through what stands there; a person's shoulders are 0.45 m wide.
void ExpectPeopleWalkFreely(const Scene& scene) {
  const Obstacles obstacles(scene);
  for (const PersonOptions& person : scene.people) {
    for (size_t i = 0; i < person.path.size(); ++i) {
      const Eigen::Vector2d& from = person.path[i == 0 ? 0 : i - 1];
      for (double part = 0; part <= 1; part += 0.005) {
        EXPECT_FALSE(obstacles.Block(from + part * (person.path[i] - from), 0.3))
            << scene.name << " " << person.name << " " << person.seed;
      }
    }
  }
}

TEST(Scene, TheStreetIsFreeAndItsPeopleWalkThroughNoThing) {
  const Scene street = ReadScene("street", kModels), empty = ReadScene("street_empty", kModels);
  const Obstacles obstacles(street);
  for (const Eigen::Vector2d& at : Along(street.start.head<2>(), {{50, 0}, {50, 35}, {0, 35}, {0, 0}}))
    EXPECT_FALSE(obstacles.Block(at, 0.9)) << at.transpose();  // a person, and room to sway and to cut corners
  EXPECT_GE(street.people.size(), 10u);
  ExpectPeopleWalkFreely(street);
  EXPECT_TRUE(empty.people.empty());
  EXPECT_EQ(empty.boxes.size(), street.boxes.size());
}

TEST(Scene, TheStationsFirstAndThirdRouteLookAlikeButForSomePosters) {
  const Scene station = ReadScene("station", kModels);
  const Obstacles obstacles(station);
  for (const Eigen::Vector2d& at : Along(station.start.head<2>(), {{30, 0}, {30, 20}, {0, 20}}))
    EXPECT_FALSE(obstacles.Block(at, 0.9)) << at.transpose();
  int same = 0, other = 0;
  for (const SceneBox& box : station.boxes) {
    const Eigen::Vector3d& p = box.X_WB.translation;
    if (box.name.rfind("poster", 0) != 0 || p.y() > 0 || p.x() < -16.6 || p.x() > 9.9) continue;  // of route 1
    for (const SceneBox& twin : station.boxes) {
      const Eigen::Vector3d apart = twin.X_WB.translation - Eigen::Vector3d(-p.x(), -p.y(), p.z());
      if (twin.name.rfind("poster", 0) == 0 && apart.norm() < 0.01) ++(twin.texture == box.texture ? same : other);
    }
  }
  EXPECT_GE(same, 8);
  EXPECT_GE(other, 3);
  for (const char* name : {"station", "station_later", "station_evening"}) {
    const Scene scene = ReadScene(name, kModels);
    EXPECT_GE(scene.people.size(), 25u) << name;
    EXPECT_EQ(scene.boxes.size(), station.boxes.size()) << name;
    ExpectPeopleWalkFreely(scene);
  }
  EXPECT_NE(ReadScene("station_later", kModels).people[0].path, station.people[0].path);
  EXPECT_LT(ReadScene("station_evening", kModels).light, station.light);
}

TEST(Scene, PostersShowTheirPictureWhereTheyFace) {
  const Scene scene = SmallScene("posters: [{at: [1, 0.5, 1.2], facing_deg: 180, size: [0.4, 0.6], texture: pink}]\n");
  const SceneBox& poster = FindBox(scene, "poster0");
  EXPECT_TRUE(poster.X_WB.R().col(2).isApprox(Eigen::Vector3d(-1, 0, 0), 1e-12));  // out of the picture
  EXPECT_TRUE(poster.X_WB.R().col(1).isApprox(Eigen::Vector3d(0, 0, 1), 1e-12));   // its top is up
  // Who looks along +x has +y on the left, so the picture's right is -y.
  EXPECT_TRUE(poster.X_WB.R().col(0).isApprox(Eigen::Vector3d(0, -1, 0), 1e-12));
  EXPECT_EQ(poster.size.head<2>(), Eigen::Vector2d(0.4, 0.6));
  EXPECT_NEAR((poster.X_WB * Eigen::Vector3d(0, 0, -poster.size.z() / 2) - Eigen::Vector3d(1, 0.5, 1.2)).norm(), 0,
              1e-12);
  const cv::Mat picture = scene.textures[poster.texture].Bgr();
  EXPECT_NEAR(double(picture.cols) / picture.rows, 0.4 / 0.6, 0.06);  // sizes are rounded up to 16 px
}

TEST(Scene, PrintsLieOnTheirBackAndHinderNobody) {
  const Scene scene =
      SmallScene("posters: [{at: [0, 0, 0.3], facing_deg: 90, lies: true, size: [0.4, 0.6], texture: pink}]\n");
  const SceneBox& print = FindBox(scene, "poster0");
  EXPECT_TRUE(print.X_WB.R().col(2).isApprox(Eigen::Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE(print.X_WB.R().col(1).isApprox(Eigen::Vector3d(0, 1, 0), 1e-12));  // its upper edge points there
  EXPECT_FALSE(print.collides);
}

TEST(Scene, WallsHaveTheirSurfaceOnTheLineAndNeverTwoFacesInOnePlane) {
  const std::string points = "closed: true, height_m: 2, thickness_m: 0.1, points: ";
  const Scene room = SmallScene("walls: [{" + points + "[[-2, -1], [2, -1], [2, 1], [-2, 1]]}]\n");
  const Scene block = SmallScene("walls: [{" + points + "[[-2, -1], [-2, 1], [2, 1], [2, -1]]}]\n");
  for (const Scene* scene : {&room, &block}) {
    ASSERT_EQ(scene->boxes.size(), 4u);
    for (const SceneBox& wall : scene->boxes) {
      const Eigen::Vector3d normal = wall.X_WB.R().col(2);
      const Eigen::Vector3d surface = wall.X_WB.translation + wall.size.z() / 2 * normal;
      EXPECT_NEAR(std::abs(surface.dot(normal)), std::abs(normal.x()) > 0.5 ? 2.0 : 1.0, 1e-12);
      // Inside the room, outside the block.
      EXPECT_EQ(normal.dot(wall.X_WB.translation) < 0, scene == &room);
      EXPECT_NEAR(wall.X_WB.translation.z(), 1, 1e-12);
    }
    for (const SceneBox& a : scene->boxes) {  // the ends of a wall stay off its neighbours' surfaces
      for (const SceneBox& b : scene->boxes) {
        if (&a == &b || std::abs(a.X_WB.R().col(2).dot(b.X_WB.R().col(2))) > 0.5) continue;
        const Eigen::Vector3d n = b.X_WB.R().col(2);
        const double front = (b.X_WB.translation + b.size.z() / 2 * n).dot(n);
        for (const double end : {-0.5, 0.5}) {
          EXPECT_GT(std::abs((a.X_WB * Eigen::Vector3d(end * a.size.x(), 0, 0)).dot(n) - front), 5e-4);
        }
      }
    }
  }
}

TEST(Scene, ScatteredPostersHangOnTheWallWithoutOverlap) {
  const Scene scene = SmallScene(
      "walls: [{points: [[-2, 1], [-2, -1], [2, -1]], height_m: 2.4, posters: {count: 10, textures: [pink], width_m: "
      "[0.2, 0.5]}}]\n"
      "posters: [{at: [0, -1, 1], facing_deg: 90, size: [1, 1], texture: pink}]\n");
  std::vector<const SceneBox*> posters;
  for (const SceneBox& box : scene.boxes) {
    if (box.name.rfind("poster", 0) == 0) posters.push_back(&box);
  }
  ASSERT_EQ(posters.size(), 11u);
  for (const SceneBox* a : posters) {
    const Eigen::Vector3d back = a->X_WB * Eigen::Vector3d(0, 0, -a->size.z() / 2);
    EXPECT_NEAR(std::min(std::abs(back.x() + 2), std::abs(back.y() + 1)), 0, 1e-9);
    for (const SceneBox* b : posters) {
      if (a == b || a->X_WB.R().col(2).dot(b->X_WB.R().col(2)) < 0.5) continue;
      const Eigen::Vector3d apart = (a->X_WB.Inverse() * b->X_WB.translation).cwiseAbs();
      EXPECT_TRUE(apart.x() >= (a->size.x() + b->size.x()) / 2 || apart.y() >= (a->size.y() + b->size.y()) / 2)
          << a->name << " " << b->name;
    }
  }
}

TEST(Scene, FurnitureStandsOnItsFootAndTurnsWithItsYaw) {
  const Scene scene =
      SmallScene("furniture: [{kind: table, at: [1, 0.5], base_m: 0.1, yaw_deg: 90, size: [0.6, 1, 0.7]}]\n");
  Eigen::AlignedBox3d bounds;
  for (const SceneBox& box : scene.boxes) {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      bounds.extend(box.X_WB * Eigen::Vector3d(0.5 * sign.cwiseProduct(box.size)));
    }
  }
  EXPECT_TRUE(bounds.min().isApprox(Eigen::Vector3d(0.5, 0.2, 0.1), 1e-9)) << bounds.min().transpose();
  EXPECT_TRUE(bounds.max().isApprox(Eigen::Vector3d(1.5, 0.8, 0.8), 1e-9)) << bounds.max().transpose();
}

TEST(Scene, EqualTexturesAreMadeOnce) {
  const Scene scene = SmallScene(
      "textures: {oak: {kind: wood, px_per_m: 64}}\n"
      "boxes: [{texture: oak}, {texture: oak, at: [1, 0, 0]}, {texture: {kind: wood, px_per_m: 64}}, {texture: "
      "none}]\n");
  ASSERT_EQ(scene.boxes.size(), 4u);
  EXPECT_EQ(scene.boxes[0].texture, scene.boxes[1].texture);
  EXPECT_EQ(scene.boxes[0].texture, scene.boxes[2].texture);
  EXPECT_EQ(scene.boxes[3].texture, -1);
  EXPECT_EQ(scene.textures.size(), 2u);  // and the floor's
}

TEST(Scene, TheFloorImageIsTheTextureAtItsOwnScale) {
  const Scene scene = SmallScene("");
  const cv::Mat floor = FloorImage(scene, 128);  // the texture's own resolution: every pixel is a texel
  ASSERT_EQ(floor.size(), cv::Size(4 * 128, 2 * 128));
  const cv::Mat texture = scene.textures[scene.floor_texture].Bgr();
  ASSERT_EQ(texture.size(), cv::Size(128, 128));
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 4; ++i) {  // whole repeats from the lower left corner
      const cv::Mat repeat = floor(cv::Rect(128 * i, 128 * j, 128, 128));
      EXPECT_EQ(cv::countNonZero(cv::Mat(repeat != texture).reshape(1)), 0) << i << " " << j;
    }
  }
}

TEST(Scene, TheFloorImageShowsWhatLiesAtAPoint) {
  // A picture with one bright quadrant: right and up. Repeats of 1.5 m from (-2, -1).
  const TemporaryFolder folder;
  cv::Mat picture(60, 60, CV_8UC3, cv::Scalar(20, 20, 20));
  picture(cv::Rect(30, 0, 30, 30)).setTo(cv::Scalar(220, 220, 220));
  cv::imwrite((folder.path() / "quadrant.png").string(), picture);
  const Scene scene = SceneOfText(
      "floor: {extent: [[-2, -1], [2, 1]], texture: {kind: image, file: quadrant.png, "
      "size_m: [1.5, 1.5]}}\n",
      folder);
  for (const double scale : {20.0, 40.0, 173.0, 400.0}) {
    const cv::Mat floor = FloorImage(scene, scale);
    ASSERT_EQ(floor.size(), cv::Size(int(std::lround(4 * scale)), int(std::lround(2 * scale))));
    for (double x = -1.95; x < 2; x += 0.1) {
      for (double y = -0.95; y < 1; y += 0.1) {
        const double u = std::fmod(x + 2, 1.5), v = std::fmod(y + 1, 1.5);
        if (std::min({std::abs(u - 0.75), std::abs(v - 0.75), u, v, 1.5 - u, 1.5 - v}) < 0.06) continue;  // at an edge
        const cv::Vec3b seen = floor.at<cv::Vec3b>(int((1 - y) * scale), int((x + 2) * scale));
        EXPECT_EQ(seen[0] > 120, u > 0.75 && v > 0.75) << x << " " << y << " at " << scale;
      }
    }
  }
  EXPECT_THROW(FloorImage(scene, 0), BadOption);
}

TEST(Scene, ACoarseFloorImageIsAMean) {
  const Scene scene = SmallScene("");
  cv::Mat mean;
  cv::resize(FloorImage(scene, 128), mean, {}, 1.0 / 8, 1.0 / 8, cv::INTER_AREA);
  cv::Mat diff;
  cv::absdiff(FloorImage(scene, 16), mean, diff);
  EXPECT_LE(cv::norm(diff, cv::NORM_INF), 1);  // rounding
}

TEST(Scene, TheFloorImageShowsThePrintsThatLieOnIt) {
  // A picture with one bright quadrant, right and up, turned by a quarter: up becomes -x, right becomes +y.
  const TemporaryFolder folder;
  cv::Mat picture(60, 60, CV_8UC3, cv::Scalar(20, 20, 20));
  picture(cv::Rect(30, 0, 30, 30)).setTo(cv::Scalar(220, 220, 220));
  cv::imwrite((folder.path() / "quadrant.png").string(), picture);
  const Scene scene = SmallScene(
      "textures: {quadrant: {kind: image, file: quadrant.png}}\n"
      "posters: [{at: [0.5, 0.25, 0], lies: true, facing_deg: 180, size: [0.4, 0.6], thickness_m: 0.001, texture: "
      "quadrant}]\n"
      "boxes:\n"
      "  - {at: [-1, 0, 0.001], size: [0.2, 1, 0.002], yaw_deg: 90, rgb: [1, 0, 0], collides: false}\n"
      "  - {at: [-1, -0.8, 0.1], size: [0.2, 0.2, 0.2], rgb: [0, 1, 0]}\n",
      folder);
  const Scene bare = SmallScene("");
  for (const double scale : {50.0, 128.0, 400.0}) {
    const cv::Mat floor = FloorImage(scene, scale), without = FloorImage(bare, scale);
    const auto at = [&](const cv::Mat& image, double x, double y) {
      return image.at<cv::Vec3b>(int((1 - y) * scale), int((x + 2) * scale));
    };
    for (const double a : {-0.1, 0.1}) {
      for (const double b : {-0.15, 0.15}) {  // a along the picture's right, b along its up
        const cv::Vec3b seen = at(floor, 0.5 - b, 0.25 + a);
        EXPECT_EQ(seen[0], a > 0 && b > 0 ? 220 : 20) << a << " " << b << " at " << scale;
      }
    }
    for (const double side : {-0.4, 0.4}) {
      EXPECT_EQ(at(floor, -1 + side, 0), cv::Vec3b(0, 0, 255));                           // a line on the floor
      EXPECT_EQ(at(floor, -1, side), at(without, -1, side));                              // beside it
      EXPECT_EQ(at(floor, 0.5, 0.25 + side * 0.7), at(without, 0.5, 0.25 + side * 0.7));  // beside the print
    }
    EXPECT_EQ(at(floor, -1, -0.8), at(without, -1, -0.8));  // what stands on the floor is not of it
  }
}

TEST(Scene, ErrorsPointIntoTheFile) {
  const std::string floor = "floor: {texture: {kind: carpet, px_per_m: 32}}\n";
  EXPECT_EQ(SceneError(floor + "wals: []\n"), "scene_test.yaml:2:1: wals: unknown key; did you mean walls?");
  EXPECT_EQ(SceneError("seed: 1\n"), "scene_test.yaml:1:1: texture: missing; a floor needs one");
  EXPECT_EQ(SceneError("floor: {texture: carpt}\n"),
            "scene_test.yaml:1:18: floor.texture: \"carpt\" is no texture; did you mean carpet?");
  EXPECT_THAT(
      SceneError("floor: {texture: {kind: carpt}}\n"),
      testing::StartsWith("scene_test.yaml:1:25: floor.texture.kind: \"carpt\" is not permitted; expected one of"));
  EXPECT_EQ(SceneError("floor: {extent: [[1, 0], [0, 1]], texture: carpet}\n"),
            "scene_test.yaml:1:17: floor.extent: expected [[min x, min y], [max x, max y]] with max above min");
  EXPECT_EQ(SceneError(floor + "boxes:\n  - {size: [1, 0, 1]}\n"),
            "scene_test.yaml:3:12: boxes[0].size: expected lengths above 0");
  EXPECT_EQ(SceneError(floor + "boxes:\n  - {rgb: [1, 0, 2]}\n"),
            "scene_test.yaml:3:11: boxes[0].rgb: expected three numbers from 0 to 1");
  EXPECT_THAT(SceneError(floor + "furniture: [{kind: tabel}]\n"),
              testing::HasSubstr("scene_test.yaml:2:20: furniture[0].kind: \"tabel\" is not permitted"));
  EXPECT_EQ(SceneError(floor + "posters: [{at: [0, 0, 1]}]\n"),
            "scene_test.yaml:2:11: posters[0]: texture: missing; a poster needs one");
  EXPECT_EQ(SceneError(floor + "walls: [{points: [[0, 0]]}]\n"),
            "scene_test.yaml:2:9: walls[0]: points: expected at least two corners");
  EXPECT_EQ(SceneError(floor + "walls: [{points: [[0, 0], [0, 0]]}]\n"),
            "scene_test.yaml:2:18: walls[0].points: two successive corners are the same");
  EXPECT_THAT(SceneError(floor + "walls: [{points: [[0, 0], [1, 0]], posters: {count: 50}}]\n"),
              testing::HasSubstr("posters; expected fewer or smaller ones"));
  EXPECT_EQ(SceneError(floor + "lights: [{direction: [0, 0, 0]}]\n"),
            "scene_test.yaml:2:10: lights[0]: direction: expected a vector of length above 0");
  EXPECT_THAT(SceneError(floor + "textures: {a: {kind: image, file: none.png}}\nboxes: [{texture: a}]\n"),
              testing::AllOf(testing::StartsWith("scene_test.yaml:3:19: boxes[0].texture: file: "),
                             testing::HasSubstr("none.png: no such picture file")));
  EXPECT_THAT(SceneError("floor: {texture: {kind: carpet, size_m: [100, 100], px_per_m: 1000}}\n"),
              testing::StartsWith("scene_test.yaml:1:18: floor.texture: px_per_m: 1000 gives 10000 million pixels"));
}

TEST(Scene, NumbersThatNoRoomHasAreNamedWhereTheyStand) {
  const std::string floor = "floor: {texture: {kind: carpet, px_per_m: 32}}\n";
  const auto refused = [](const std::string& where, const std::string& number) {
    return "scene_test.yaml:" + where + ": " + number + " is not permitted; expected a number from -1e9 to 1e9";
  };
  EXPECT_EQ(SceneError(floor + "walls: [{points: [[0, 0], [1e308, 0]]}]\n"),
            refused("2:28: walls[0].points[1][0]", "1e308"));
  EXPECT_EQ(SceneError(floor + "walls: [{points: [[0, 0], [1, 0]], height_m: 1e308}]\n"),
            refused("2:46: walls[0].height_m", "1e308"));
  EXPECT_EQ(SceneError(floor + "furniture: [{kind: table, at: [.nan, 0]}]\n"),
            refused("2:32: furniture[0].at[0]", ".nan"));
  EXPECT_EQ(SceneError(floor + "boxes: [{size: [1, .inf, 1]}]\n"), refused("2:20: boxes[0].size[1]", ".inf"));
  EXPECT_EQ(SceneError(floor + "start: [0, -1e300, 0]\n"), refused("2:12: start[1]", "-1e300"));
  EXPECT_EQ(SceneError("floor: {extent: [[0, 0], [1e300, 1]], texture: carpet}\n"),
            refused("1:27: floor.extent[1][0]", "1e300"));
}

TEST(Scene, MoreTexturesThanTheRendererCanDrawAreRefused) {
  std::string text = "floor: {texture: {kind: carpet, px_per_m: 8}}\nboxes:\n";
  for (int i = 0; i < 99; ++i) {
    text += "  - {texture: {kind: paint, size_m: [0.1, 0.1], px_per_m: 8, seed: " + std::to_string(i) + "}}\n";
  }
  EXPECT_THAT(SceneError(text), testing::HasSubstr("one texture too many; MuJoCo draws at most 99"));
}

TEST(Scene, AnUnknownNameComesWithTheNearestOne) {
  try {
    ReadScene("labb", kModels);
    FAIL();
  } catch (const BadInput& e) {
    EXPECT_STREQ(e.what(), "scene \"labb\": no such scene; did you mean lab?");
  }
  EXPECT_THROW(ReadScene("somewhere/else.yaml", kModels), BadInput);
}

TEST(Scene, OneThatDerivesFromAnotherIsThatOneButForItsOwnKeys) {
  const Scene lab = ReadScene("lab", kModels), dim = ReadScene("lab_dim", kModels);
  EXPECT_EQ(dim.name, "lab_dim");
  EXPECT_EQ(lab.light, 1);
  EXPECT_EQ(dim.light, 0.1);
  EXPECT_EQ(dim.start, lab.start);
  ASSERT_EQ(dim.boxes.size(), lab.boxes.size());
  for (size_t i = 0; i < lab.boxes.size(); ++i) EXPECT_EQ(dim.boxes[i].X_WB.translation, lab.boxes[i].X_WB.translation);
  EXPECT_EQ(cv::norm(dim.textures[0].Bgr(), lab.textures[0].Bgr(), cv::NORM_INF), 0);
  EXPECT_EQ(dim.bases, std::vector<std::filesystem::path>{kModels / "scenes/lab.yaml"});
  const Scene plain = ReadScene("lab_plain", kModels);
  const auto posters = [](const Scene& scene) {
    return std::count_if(scene.boxes.begin(), scene.boxes.end(),
                         [](const SceneBox& b) { return b.name.starts_with("poster"); });
  };
  EXPECT_EQ(posters(lab), 37);
  EXPECT_EQ(posters(plain), 5);
}

TEST(Scene, ABaseLiesBesideTheFileOrIsShippedAndMistakesAreNamedWhereTheyStand) {
  const TemporaryFolder folder;
  folder.Write("room.yaml", "floor: {extent: [[-2, -1], [2, 1]], texture: carpet, friction: 0.5}\nlights: [{}]\n");
  const Scene scene = SceneOfText("base: room.yaml\nfloor: {friction: 0.3}\nlights: []\n", folder);
  EXPECT_EQ(scene.floor_friction, 0.3);
  EXPECT_EQ(scene.floor_max.x(), 2);
  EXPECT_TRUE(scene.lights.empty());
  EXPECT_THAT(SceneError("base: labb\n"),
              testing::AllOf(testing::HasSubstr("scene_test.yaml:1"), testing::HasSubstr("lab")));
  EXPECT_THAT(SceneError("base: no.yaml\n"), testing::HasSubstr("scene_test.yaml:1"));
  EXPECT_THAT(SceneError("base: scene_test.yaml\n"), testing::HasSubstr("no end"));
  EXPECT_THAT(SceneError("base: lab\nlihgt: 2\n"),
              testing::AllOf(testing::HasSubstr("scene_test.yaml:2"), testing::HasSubstr("light")));
  folder.Write("bad.yaml", "floor: {extent: [[-2, -1], [2, 1]], texture: carpet}\nambient: 7\n");
  try {
    SceneOfText("base: bad.yaml\n", folder);
    FAIL();
  } catch (const BadInput& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("bad.yaml:2"));
  }
}

TEST(Scene, ARepeatFindsOtherPicturesAndFurnitureWithinItsLimits) {
  const Scene lab = ReadScene("lab", kModels);
  SceneVariation variation;
  EXPECT_EQ(ReadVariedScene("lab", kModels, variation).boxes[30].X_WB.translation, lab.boxes[30].X_WB.translation);
  variation.seed = 5;
  variation.light = 0.5;
  variation.furniture_m = 0.03;
  variation.furniture_deg = 3;
  variation.draw = 9;
  const Scene varied = ReadVariedScene("lab", kModels, variation);
  EXPECT_EQ(varied.light, 0.5);
  EXPECT_GT(cv::norm(varied.textures[0].Bgr(), lab.textures[0].Bgr(), cv::NORM_INF), 0);
  ASSERT_EQ(varied.boxes.size(), lab.boxes.size());
  int moved = 0;
  for (size_t i = 0; i < lab.boxes.size(); ++i) {
    const std::string& name = lab.boxes[i].name;
    const Eigen::Vector2d by = (varied.boxes[i].X_WB.translation - lab.boxes[i].X_WB.translation).head<2>();
    if (name.starts_with("wall")) {
      EXPECT_EQ(by.norm(), 0) << name;
    } else if (name.starts_with("carton") || name.starts_with("bin")) {  // one part in the middle: it only shifts
      EXPECT_LE(by.cwiseAbs().maxCoeff(), 0.06) << name;
      moved += by.norm() > 0;
    }
  }
  EXPECT_GT(moved, 10);
}

}  // namespace
}  // namespace gaitcam
