#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/io/dataset_reader.h"
#include "algorithms/io/whole_file.h"
#include "algorithms/places/bag_of_words.h"
#include "algorithms/places/fab_map.h"
#include "algorithms/slam/appearance_slam.h"
#include "results/scoring/loop_recall.h"
#include "scenarios/code/experiments/loop_groups.h"
#include "scenarios/code/experiments/processor_time.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/runs/recorded_walk.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

struct LoopTableOptions {
  InputPaths walks;
  std::vector<std::string> test;
  std::vector<std::string> train;
  std::vector<std::string> over;
  int words = 1000;
  ViewOptions views;
  LoopTruthOptions truth;
  uint64_t seed = 1;
};

template <class Visitor>
void VisitFields(Visitor& visit, LoopTableOptions& o) {
  visit("walks", o.walks, Nested(), "recorded folders of walks that come back to where they were");
  visit("test", o.test, Nested(),
        "recorded folder of a later walk, whose views are asked about when one of the others was learned; nothing is "
        "learned from it");
  visit("train", o.train, Nested(),
        "recorded folder of another scene, to learn words from; only fab_map and bag_of_words "
        "learn, and the folders of the walk itself and of later ones are left out");
  visit("over", o.over, Nested(),
        "key of the walks' scenarios, such as crowd.count, over which medians of the walks that agree in it are "
        "tabled and drawn; a second one tells lines apart");
  visit("words", o.words, Between(2, 100000), "of the vocabulary");
  visit("seed", o.seed, Between(0, 1e15), "of the vocabulary");
  VisitFields(visit, o.views);
  VisitFields(visit, o.truth);
}

/// A recorded walk, its views' features, and where they were taken.
struct Film {
  std::string name;
  double blur_px = 0;
  std::vector<std::string> levels;  ///< Of the keys of a summary.
  std::vector<Observation> views;
  std::vector<Pose> X_WC;
};

/// Frames at least `every_s` apart. @param over keys of the recorded scenario. @throws BadInput without truth.
Film ReadFilm(const fs::path& folder, double every_s, const std::vector<std::string>& over = {}) {
  const fs::path sensors = FindDataset(folder);
  const DatasetFolders folders{sensors, sensors.string() + "-truth"};
  std::map<int64_t, Pose> truth;
  const RecordedWalk walk = ReadRecordedWalk(folders);
  for (const RecordedFrame& frame : walk.frames) truth[frame.stamp_ns] = frame.X_WC;
  Film film;
  film.blur_px = SummariseBlur(walk).median_px;
  if (!over.empty()) film.levels = LevelsOf(folders.truth / "scenario.yaml", over);
  film.name = folder.lexically_normal().filename().string();
  DatasetReader reader(sensors);
  while (auto observation = reader.Next()) {
    const auto pose = truth.find(observation->stamp_ns);
    if (pose == truth.end()) continue;
    if (!film.views.empty() && double(observation->stamp_ns - film.views.back().stamp_ns) * 1e-9 < every_s - 1e-3)
      continue;
    film.views.push_back(*observation);
    film.X_WC.push_back(pose->second);
  }
  if (film.views.empty()) throw BadInput(folder.string() + ": has no frame of which the true pose is recorded");
  return film;
}

void Track(const Film& film, AppearanceSlam& slam) {
  for (const Observation& view : film.views) slam.Track(view);
}

/// @param later null: the film's own views are asked about, as they are learned; otherwise those of a later film.
LoopOutcome Recognise(const Film& film, const Film* later, const std::string& method, AppearanceSlam& slam,
                      const LoopTableOptions& options) {
  const Film& asked = later ? *later : film;
  if (later) {
    Track(film, slam);
    slam.StopLearning();
  }
  const double before_ms = ProcessorTime_ms();
  Track(asked, slam);
  slam.Finish();
  LoopOutcome outcome;
  outcome.walk = later ? film.name + ", " + later->name : film.name;
  outcome.method = method;
  outcome.blur_px = asked.blur_px;
  outcome.levels = asked.levels;
  outcome.views = int(asked.views.size());
  outcome.ms_per_view = (ProcessorTime_ms() - before_ms) / double(asked.views.size());
  outcome.bytes_per_place = double(slam.graph().nodes.back().bytes);
  const size_t first_asked = later ? film.views.size() : 0;
  std::vector<Pose> X_WC = film.X_WC;
  if (later) X_WC.insert(X_WC.end(), later->X_WC.begin(), later->X_WC.end());
  std::vector<LoopAnswer> answers(first_asked);
  for (size_t view = first_asked; view < slam.tests().size(); ++view) {
    const AppearanceTest& test = slam.tests()[view];
    answers.push_back({test.place, test.confidence, test.first_places});
  }
  const std::vector<LoopDecision> decisions = JudgeLoops(answers, X_WC, options.truth);
  for (size_t view = first_asked; view < decisions.size(); ++view) {
    outcome.accepted += slam.tests()[view].known;
    outcome.right += slam.tests()[view].known && decisions[view].right;
  }
  outcome.curve = PrecisionRecallOf(decisions);
  return outcome;
}

std::string Percent(int part, int whole) { return whole == 0 ? "-" : fmt::format("{:.1f}", 100.0 * part / whole); }

std::string Row(const LoopOutcome& o) {
  return fmt::format("| {} | {} | {} | {} | {} | {} | {} | {:.3f} | {:.1f} | {:.1f} | {:.1f} |\n", o.walk, o.method,
                     o.views, o.curve.possible, o.accepted, Percent(o.right, o.accepted),
                     Percent(o.right, o.curve.possible), o.curve.area, 100 * o.curve.recall_at_full_precision,
                     o.ms_per_view, o.bytes_per_place / 1000);
}

/// Every memory of places on the same recorded walks: what it recognises, and what it takes for another place.
class LoopTable : public ExperimentOf<LoopTableOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    if (options_.walks.paths.empty()) throw BadInput("walks: name at least one folder of a recorded walk");
    if (options_.over.size() > 2) throw BadInput("--over: at most two keys, an axis and lines over it");
    command_ = setup.command;
    cv::setNumThreads(1);  // times are one thread's
    std::vector<Film> later;
    for (const std::string& path : options_.test)
      later.push_back(ReadFilm(path, options_.views.every_s, options_.over));
    for (const std::string& path : options_.walks.paths) {
      const Film film = ReadFilm(path, options_.views.every_s, options_.over);
      std::vector<const Film*> asked;
      for (const Film& test : later) asked.push_back(&test);
      if (asked.empty()) asked.push_back(nullptr);
      const std::vector<Method> methods = Methods(path);
      for (const Film* test : asked) {
        for (const auto& [method, make] : methods) {
          outcomes_.push_back(Recognise(film, test, method, *make(), options_));
          if (!setup.quiet) fmt::print(stderr, "{}", Row(outcomes_.back()));
        }
      }
    }
    WriteWholeFile(fs::path(setup.table).replace_extension(".csv"), Curves());
    if (!options_.over.empty()) WriteSummary(setup.table);
  }
  std::string Table() const override {
    std::string text = fmt::format(
        "# Places recognised along a walk\n\nMade by `{}`.\n\nEvery view is a place and is asked about before it "
        "becomes "
        "one; views of the last {:g} s cannot be the answer. An answer is right where the view was taken within {:g} m "
        "and {:g} degrees of the place that it names; of so many views a right answer was possible. Precision and "
        "recall "
        "are those of the loops that a method accepts by its default threshold; area and recall at 100 % precision are "
        "over all thresholds, the surest answer first. ms: one thread's processor time per view, features, question "
        "and learning together. kB: of a place, without the vocabulary. fab_map and bag_of_words have {} words learned "
        "from {} views of other walks. These two, and `all features`, take every feature of a view; the others those "
        "that neighbouring views show too.{}\n\n",
        command_, options_.views.apart_s, options_.truth.same_place_m, options_.truth.same_heading_deg, options_.words,
        training_views_,
        options_.test.empty() ? ""
                              : " Of two walks the first was learned, and each view of the second asked about: any "
                                "place of the first may be the answer, and nothing more is learned.");
    if (!options_.over.empty()) return text + Summary();
    text +=
        "| walk | method | views | possible | accepted | precision, % | recall, % | area | recall at 100 %, % | ms "
        "| kB |\n|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n";
    for (const LoopOutcome& outcome : outcomes_) text += Row(outcome);
    return text;
  }

 private:
  using Method = std::pair<std::string, std::function<std::unique_ptr<AppearanceSlam>()>>;

  template <class Options>
  Method Of(const std::string& name, Options options) const {
    options.views = options_.views;
    return {name, [options, seed = options_.seed] { return std::make_unique<AppearanceSlam>(options, seed); }};
  }
  Method OfMemory(const std::string& name, const std::function<std::unique_ptr<PlaceMemory>()>& make) const {
    return {name, [this, make] {
              return std::make_unique<AppearanceSlam>(make(), options_.views, RobustViewOptions(), options_.seed);
            }};
  }

  std::vector<Method> Methods(const std::string& walk) {
    PirfNavSlamOptions plain;
    plain.robust.robust = Robustness::kNone;
    IcgmSlamOptions both_ways;
    both_ways.robust.icgm.direction = IcgmDirection::kDouble;
    std::vector<Method> methods{Of("pirf_nav", PirfNavSlamOptions()), Of("pirf_nav, all features", plain),
                                Of("icgm_slam, single", IcgmSlamOptions()), Of("icgm_slam, double", both_ways)};
    if (options_.train.empty()) return methods;
    const FabMapModel model = Learn(walk);
    methods.push_back(OfMemory("bag_of_words", [model]() -> std::unique_ptr<PlaceMemory> {
      return std::make_unique<BagOfWords>(model.vocabulary, model.samples);
    }));
    for (const NewPlaceModel new_place : {NewPlaceModel::kSampled, NewPlaceModel::kMeanField}) {
      methods.push_back(
          OfMemory("fab_map, " + std::string(ToWord(new_place)), [model, new_place]() -> std::unique_ptr<PlaceMemory> {
            FabMapOptions options;
            options.new_place_model = new_place;
            return std::make_unique<FabMap>(model, options);
          }));
    }
    return methods;
  }

  void WriteSummary(const fs::path& table) {
    const std::string stem = table.stem().string();
    picture_ = stem + ".png";
    const fs::path file = table.parent_path() / picture_;
    if (!cv::imwrite(file.string(), DrawLoopGroups(options_.over, outcomes_)))
      throw MissingResource(file.string() + ": cannot be written");
    WriteWholeFile(table.parent_path() / (stem + "_walks.csv"), LoopOutcomeRows(options_.over, outcomes_));
  }
  std::string Summary() const {
    return "Medians (lowest to highest) over the walks that agree; precision: over those with an accepted loop. Blur: "
           "median over walks and frames of a frame's median path of an image point while the shutter is open.\n\n" +
           LoopGroupTable(options_.over, outcomes_) +
           fmt::format("\n![Medians, and all walks between]({})\n", picture_);
  }

  /// From all training walks but the one that is asked about.
  FabMapModel Learn(const std::string& walk) {
    std::vector<std::string> others;
    for (const std::string& path : options_.train) {
      const auto is = [&](const std::string& other) { return fs::equivalent(path, other); };
      if (!is(walk) && std::none_of(options_.test.begin(), options_.test.end(), is)) others.push_back(path);
    }
    auto known = learned_.find(others);
    if (known == learned_.end()) known = learned_.emplace(others, LearnFrom(others)).first;
    training_views_ = known->second.views;
    return known->second.model;
  }
  struct Learned {
    FabMapModel model;
    size_t views;
  };
  Learned LearnFrom(const std::vector<std::string>& walks) const {
    const cv::Ptr<cv::Feature2D> detector = MakeFeature2d(options_.views.feature);
    std::vector<cv::Mat> descriptors;
    for (const std::string& path : walks)
      for (const Observation& view : ReadFilm(path, options_.views.every_s).views)
        descriptors.push_back(DetectFeatures(*detector, view.image.pixels, options_.views.max_features).descriptors);
    return {LearnFabMapModel(descriptors, options_.words, options_.seed), descriptors.size()};
  }

  /// Every point of every curve.
  std::string Curves() const {
    std::string text = "walk,method,threshold,right,wrong,precision,recall\n";
    for (const LoopOutcome& o : outcomes_) {
      for (const PrecisionRecallPoint& p : o.curve.curve) {
        text += fmt::format("\"{}\",\"{}\",{:.6g},{},{},{:.4f},{:.4f}\n", o.walk, o.method, p.threshold, p.right,
                            p.wrong, p.precision, p.recall);
      }
    }
    return text;
  }

  std::string command_, picture_;
  size_t training_views_ = 0;
  std::map<std::vector<std::string>, Learned> learned_;  ///< By the walks that it was learned from.
  std::vector<LoopOutcome> outcomes_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakeLoopTable() { return std::make_unique<LoopTable>(); }

}  // namespace gaitcam
