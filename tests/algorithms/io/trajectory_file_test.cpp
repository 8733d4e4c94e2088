#include "algorithms/io/trajectory_file.h"

#include <gmock/gmock.h>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"
#include "tests/algorithms/io/file_test.h"

namespace gaitcam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class TrajectoryFiles : public FileTest {
 protected:
  // Stamps like those of real recordings, which a double cannot hold in seconds to the nanosecond.
  static Trajectory SomeTrajectory() {
    RandomStream random(3, "trajectory_file_test");
    Trajectory trajectory;
    for (int i = 0; i < 50; ++i) {
      const Eigen::Quaterniond q(random.Normal(), random.Normal(), random.Normal(), random.Normal());
      const Eigen::Vector3d t(random.Normal(), 1e-7 * random.Normal(), 1e5 * random.Normal());
      trajectory.push_back({1'403'636'579'763'555'584 + i * 33'333'333, Pose(q, t)});
    }
    return trajectory;
  }

  std::string Refusal(const std::string& text) const {
    return ErrorOf<BadInput>([&] { ReadTrajectory(Write("bad.txt", text)); });
  }
};

TEST_F(TrajectoryFiles, TumAndEurocComeBackToTheBit) {
  const Trajectory written = SomeTrajectory();
  for (const auto format : {TrajectoryFormat::kTum, TrajectoryFormat::kEuroc}) {
    WriteTrajectory(folder_ / "path", written, format);
    const TrajectoryFile read = ReadTrajectory(folder_ / "path");
    EXPECT_EQ(read.format, format);
    ASSERT_EQ(read.trajectory.size(), written.size());
    for (size_t i = 0; i < written.size(); ++i) {
      EXPECT_EQ(read.trajectory[i].stamp_ns, written[i].stamp_ns);
      EXPECT_EQ(read.trajectory[i].pose.translation, written[i].pose.translation);
      EXPECT_EQ(read.trajectory[i].pose.rotation.coeffs(), written[i].pose.rotation.coeffs());
    }
  }
}

TEST_F(TrajectoryFiles, KittiKeepsMatricesAndTakesItsTimesFromAnotherFile) {
  const Trajectory written = SomeTrajectory();
  WriteTrajectory(folder_ / "path", written, TrajectoryFormat::kKitti);
  std::string times;
  for (const StampedPose& pose : written) times += std::to_string(pose.stamp_ns) + "e-9\n";
  const TrajectoryFile read = ReadTrajectory(folder_ / "path", {}, Write("times.txt", times));
  EXPECT_EQ(read.format, TrajectoryFormat::kKitti);
  ASSERT_EQ(read.trajectory.size(), written.size());
  for (size_t i = 0; i < written.size(); ++i) {
    EXPECT_EQ(read.trajectory[i].stamp_ns, written[i].stamp_ns);
    // A quaternion through a matrix and back: a few roundings of numbers below 1.
    EXPECT_LT((read.trajectory[i].pose.R() - written[i].pose.R()).norm(), 1e-14);
    EXPECT_EQ(read.trajectory[i].pose.translation, written[i].pose.translation);
  }
  const Trajectory rows = ReadTrajectory(folder_ / "path").trajectory;
  EXPECT_EQ(rows[3].stamp_ns, 3'000'000'000);
}

TEST_F(TrajectoryFiles, FilesAsOthersWriteThemAreRead) {
  // Four decimals, comments, tabs, Windows line ends, exponents, more columns than needed.
  const Trajectory tum =
      ReadTrajectory(Write("tum.txt",
                           "# ground truth trajectory\n# file: 'x.bag'\n\n"
                           "1305031098.6659 1.3563 0.6305 1.6380 0.6132 0.5962 -0.3311 -0.3986\r\n"
                           "1.3050310986758e+09\t1.3543  0.6306 1.6360 0.6129 0.5966 -0.3316 -0.3980\r\n"))
          .trajectory;
  ASSERT_EQ(tum.size(), 2u);
  EXPECT_EQ(tum[0].stamp_ns, 1'305'031'098'665'900'000);
  EXPECT_EQ(tum[1].stamp_ns, 1'305'031'098'675'800'000);
  EXPECT_DOUBLE_EQ(tum[0].pose.rotation.norm(), 1.0);

  const TrajectoryFile euroc = ReadTrajectory(
      Write("data.csv",
            "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], v\n"
            "1403636580838555648,4.688319,-1.786938,0.783338,0.534108,-0.153029,-0.827383,-0.082152,-0.027876\n"));
  EXPECT_EQ(euroc.format, TrajectoryFormat::kEuroc);
  EXPECT_EQ(euroc.trajectory.at(0).stamp_ns, 1'403'636'580'838'555'648);
  EXPECT_NEAR(euroc.trajectory.at(0).pose.rotation.w(), 0.534108, 1e-6);  // as many digits as the file has
}

TEST_F(TrajectoryFiles, AnErrorNamesFileLineAndWhatWouldBeRight) {
  EXPECT_THAT(Refusal("# t\n1 0 0 0 0 0 0 1\n2 0 zero 0 0 0 0 1\n"),
              AllOf(HasSubstr("bad.txt:3: \"zero\""), HasSubstr("metres")));
  EXPECT_THAT(Refusal("1 0 0 0 0 0 0 1\n2 0 nan 0 0 0 0 1\n"), HasSubstr("bad.txt:2: \"nan\" is not a finite number"));
  EXPECT_THAT(Refusal("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0\n"), AllOf(HasSubstr("bad.txt:2:"), HasSubstr("expected 8")));
  EXPECT_THAT(Refusal("1 0 0\n"), AllOf(HasSubstr("bad.txt:1:"), HasSubstr("12 (KITTI")));
  EXPECT_THAT(Refusal("1 0 0 0 0 0 0 2\n"), AllOf(HasSubstr("bad.txt:1:"), HasSubstr("length is 2; expected 1")));
  EXPECT_THAT(Refusal("1 0 0 0 0 1 0 0 0 0 2 0\n"), HasSubstr("bad.txt:1: columns 1-3"));
  EXPECT_THAT(Refusal("2 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n"),
              AllOf(HasSubstr("bad.txt:2:"), HasSubstr("does not come after")));
  EXPECT_THAT(Refusal("1.5,0,0,0,1,0,0,0\n"), AllOf(HasSubstr("bad.txt:1: \"1.5\""), HasSubstr("nanoseconds")));
  EXPECT_THAT(Refusal("100,0,0,0,1\n"), AllOf(HasSubstr("bad.txt:1:"), HasSubstr("ends after 5 fields")));
  EXPECT_THAT(Refusal("# only words\n"), HasSubstr("holds no pose"));
  EXPECT_THAT(ErrorOf<BadInput>([&] { ReadTrajectory(folder_ / "absent.txt"); }), HasSubstr("absent.txt: cannot read"));
  EXPECT_THAT(ErrorOf<BadInput>([&] { ReadTrajectory(folder_); }), HasSubstr("cannot read"));
}

// As the TUM benchmark's truth of freiburg2_desk holds a stamp twice.
TEST_F(TrajectoryFiles, StampsOfTheRealWorldAreRepairedAndSaid) {
  const auto file = Write(
      "real.txt", "1.0 1 0 0 0 0 0 1\n2.0 2 0 0 0 0 0 1\n2.0 9 0 0 0 0 0 1\n4.0 4 0 0 0 0 0 1\n3.0 3 0 0 0 0 0 1\n");
  EXPECT_THROW(ReadTrajectory(file), BadInput);
  const TrajectoryFile repaired = ReadTrajectory(file, {}, {}, StampOrder::kRepaired);
  ASSERT_EQ(repaired.trajectory.size(), 4u);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(repaired.trajectory[i].pose.translation.x(), double(i + 1));
  ASSERT_EQ(repaired.remarks.size(), 2u);
  EXPECT_THAT(repaired.remarks[0], HasSubstr("real.txt: 1 row is earlier than the one before: sorted by time"));
  EXPECT_THAT(repaired.remarks[1], HasSubstr("1 row has the stamp of another: the first is kept"));
  const auto good = Write("good.txt", "1.0 1 0 0 0 0 0 1\n2.0 2 0 0 0 0 0 1\n");
  EXPECT_TRUE(ReadTrajectory(good, {}, {}, StampOrder::kRepaired).remarks.empty());
}

TEST_F(TrajectoryFiles, KittiTimesMustMatchRowByRow) {
  const auto poses = Write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n");
  const auto refusal = [&](const std::string& times) {
    return ErrorOf<BadInput>([&] { ReadTrajectory(poses, {}, Write("times.txt", times)); });
  };
  EXPECT_THAT(refusal("0\n"), HasSubstr("poses.txt:2: has no time"));
  EXPECT_THAT(refusal("0\n1\n2\n"), HasSubstr("times.txt:3: has no pose"));
  EXPECT_THAT(refusal("1\n1\n"), HasSubstr("times.txt:2: time"));
}

TEST_F(TrajectoryFiles, AFileThatCannotBeWrittenIsSaid) {
  EXPECT_THAT(ErrorOf<MissingResource>(
                  [&] { WriteTrajectory(folder_ / "no" / "folder.txt", SomeTrajectory(), TrajectoryFormat::kTum); }),
              HasSubstr("folder.txt: cannot write"));
}

TEST_F(TrajectoryFiles, WordsNameFormats) {
  for (const auto format : {TrajectoryFormat::kTum, TrajectoryFormat::kKitti, TrajectoryFormat::kEuroc}) {
    EXPECT_EQ(TrajectoryFormatFromText(ToString(format)), format);
  }
  EXPECT_THROW(TrajectoryFormatFromText("bvh"), BadInput);
}

}  // namespace
}  // namespace gaitcam
