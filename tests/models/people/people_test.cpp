#include "models/code/people/people.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "models/code/people/person_shape.h"
#include "models/code/people/person_walk.h"
#include "models/code/scenes/scene.h"
#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

PersonOptions Walker(double speed_m_s, bool repeat = true, double height_m = 1.75) {
  PersonOptions person;
  person.path = {{1, -2}, {1, 2}, {3.5, 3}, {3, 0}};  // one bend that is walked round, one that is turned at
  person.speed_m_s = speed_m_s;
  person.repeat = repeat;
  person.height_m = height_m;
  person.start_s = 0.5;
  return person;
}

const Pose& Part(const PersonPose& pose, PersonPart left, int side = 0) { return pose[size_t(left) + size_t(side)]; }

/// The lowest points of a foot on the floor: heel, ball, tip.
std::array<Eigen::Vector3d, 3> Sole(const PersonWalk& walk, const PersonPose& pose, int side) {
  const Pose &shoe = Part(pose, PersonPart::kLeftShoe, side), &toes = Part(pose, PersonPart::kLeftToes, side);
  return {shoe * Eigen::Vector3d(-walk.body().heel, 0, 0), shoe.translation,
          toes * Eigen::Vector3d(walk.body().toes, 0, 0)};
}

TEST(People, FeetThatCarryDoNotSlide) {
  for (const double speed : {0.3, 0.7, 1.2, 1.6}) {
    const PersonWalk walk(Walker(speed));
    constexpr double kStep = 0.004;
    double stood = 0;
    PersonPose before = walk.At(0);
    for (double t = kStep; t < walk.start_s() + walk.duration_s(); t += kStep) {
      const PersonPose now = walk.At(t);
      for (int side = 0; side < 2; ++side) {
        if (!walk.Stands(side, t) || !walk.Stands(side, t - kStep)) continue;
        const auto a = Sole(walk, before, side), b = Sole(walk, now, side);
        const double heel = (b[0] - a[0]).norm(), ball = (b[1] - a[1]).norm();
        // Rounding: heel and ball are placed by the same few products at any instant.
        EXPECT_LT(std::min(heel, ball), 1e-9) << "at " << speed << " m/s, " << t << " s, side " << side;
        stood += kStep;
      }
      before = now;
    }
    EXPECT_GT(stood, walk.duration_s()) << "each foot stands more than half of the time";
  }
}

TEST(People, FeetAreNeverUnderTheFloorAndOneIsAlwaysOnIt) {
  for (const double speed : {0.3, 1.2}) {
    const PersonWalk walk(Walker(speed));
    for (double t = 0; t < walk.duration_s(); t += 0.01) {
      const PersonPose pose = walk.At(t);
      double lowest = 1;
      for (int side = 0; side < 2; ++side) {
        for (const Eigen::Vector3d& point : Sole(walk, pose, side)) {
          EXPECT_GT(point.z(), -1e-9);
          lowest = std::min(lowest, point.z());
        }
      }
      EXPECT_LT(lowest, 1e-9);
    }
  }
}

TEST(People, LegsReachFromHipToAnkleWithLinksOfConstantLength) {
  for (const double height : {1.2, 1.75, 2.0}) {
    for (const double speed : {0.2, 0.7, 1.2, 2.0}) {
      const PersonWalk walk(Walker(speed, true, height));
      const PersonBody& body = walk.body();
      for (double t = 0; t < walk.duration_s(); t += 0.02) {
        const PersonPose pose = walk.At(t);
        for (int side = 0; side < 2; ++side) {
          const double left = side == 0 ? 1 : -1;
          const Pose &thigh = Part(pose, PersonPart::kLeftThigh, side),
                     &shank = Part(pose, PersonPart::kLeftShank, side);
          const Eigen::Vector3d hip = Part(pose, PersonPart::kHips) * Eigen::Vector3d(0, left * body.hip_half_width, 0);
          const Eigen::Vector3d ankle =
              Part(pose, PersonPart::kLeftShoe, side) * Eigen::Vector3d(-body.ankle_back, 0, body.ankle_height);
          EXPECT_LT((thigh.translation - hip).norm(), 1e-9);
          EXPECT_LT((thigh * Eigen::Vector3d(0, 0, -body.thigh) - shank.translation).norm(), 1e-6);
          EXPECT_LT((shank * Eigen::Vector3d(0, 0, -body.shank) - ankle).norm(), 1e-6);
          // Knees bend forwards only.
          const Eigen::Vector3d knee_S = Part(pose, PersonPart::kHips).Inverse() * shank.translation;
          const Eigen::Vector3d ankle_S = Part(pose, PersonPart::kHips).Inverse() * ankle;
          const double share = knee_S.z() / ankle_S.z();
          EXPECT_GT(knee_S.x(), share * ankle_S.x() - 1e-6);
        }
      }
    }
  }
}

TEST(People, HipsMoveAtTheGivenSpeedWithoutJumps) {
  PersonOptions person = Walker(1.2, false);
  person.path = {{0, 0}, {6, 0}};
  const PersonWalk walk(person);
  const auto hips = [&](double t) { return Part(walk.At(t), PersonPart::kHips).translation; };
  const double middle = person.start_s + walk.duration_s() / 2;
  EXPECT_NEAR((hips(middle + 0.5) - hips(middle - 0.5)).x(), 1.2, 1e-6);
  EXPECT_NEAR(walk.step_length_m(), 0.68, 0.01);  // as people do at this speed
  for (double t = 0; t < person.start_s + walk.duration_s() + 1; t += 0.01) {
    // No part of anybody moves faster than a swinging foot, about three times as fast as the person.
    const PersonPose a = walk.At(t), b = walk.At(t + 0.01);
    for (int part = 0; part < kPersonParts; ++part) {
      EXPECT_LT((b[part].translation - a[part].translation).norm(), 0.01 * 5 * 1.2) << part << " at " << t;
      EXPECT_LT(RotationAngle(a[part].rotation, b[part].rotation), 0.01 * 14) << part << " at " << t;
    }
  }
}

TEST(People, ARepeatedWayIsTheSameEveryLapAndALoneOneEnds) {
  const PersonWalk laps(Walker(1.1)), once(Walker(1.1, false));
  for (double t = 0.6; t < 20; t += 1.7) {
    const PersonPose a = laps.At(t), b = laps.At(t + laps.duration_s());
    for (int part = 0; part < kPersonParts; ++part) {
      EXPECT_LT((a[part].translation - b[part].translation).norm(), 1e-9);
      EXPECT_LT(RotationAngle(a[part].rotation, b[part].rotation), 1e-6);
    }
  }
  // The lap's end joins its beginning.
  const double seam = 0.5 + laps.duration_s();
  EXPECT_LT((laps.At(seam - 1e-6)[0].translation - laps.At(seam + 1e-6)[0].translation).norm(), 1e-5);
  EXPECT_LT((laps.At(seam - 1e-6)[11].translation - laps.At(seam + 1e-6)[11].translation).norm(), 1e-5);
  const Eigen::Vector3d end = once.At(1000)[0].translation;
  EXPECT_NEAR(end.x(), 3, 1e-9);
  EXPECT_NEAR(end.y(), 0, 1e-9);
  EXPECT_EQ(once.At(1000)[3].translation, once.At(1001)[3].translation);
}

TEST(People, WhoStandsStandsStillAndLooksWhereTold) {
  PersonOptions person;
  person.path = {{2, 0.5}};
  person.speed_m_s = 0;
  person.facing_deg = 90;
  const PersonWalk walk(person);
  const PersonPose a = walk.At(0), b = walk.At(123);
  for (int part = 0; part < kPersonParts; ++part) EXPECT_EQ(a[part].translation, b[part].translation);
  EXPECT_NEAR(a[0].translation.x(), 2, 1e-9);
  EXPECT_NEAR(a[0].translation.y(), 0.5, 1e-9);
  EXPECT_NEAR(Part(a, PersonPart::kHead).Yaw(), M_PI / 2, 1e-9);
  EXPECT_TRUE(walk.Stands(0, 5) && walk.Stands(1, 5));
  EXPECT_TRUE(walk.steps().empty());
  // Before they start, walkers stand, too.
  const PersonWalk later(Walker(1));
  EXPECT_EQ(later.At(-5)[0].translation, later.At(0.4)[0].translation);
}

TEST(People, SurfacesAreClosedAndAsTallAsThePerson) {
  PersonOptions person;
  person.path = {{0, 0}};
  person.speed_m_s = 0;
  person.height_m = 1.6;
  const PersonPose pose = PersonWalk(person).At(0);
  double low = 1, high = 0;
  for (const PersonSurface& surface : PersonSurfaces(person, {0.64, 0.64})) {
    double volume = 0;
    ASSERT_EQ(surface.vertices.size(), surface.normals.size());
    ASSERT_EQ(surface.vertices.size(), surface.texcoords.size());
    Eigen::Vector3d area(0, 0, 0);
    for (const auto& [a, b, c] : surface.faces) {
      const Eigen::Vector3d &p = surface.vertices[a], &q = surface.vertices[b], &r = surface.vertices[c];
      volume += p.cross(q).dot(r) / 6;
      area += (q - p).cross(r - p);
      // Lit from the side that is seen.
      EXPECT_GE((q - p).cross(r - p).dot(surface.normals[a] + surface.normals[b] + surface.normals[c]), -1e-12);
    }
    EXPECT_GT(volume, 0);          // faces look outwards
    EXPECT_LT(area.norm(), 1e-9);  // and leave no hole
    for (const Eigen::Vector3d& vertex : surface.vertices) {
      const double z = (pose[size_t(surface.part)] * vertex).z();
      low = std::min(low, z);
      high = std::max(high, z);
    }
  }
  EXPECT_NEAR(low, 0, 1e-3);
  EXPECT_NEAR(high, 1.6, 0.03);
}

/// How often a closed surface winds about a point: 1 inside, 0 outside (A. Van Oosterom and J. Strackee, "The solid
/// angle of a plane triangle", 1983).
double Winding(const PersonSurface& surface, const Eigen::Vector3d& point) {
  double angle = 0;
  for (const auto& [i, j, k] : surface.faces) {
    const Eigen::Vector3d a = surface.vertices[i] - point, b = surface.vertices[j] - point,
                          c = surface.vertices[k] - point;
    const double x = a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() + b.dot(c) * a.norm() + c.dot(a) * b.norm();
    angle += 2 * std::atan2(a.dot(b.cross(c)), x);
  }
  return angle / (4 * M_PI);
}

TEST(People, CoresLieWithinTheirSurfacesAndFillTheLimbs) {
  PersonOptions person;
  person.path = {{0, 0}};
  int limbs = 0;
  for (const PersonSurface& surface : PersonSurfaces(person, {0.64, 0.64})) {
    const auto& [from, to] = surface.core.ends;
    for (int step = 0; step <= 20; ++step) {
      const double part = 0.001 + 0.998 * step / 20;  // not in the caps themselves
      for (int i = 0; i < 24; ++i) {
        const double angle = 2 * M_PI * i / 24;
        const Eigen::Vector3d low = from.center + std::cos(angle) * from.a + std::sin(angle) * from.b;
        const Eigen::Vector3d high = to.center + std::cos(angle) * to.a + std::sin(angle) * to.b;
        EXPECT_GT(Winding(surface, low + part * (high - low)), 0.5) << int(surface.part) << " " << step << " " << i;
      }
    }
    const bool leg = surface.part >= PersonPart::kLeftThigh && surface.part <= PersonPart::kRightShank;
    limbs += leg && (to.center - from.center).norm() > 0.2 && from.a.norm() > 0.04 && to.b.norm() > 0.04;
  }
  EXPECT_EQ(limbs, 4);
}

std::string PeopleError(const std::string& people) {
  const TemporaryFolder folder;
  const std::string floor =
      "floor: {extent: [[-2, -1], [2, 1]], texture: {kind: carpet, size_m: [1, 1], px_per_m: 128}}\n";
  const std::filesystem::path file = folder.Write("people_test.yaml", floor + "people: " + people + "\n");
  try {
    ReadScene(file.string(), TestData() / "models");
  } catch (const BadInput& e) {
    return e.what();
  }
  return "";
}

TEST(People, BadInputIsNamed) {
  EXPECT_EQ(PeopleError("[{path: [[0, 0]], speed_m_s: 0}, {path: [[0, 0], [1, 0]]}]"), "");
  EXPECT_THAT(PeopleError("[{path: [[0, 0]]}]"), HasSubstr("two points or more"));
  EXPECT_THAT(PeopleError("[{speed_m_s: 0}]"), HasSubstr("path: missing"));
  EXPECT_THAT(PeopleError("[{path: []}]"), HasSubstr("one point or more"));
  EXPECT_THAT(PeopleError("[{path: [[0, 0], [0, 0.01]]}]"), HasSubstr("people[0].path[1]"));
  EXPECT_THAT(PeopleError("[{path: [[0, 0], [1, 0]], speed_ms: 1}]"), HasSubstr("did you mean speed_m_s?"));
  EXPECT_THAT(PeopleError("[{path: [[0, 0], [1, 0]], speed_m_s: 0.05}]"), HasSubstr("expected 0, or 0.1 and more"));
  EXPECT_THAT(PeopleError("[{path: [[0, 0], [1, 0]], speed_m_s: -1}]"), HasSubstr("speed_m_s"));
  EXPECT_THAT(PeopleError("[{path: [[0, 0], [1, 0]], height_m: 5}]"), HasSubstr("height_m"));
  EXPECT_THAT(PeopleError("[{path: [[0, 0], [1, 0]], top_rgb: [2, 0, 0]}]"), HasSubstr("three numbers from 0 to 1"));
  EXPECT_THAT(PeopleError("[{path: [[0, 0], [1, .nan]]}]"), HasSubstr("path[1][1]: .nan is not permitted"));
  EXPECT_THAT(PeopleError("{path: [[0, 0], [1, 0]]}"), HasSubstr("expected a list"));
}

}  // namespace
}  // namespace gaitcam
