// Data sets through the program itself: whole, resumable, refused where they must be.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <thread>

#include "tests/scenarios/program.h"
#include "tests/scenarios/tiny_walk.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const char* const kMatrix = R"(
description: a test
base: walk.yaml
set: {duration_s: 0.8, scene: plain}
axes:
  gait.preset: [normal, brisk]
  camera.exposure_ms: [0, 10]
pairs: {every: 5}
licence: CC0-1.0
)";

class RecordMatrixTest : public testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(File("walk.yaml")) << kTinyWalk;
    std::ofstream(File("matrix.yaml")) << kMatrix;
  }
  ProgramResult Run(const std::string& arguments) const { return RunProgram(arguments, temporary_.path()); }
  fs::path File(const std::string& name) const { return temporary_.path() / name; }

  void ExpectWhole(const std::string& out) const {
    const ProgramResult sums = RunShell("sha256sum --strict --quiet -c SHA256SUMS", File(out));
    EXPECT_EQ(sums.exit_code, 0) << sums.out << sums.err;
    const ProgramResult valid = Run("validate " + out);
    EXPECT_EQ(valid.exit_code, 0) << valid.err;
  }
  /// No sequence that is not whole, nothing hidden.
  void ExpectNothingHalf(const std::string& out) const {
    if (!fs::exists(File(out) / "sequences")) return;
    for (const auto& entry : fs::directory_iterator(File(out) / "sequences")) {
      const std::string name = entry.path().filename();
      EXPECT_NE(name[0], '.') << name;
      const std::string other = name.ends_with("-truth") ? name.substr(0, name.size() - 6) : name + "-truth";
      EXPECT_TRUE(fs::exists(File(out) / "sequences" / other)) << name;
    }
  }

  std::string Sums(const std::string& out) const { return ReadText(File(out + "/SHA256SUMS")); }

  const TemporaryFolder temporary_;
};

TEST_F(RecordMatrixTest, AMatrixBecomesADataSet) {
  const ProgramResult result = Run("record matrix.yaml --out data");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("4 of 4 sequences (0 were there), 32 frames: data"));
  ExpectWhole("data");
  ExpectNothingHalf("data");
  EXPECT_FALSE(fs::exists(File("data/.work")));
  const std::string index = ReadText(File("data/index.csv")), card = ReadText(File("data/README.md"));
  EXPECT_EQ(std::count(index.begin(), index.end(), '\n'), 5);
  EXPECT_THAT(index, HasSubstr("\nbrisk-exposure_ms10-seed1,brisk,10,1,8,0.800,"));
  EXPECT_THAT(index,
              HasSubstr(",1,finished,sequences/normal-exposure_ms0-seed1,sequences/normal-exposure_ms0-seed1-t"));
  for (const char* text : {"# matrix", "a test", "CC0-1.0", "middle of its exposure", "4 of 4 sequences", "MuJoCo",
                           "`camera.exposure_ms`: 0, 10", "| `brisk-exposure_ms10-seed1` | brisk | 10 | 1 | 8 |"})
    EXPECT_THAT(card, HasSubstr(text));
  const fs::path truth = File("data/sequences/brisk-exposure_ms10-seed1-truth");
  cv::VideoCapture film((truth / "preview.mp4").string());
  EXPECT_EQ(film.get(cv::CAP_PROP_FRAME_COUNT), 8);
  const cv::Mat sheet = cv::imread((truth / "contact_sheet.png").string());
  EXPECT_GT(sheet.cols, 1900);  // three pairs of 320 px
  EXPECT_TRUE(fs::exists(truth / "pairs/000000_000003/H_floor.txt"));
}

TEST_F(RecordMatrixTest, WhatIsThereIsKeptAndMustBeTheSame) {
  ASSERT_EQ(Run("record matrix.yaml --out data -q").exit_code, 0);
  const fs::path kept = File("data/sequences/normal-exposure_ms0-seed1");
  const auto before = fs::last_write_time(kept);
  const std::string sums = Sums("data");
  fs::remove_all(File("data/sequences/brisk-exposure_ms10-seed1"));  // its truth remains: half a sequence
  const ProgramResult again = Run("record matrix.yaml --out data --json -q");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out)["reused"], 3);
  EXPECT_EQ(fs::last_write_time(kept), before);
  EXPECT_EQ(Sums("data"), sums);  // recorded again, it is the same to the byte

  const ProgramResult longer = Run("record matrix.yaml --out data -q --set duration_s=0.6");
  EXPECT_EQ(longer.exit_code, 2);
  EXPECT_THAT(longer.err, HasSubstr("was recorded from another scenario or with other options"));
  const bool in_software =
      ReadText(kept.string() + "-truth/sequence.json").find("\"software_renderer\": true") != std::string::npos;
  const ProgramResult other =
      Run(std::string("record matrix.yaml --out data -q --set camera.renderer=") + (in_software ? "gpu" : "software"));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err, HasSubstr(in_software ? ", which camera.renderer = gpu rules out"
                                               : ", which camera.renderer = software rules out"));
  const ProgramResult without = Run("record matrix.yaml --out data -q --format euroc");
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_EQ(Sums("data"), sums);
}

TEST_F(RecordMatrixTest, TheIndexAndTheChecksumsAreHeldToTheirWord) {
  ASSERT_EQ(Run("record matrix.yaml --out data -q --format euroc").exit_code, 0);
  ExpectWhole("data");
  // One bit of an image, so that it is still a whole image of its frame.
  const fs::path folder = File("data/sequences/normal-exposure_ms10-seed1/mav0/cam0/data");
  const fs::path image = *fs::directory_iterator(folder);
  cv::Mat pixels = cv::imread(image.string());
  pixels.data[1000] ^= 1;
  cv::imwrite(image.string(), pixels);
  ProgramResult result = Run("validate data");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err,
              HasSubstr(image.filename().string() + " is not the file that was recorded: its checksum differs"));
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;

  fs::remove_all(File("data/sequences/brisk-exposure_ms0-seed1"));
  std::ofstream(File("data/notes.txt")) << "mine\n";
  result = Run("validate data");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("data/index.csv:4: lists the sequence brisk-exposure_ms0-seed1, but there is no"));
  EXPECT_THAT(result.err, HasSubstr("data/notes.txt: has no checksum in"));
}

TEST_F(RecordMatrixTest, AKillLosesNoFinishedSequenceAndTheRestIsRecordedTheSame) {
  ASSERT_EQ(Run("record matrix.yaml --out calm -q").exit_code, 0);
  for (int round = 0; round < 3; ++round) {
    const pid_t child = fork();
    if (child == 0) {
      setenv("GAITCAM_DATA", TestData().c_str(), 1);
      if (chdir(temporary_.path().c_str()) != 0) _exit(1);
      execl(Program().c_str(), "gaitcam", "record", "matrix.yaml", "--out", "shot", "-q", nullptr);
      _exit(127);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1200 + 700 * round));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));  // its own children die with it
  }
  int whole = 0;  // what the kills have left
  for (const char* name : {"normal-exposure_ms0", "normal-exposure_ms10", "brisk-exposure_ms0", "brisk-exposure_ms10"})
    whole += fs::exists(File("shot/sequences") / (std::string(name) + "-seed1"));
  const ProgramResult result = Run("record matrix.yaml --out shot --json -q");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out)["reused"], whole);
  ExpectNothingHalf("shot");
  EXPECT_EQ(Sums("shot"), Sums("calm"));
}

/// Files larger than the limit cannot be written: as on a full disk, the system says so at the write.
TEST_F(RecordMatrixTest, AFullDiskIsOneLineAndLeavesNothingHalf) {
  for (const int blocks : {16, 200}) {  // of 512 bytes: too small for an image; for a sheet
    const std::string limited = "trap '' XFSZ; ulimit -f " + std::to_string(blocks) +
                                "; GAITCAM_DATA=" + TestData().string() + " " + Program() + " ";
    const ProgramResult many = RunShell(limited + "record matrix.yaml --out full -q", temporary_.path());
    EXPECT_EQ(many.exit_code, 4) << many.err;
    EXPECT_THAT(many.err, HasSubstr("cannot "));
    EXPECT_EQ(std::count(many.err.begin(), many.err.end(), '\n'), 1) << many.err;
    ExpectNothingHalf("full");
    const ProgramResult one =
        RunShell(limited + "record walk.yaml --out one -q --preview --set duration_s=0.8", temporary_.path());
    EXPECT_EQ(one.exit_code, 4) << one.err;
    EXPECT_EQ(std::count(one.err.begin(), one.err.end(), '\n'), 1) << one.err;
    EXPECT_FALSE(fs::exists(File("one/walk")));
    EXPECT_FALSE(fs::exists(File("one/walk-truth")));
  }
  ASSERT_EQ(Run("record matrix.yaml --out full -q").exit_code, 0);  // once there is room again
  ExpectWhole("full");
}

TEST_F(RecordMatrixTest, AFullFileSystemIsOneLineAndLeavesNothingHalf) {
  fs::create_directories(File("small"));
  if (mount("tmpfs", File("small").c_str(), "tmpfs", 0, "size=1500k") != 0) GTEST_SKIP() << "may not mount a tmpfs";
  const ProgramResult result = Run("record matrix.yaml --out small/data -q");
  ExpectNothingHalf("small/data");
  umount2(File("small").c_str(), MNT_DETACH);
  EXPECT_EQ(result.exit_code, 4) << result.err;
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
}

TEST_F(RecordMatrixTest, AFolderThatCannotBeWrittenIsOneLine) {
  for (const char* arguments : {"record matrix.yaml --out /proc/data -q", "record walk.yaml --out /proc/data -q",
                                "record matrix.yaml --out walk.yaml/data -q"}) {
    const ProgramResult result = Run(arguments);
    EXPECT_EQ(result.exit_code, 4) << arguments << ": " << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  }
  fs::create_directories(File("other"));
  std::ofstream(File("other/notes.txt")) << "mine\n";
  const ProgramResult other = Run("record matrix.yaml --out other -q");
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err, HasSubstr("holds something else"));
}

TEST_F(RecordMatrixTest, ABadMatrixIsNamedWithItsLineAndWritesNothing) {
  const auto refused = [&](const std::string& yaml, const std::string& fragment) {
    std::ofstream(File("bad.yaml")) << yaml;
    const ProgramResult result = Run("record bad.yaml --out bad");
    EXPECT_EQ(result.exit_code, 2) << yaml;
    EXPECT_THAT(result.err, HasSubstr(fragment));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_FALSE(fs::exists(File("bad"))) << yaml;
  };
  const std::string base = "base: walk.yaml\n";
  refused(base + "axis: {}\n", "bad.yaml:2:1: axis: unknown key; did you mean axes?");
  refused(base + "axes: {camera.exposure_ms: []}\n",
          "bad.yaml:2:28: axes.camera.exposure_ms: expected a list of at least");
  refused(base + "axes: {camera.exposure_ms: [5, 900]}\n", "900");
  refused(base + "axes: {camera.exposure_ms: [5]}\nseeds: 0\n", "bad.yaml:3:8: seeds: expected a number of seeds");
  refused(base + "axes: {camera.exposure_ms: [5]}\nseeds: 200000\n", "more than 100000 are done only with --yes");
  refused(base + "axes: {camera.exposure_ms: [5]}\nformat: kitti\n", "bad.yaml:3:9: format:");
  refused(base + "axes: {camera.exposure_ms: [5]}\npairs: {gap: 0}\n", "bad.yaml:3:14: pairs.gap: 0 is not permitted");
  refused(base + "axes: {system: [sift_vo, mobif_vo]}\n", "film the same");
  refused(base + "axes: {gait.step_length_m: [0.04, 0.3]}\n", "0.3");
  refused("base: nowhere.yaml\naxes: {camera.exposure_ms: [5]}\n", "nowhere.yaml");
}

TEST_F(RecordMatrixTest, ASingleScenarioHasPairsAndPicturesIfAsked) {
  const ProgramResult result = Run("record walk.yaml --out one --pairs --preview");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("20 frames, 2 pairs; the walk finished at 2.00 s; blur"));
  for (const char* name : {"pairs/pairs.csv", "preview.mp4", "contact_sheet.png"})
    EXPECT_TRUE(fs::exists(File("one/walk-truth") / name)) << name;
  EXPECT_EQ(Run("validate one").exit_code, 0);
}

TEST_F(RecordMatrixTest, ShippedMatricesAreValid) {
  for (const auto& entry : fs::directory_iterator(TestData() / "scenarios" / "matrices")) {
    const ProgramResult result = Run("validate " + entry.path().string());
    EXPECT_EQ(result.exit_code, 0) << entry.path() << result.err;
  }
}

}  // namespace
}  // namespace gaitcam
