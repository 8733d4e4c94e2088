// `gaitcam experiment`: a program of its own, its options, and that a table names the command that makes it.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <regex>

#include "algorithms/io/dataset_reader.h"
#include "scenarios/code/experiments/perturbed_stream.h"
#include "scenarios/code/experiments/photographs.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "tests/scenarios/program.h"
#include "tests/scenarios/tiny_walk.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

int Lines(const std::string& text) { return int(std::count(text.begin(), text.end(), '\n')); }

class ExperimentProgramTest : public testing::Test {
 protected:
  ProgramResult Run(const std::string& words) const {
    const std::string data = "GAITCAM_DATA=" + TestData().string() + " ";
    return RunShell(data + (fs::path(Program()).parent_path() / "gaitcam_experiments").string() + " " + words,
                    temporary_.path());
  }
  fs::path File(const std::string& name) const { return temporary_.path() / name; }

  /// A photograph and the same 40 px to the left, in the layout of the Oxford data set.
  void WritePair(const std::string& name) const {
    const cv::Mat picture = PackagedPhotograph("home.jpg");
    fs::create_directories(File(name));
    cv::imwrite((File(name) / "img1.png").string(), picture(cv::Rect(100, 60, 300, 240)));
    cv::imwrite((File(name) / "img2.png").string(), picture(cv::Rect(140, 60, 300, 240)));
    std::ofstream(File(name) / "H1to2p") << "1 0 -40\n0 1 0\n0 0 1\n";
  }

  const TemporaryFolder temporary_;
};

TEST_F(ExperimentProgramTest, ListsEveryExperimentAndHelpsWithExamples) {
  const ProgramResult list = Run("--list");
  EXPECT_EQ(list.exit_code, 0) << list.err;
  for (const ExperimentEntry& entry : ListExperiments()) {
    EXPECT_THAT(list.out, HasSubstr(entry.name));
    const ProgramResult help = Run(entry.name + " --help");
    EXPECT_EQ(help.exit_code, 0) << help.err;
    EXPECT_THAT(help.out, HasSubstr("Examples:\ngaitcam ")) << entry.name;
    EXPECT_THAT(help.out, HasSubstr("--out")) << entry.name;
  }
}

TEST_F(ExperimentProgramTest, TheProgramHandsItsWordsOnAndRefusesTheOldVerb) {
  const ProgramResult list = RunProgram("experiment --list", temporary_.path());
  EXPECT_EQ(list.exit_code, 0) << list.err;
  EXPECT_EQ(list.out, Run("--list").out);
  EXPECT_THAT(RunProgram("experiment psf --help", temporary_.path()).out, HasSubstr("--frames"));
  const ProgramResult old = RunProgram("features --seed 2", temporary_.path());
  EXPECT_EQ(old.exit_code, 2);
  EXPECT_EQ(old.err, "gaitcam: features: is now gaitcam experiment features\n");
}

TEST_F(ExperimentProgramTest, ASlipIsOneLineAndExitTwoAndNothingIsWritten) {
  for (const auto& [words, fragment] : {std::pair{"", "gaitcam experiment --list"},
                                        {"featurs", "featurs"},
                                        {"planes --pairs 0", "--pairs: 0 is not permitted"},
                                        {"planes --pairs many", "many"},
                                        {"crowds --pairs 0", "--pairs: 0 is not permitted"},
                                        {"crowds --scene labb", "labb"},
                                        {"crowds --detector syft", "syft"},
                                        {"loops", "at least one folder of a recorded walk"},
                                        {"loops nowhere", "nowhere"},
                                        {"loops nowhere --words 1", "--words: 1 is not permitted"},
                                        {"loops nowhere --over a --over b --over c", "at most two keys"},
                                        {"nees --repeats 0", "--repeats: 0 is not permitted"},
                                        {"nees --scene labb", "labb"},
                                        {"localisation --set duration=1", "duration"},
                                        {"localisation --seeds 0", "--seeds: 0 is not permitted"},
                                        {"localisation --prefilter wide", "--prefilter: \"wide\" is no number"},
                                        {"localisation --prefilter 9", "--prefilter: 9 is not permitted"},
                                        {"peers", "at least one folder of a recorded walk"},
                                        {"peers nowhere --system sift_vo", "nowhere"},
                                        {"peers nowhere --system sift_v", "sift_vo"},
                                        {"speed nowhere", "nowhere"},
                                        {"speed --frames 0", "--frames: 0 is not permitted"},
                                        {"speed --only crowds", "--only: \"crowds\" is not permitted"},
                                        {"speed --only quick_start", "--before"},
                                        {"stress", "at least one --system"},
                                        {"stress --system sift_v", "sift_vo"},
                                        {"stress --system sift_vo --kinds black,balck", "did you mean"},
                                        {"stress --system sift_vo --kinds ,", "names no kind"},
                                        {"stress --system sift_vo --seeds 0", "--seeds: 0 is not permitted"},
                                        {"stress --system sift_vo --score drift", "\"drift\" is not"},
                                        {"stress --system sift_vo --recording nowhere", "nowhere"},
                                        {"tracking_time nowhere", "nowhere"},
                                        {"tracking_time --system mobif_v", "mobif_v"},
                                        {"walking --robot khr1v", "khr1v"},
                                        {"features nowhere", "nowhere"},
                                        {"features --kernels --detector sift", "--detector: not with --kernels"},
                                        {"features --kernels --strongest 500", "--strongest: not with --kernels"},
                                        {"features --detector syft", "syft"}}) {
    const ProgramResult result = Run(words);
    EXPECT_EQ(result.exit_code, 2) << words << ": " << result.err;
    EXPECT_THAT(result.err, HasSubstr(fragment));
    EXPECT_EQ(Lines(result.err), 1) << result.err;
    EXPECT_TRUE(fs::is_empty(temporary_.path())) << words;
  }
}

TEST_F(ExperimentProgramTest, LocalisationIsWhatRunMeasuresForEachSeedAndGaussian) {
  std::ofstream(File("places.yaml")) << "robot: khr1hv_pan\nscene: robocup_field\n"
                                        "path: {head_tilt_rad: 0, settle_s: 0.4}\n"
                                        "camera: {width_px: 104, height_px: 80, hfov_deg: 56.9, rate_hz: 4, "
                                        "pitch_deg: 0, exposure_ms: 5, fixed_subframes: 1}\n"
                                        "localisation: {columns: 2, rows: 2, field_m: [2.7, 1.8], queries: 5, "
                                        "panorama_width_px: 360, panorama_height_px: 80, methods: [wavelet, fourier], "
                                        "wavelet: {level: 3}, occlusions: [], lights: [], walk_exposures_ms: []}\n";
  const std::string cache = "export XDG_CACHE_HOME=$PWD/cache GAITCAM_DATA=" + TestData().string() + "; ";
  const ProgramResult table = RunShell(cache + Program() +
                                           " experiment localisation places.yaml --seed 7 --seeds 2 --prefilter 1.5 "
                                           "--out places/table.md -q",
                                       temporary_.path());
  ASSERT_EQ(table.exit_code, 0) << table.err;
  std::string rows =
      "seed,method,condition,found_ratio,bearing_error_median_deg,position_error_median_m,"
      "peak_area_ratio,peak_area_range_ratio,modes\n";
  for (const int seed : {7, 8}) {
    for (const std::string method : {"wavelet", "fourier", "wavelet_1.5"}) {
      const bool is_wider = method.ends_with("1.5");
      const std::string run = fmt::format(" run places.yaml --seed {} --out {}{} -q {}", seed, method, seed,
                                          is_wider ? "--set localisation.wavelet.prefilter=1.5" : "");
      ASSERT_EQ(RunShell(cache + Program() + run, temporary_.path()).exit_code, 0);
      const nlohmann::json json =
          nlohmann::json::parse(ReadText(File(fmt::format("{}{}", method, seed)) / "scores.json"));
      rows += fmt::format("{},{},plain", seed, method);
      for (const char* score : {"found_ratio", "bearing_error_median_deg", "position_error_median_m", "peak_area_ratio",
                                "peak_area_range_ratio", "modes"}) {
        const std::string name = (is_wider ? "wavelet" : method) + "_plain_" + score;
        rows += fmt::format(",{:.5g}", json["scores"][name].get<double>());
      }
      rows += "\n";
    }
  }
  EXPECT_EQ(ReadText(File("places/table.csv")), rows);
  EXPECT_THAT(ReadText(File("places/table.md")), testing::ContainsRegex("\\| wavelet_1.5 \\| [0-9.]+ \\([0-9.]+ to"));
}

TEST_F(ExperimentProgramTest, LoopsAsksEveryMemoryAlongARecordedWalkAndLearnsFromOthersOnly) {
  RecordTinyWalk(File("here"), "tum");
  RecordTinyWalk(File("there"), "tum", {"path.direction=right"});
  // Within 2 s the robot is where it was: any view may be any other's place. A place is any view but the first.
  const std::string words = "loops here/walk --apart-s 0 --every-s 0.1 --same-heading-deg 180 --words 5 ";
  const ProgramResult alone = Run(words + "--out alone.md");
  EXPECT_EQ(alone.exit_code, 0) << alone.err;
  EXPECT_THAT(ReadText(File("alone.md")), testing::ContainsRegex("\\| walk \\| pirf_nav \\| 20 \\| 19 \\|"));
  EXPECT_EQ(ReadText(File("alone.md")).find("| fab_map"), std::string::npos);
  const ProgramResult taught = Run(words + "--train there/walk --train here/walk --out taught.md");
  EXPECT_EQ(taught.exit_code, 0) << taught.err;
  const std::string table = ReadText(File("taught.md"));
  EXPECT_THAT(table, HasSubstr("5 words learned from 20 views"));  // of the other walk alone
  for (const std::string method : {"icgm_slam, double", "bag_of_words", "fab_map, sampled"})
    EXPECT_THAT(table, HasSubstr("| walk | " + method + " | 20 | 19 | "));
  EXPECT_THAT(ReadText(File("taught.csv")),
              HasSubstr("walk,method,threshold,right,wrong,precision,recall\n\"walk\",\"pirf"));
  // A later walk is asked about: all of its views, the first too, may show a place that was learned.
  const ProgramResult later = Run(words + "--test there/walk --out later.md");
  EXPECT_EQ(later.exit_code, 0) << later.err;
  EXPECT_THAT(ReadText(File("later.md")), testing::ContainsRegex("\\| walk, walk \\| pirf_nav \\| 20 \\| 20 \\|"));
  EXPECT_THAT(ReadText(File("later.md")), HasSubstr("nothing more is learned"));
  EXPECT_THAT(ReadText(File("later.csv")), HasSubstr("\n\"walk, walk\",\"pirf"));
  const ProgramResult untaught = Run(words + "--test there/walk --train there/walk --train here/walk --out no.md");
  EXPECT_EQ(untaught.exit_code, 2);  // no view is left to learn words from
  EXPECT_EQ(Lines(untaught.err), 1) << untaught.err;
  // By default 20 s must lie between two visits.
  EXPECT_EQ(Run("loops here/walk").exit_code, 3);
}

// A program of somebody's that says the truth scores no error; one that fails has a row that says so.
TEST_F(ExperimentProgramTest, PeersScoresEverySystemOnEveryRecording) {
  RecordTinyWalk(File("here"), "tum");
  RecordTinyWalk(File("there"), "tum", {"path.direction=right"});
  for (const char* place : {"here", "there"}) {
    fs::copy(File(place) / "walk-truth/groundtruth.txt", File(std::string(place) + ".txt"));
  }
  std::ofstream(File("knows.sh")) << "cp " + File("here.txt").string() + " \"$2\"\n";
  const std::string knows = "'{command: [sh, " + File("knows.sh").string() +
                            ", \"{dataset}\", \"{output}\"], depends: [" + File("here.txt").string() + "]}'";
  const ProgramResult result =
      Run("peers here/walk there/walk --system stereo_vo --system " + knows + " --out peers.md");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::string table = ReadText(File("peers.md"));
  EXPECT_THAT(table, HasSubstr("gaitcam experiment peers"));
  EXPECT_THAT(table, testing::ContainsRegex("\\| there/walk \\| `stereo_vo` \\| - \\|.*stereo"))
      << "one camera is not enough";
  EXPECT_THAT(table, testing::ContainsRegex("\\| here/walk \\| `.command.*\\| 100 \\| - \\| 0.0 \\| 0.0 \\|"));
  EXPECT_THAT(table, testing::ContainsRegex("\\| 2 of 2 \\| `.command.*100 .100 to 100."));
  EXPECT_THAT(table, HasSubstr("| 0 of 2 | `stereo_vo` |"));
}

// A program that knows the truth and refuses fewer than 15 images fails exactly where fewer arrive.
TEST_F(ExperimentProgramTest, StressFindsTheLevelAtWhichASystemFails) {
  const DatasetFolders folders = RecordTinyWalk(File("here"), "tum");
  fs::copy(folders.truth / "groundtruth.txt", File("truth.txt"));
  std::ofstream(File("knows.sh")) << "[ $(ls \"$1\"/rgb | wc -l) -ge 15 ] && cp " + File("truth.txt").string() +
                                         " \"$2\"\n";
  const std::string knows = "'{command: [sh, " + File("knows.sh").string() +
                            ", \"{dataset}\", \"{output}\"], depends: [" + File("truth.txt").string() + "]}'";
  const std::string words =
      "stress --recording here/walk --kinds dropped,focal_length --seeds 1 --halvings 4 --system ";
  const ProgramResult result =
      Run(words + knows + " --system '{command: [\"false\", \"{dataset}\", \"{output}\"]}' --out stress.md");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string table = ReadText(File("stress.md"));
  RecordedStream clean;
  DatasetReader reader(folders.sensors);
  while (const auto observation = reader.Next()) clean.frames.push_back({*observation, observation->stamp_ns});
  double level = 0;
  for (size_t images = 20; images >= 15; images = Perturbed(clean, PerturbationKind::kDropped, level, 1).frames.size())
    level += InfoOf(PerturbationKind::kDropped).largest / 16;
  // The other fails on the recording as it is.
  EXPECT_THAT(table, HasSubstr(fmt::format("| dropped | % of the frames | {:.3g} s | - |", level)));
  EXPECT_THAT(table, HasSubstr("| focal_length | % | > 50 | - |"));
  EXPECT_THAT(table, testing::ContainsRegex("\\| `.command: .sh, .*` \\| 100 \\| 0.0 \\|"));
  EXPECT_THAT(ReadText(File("stress.csv")), HasSubstr(",dropped,1,95,stopped,"));
  EXPECT_THAT(Run(words + "stereo_vo").err, HasSubstr("stereo_vo needs a stereo camera"));
}

TEST_F(ExperimentProgramTest, LoopsSumUpOverWhatTheWalksScenariosDifferIn) {
  RecordTinyWalk(File("left"), "tum", {"camera.exposure_ms=5"});
  RecordTinyWalk(File("right"), "tum", {"camera.exposure_ms=5", "path.direction=right"});
  RecordTinyWalk(File("long"), "tum", {"camera.exposure_ms=20"});
  const std::string words = "loops left/walk right/walk long/walk --apart-s 0 --every-s 0.1 --same-heading-deg 180 ";
  const ProgramResult result = Run(words + "--over camera.exposure_ms --out sum.md");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string table = ReadText(File("sum.md"));
  // Two walks agree in 5 ms, one has 20 ms; and the longer exposure blurs more.
  std::smatch five, twenty;
  ASSERT_TRUE(std::regex_search(table, five, std::regex("\\| 5 \\| ([0-9.]+) \\| icgm_slam, double \\| 2 \\|")));
  ASSERT_TRUE(std::regex_search(table, twenty, std::regex("\\| 20 \\| ([0-9.]+) \\| icgm_slam, double \\| 1 \\|")));
  EXPECT_GT(std::stod(twenty[1]), std::stod(five[1]));
  EXPECT_FALSE(cv::imread(File("sum.png").string()).empty());
  EXPECT_THAT(ReadText(File("sum_walks.csv")), HasSubstr("\"walk\",\"pirf_nav\",20,"));
  for (const auto& [key, fragment] : {std::pair{"camera.exposure", "scenario.yaml"},
                                      {"robot", "\"khr1hv\" is not a number"},
                                      {"path", "no single number or word"}}) {
    const ProgramResult slip = Run(words + "--over " + key + " --out slip.md");
    EXPECT_EQ(slip.exit_code, 2) << slip.err;
    EXPECT_THAT(slip.err, HasSubstr(fragment));
    EXPECT_EQ(Lines(slip.err), 1) << slip.err;
  }
}

TEST_F(ExperimentProgramTest, ATableNamesTheCommandThatMakesItAgain) {
  WritePair("shifted");
  const ProgramResult first = Run("features shifted --detector sift --seed 3 --out first/table.md -j 2");
  ASSERT_EQ(first.exit_code, 0) << first.err;
  for (const char* name : {"table.md", "table.json", "table.png"}) EXPECT_TRUE(fs::exists(File("first") / name));
  const std::string table = ReadText(File("first/table.md"));
  EXPECT_THAT(first.out, HasSubstr(table));
  std::smatch made_by;
  ASSERT_TRUE(std::regex_search(table, made_by, std::regex("Made by `gaitcam experiment ([^`]*)`")));
  EXPECT_EQ(made_by[1], "features shifted --detector sift --seed 3 --out first/table.md");
  ASSERT_EQ(Run(made_by[1].str() + " -q").exit_code, 0);
  EXPECT_EQ(ReadText(File("first/table.md")), table);
}

TEST_F(ExperimentProgramTest, NeesIsNearOneForPointsThatAreNear) {
  const ProgramResult result = Run("nees --repeats 2 --trials 5 --steps 2 --out nees.md -q");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(File("nees.png")));
  const std::string table = ReadText(File("nees.md"));
  std::smatch row;
  ASSERT_TRUE(std::regex_search(
      table, row, std::regex("one point at 1 to 4 m, 300 samples \\|[^|]*\\| [0-9.]+ \\|.* ([0-9.]+) \\|\n")));
  // Two sums of 900 squared normals: a mean's standard deviation is 0.033.
  EXPECT_NEAR(std::stod(row[1]), 1, 0.14);
}

TEST_F(ExperimentProgramTest, SpeedMeasuresOnlyTheSectionsThatAreWanted) {
  const ProgramResult result = Run("speed --only crowd --people 1 --frames 1 --out speed.md -q");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string table = ReadText(File("speed.md"));
  EXPECT_THAT(table, HasSubstr("gaitcam experiment speed --only crowd --frames 1 --people 1"));
  EXPECT_THAT(table, HasSubstr("\n## A crowd\n"));
  EXPECT_THAT(table, HasSubstr("| lab_loop, 1 people |"));
  EXPECT_EQ(table.find("\n## "), table.rfind("\n## ")) << table;
}

TEST_F(ExperimentProgramTest, SpeedFilmsAllShippedWalksAlsoThoseOfSystemsThatNeedAMap) {
  const ProgramResult result = Run("speed --only light --frames 1 --longest-s 1 --out speed.md -q");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string table = ReadText(File("speed.md"));
  for (const char* walk : {"quickstart", "cafeteria_navigate", "nimbro_navigate"}) {
    EXPECT_THAT(table, HasSubstr("\n| " + std::string(walk) + " | "));
  }
}

TEST_F(ExperimentProgramTest, CrowdsFilmsJudgesAndDraws) {
  const ProgramResult result = Run("crowds --pairs 2 --walk 3 --scene lab --detector sift --out crowds.md -q");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* name : {"crowds.png", "crowds_matches.png"}) EXPECT_TRUE(fs::exists(File(name))) << name;
  const std::string table = ReadText(File("crowds.md"));
  const auto precision = [&](const std::string& filter) {
    std::smatch row;
    const std::regex line("still \\| sift \\| [^|]*\\| " + filter + " \\|[^|]*\\| ([0-9.]+) \\(");
    EXPECT_TRUE(std::regex_search(table, row, line)) << table;
    return row.empty() ? 0 : std::stod(row[1]);
  };
  EXPECT_GT(precision("consensus, 0.12"), precision("none"));
  EXPECT_THAT(table, HasSubstr("\n## Single and double direction\n"));
}

TEST(ExperimentCommand, NamesWhatDiffersFromTheDefaultsAndNoUsersFolder) {
  for (const ExperimentEntry& entry : ListExperiments()) {
    const auto experiment = entry.make();
    EXPECT_EQ(ExperimentCommand(entry, *experiment), "gaitcam experiment " + entry.name);
    for (const ExperimentOption& option : experiment->Options().options) {
      if (auto* const* paths = std::get_if<InputPaths*>(&option.value)) (*paths)->paths = {"/home/me/data/", "a/../b"};
      if (auto* const* flag = std::get_if<bool*>(&option.value)) **flag = true;
    }
    const std::string command = ExperimentCommand(entry, *experiment);
    EXPECT_THAT(command, testing::Not(HasSubstr("/home"))) << entry.name;
    EXPECT_EQ(command == "gaitcam experiment features data b --walk-alone --kernels", entry.name == "features")
        << command;
  }
}

TEST(InParallel, DoesEachOnceAndThrowsWhatFails) {
  for (const int jobs : {0, 1, 3, 200}) {
    std::vector<int> times(100, 0);
    InParallel(100, jobs, [&](int i) { ++times[size_t(i)]; });
    EXPECT_THAT(times, testing::Each(1)) << jobs;
  }
  InParallel(0, 2, [](int) { FAIL() << "there is nothing to do"; });
  int begun = 0;
  const auto fails_at_four = [&](int i) {
    ++begun;
    if (i == 4) throw std::runtime_error("four");
  };
  EXPECT_THROW(InParallel(10, 1, fails_at_four), std::runtime_error);
  EXPECT_EQ(begun, 5) << "what comes after it is not begun";
  EXPECT_THROW(InParallel(10, 2,
                          [](int i) {
                            if (i == 4) throw std::runtime_error("four");
                          }),
               std::runtime_error);
}

}  // namespace
}  // namespace gaitcam
