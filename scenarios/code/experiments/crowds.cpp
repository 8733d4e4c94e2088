#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "algorithms/features/icgm.h"
#include "models/code/scenes/scene.h"
#include "results/scoring/statistics.h"
#include "scenarios/code/experiments/crowd_matches.h"
#include "scenarios/code/experiments/crowd_pictures.h"
#include "scenarios/code/experiments/crowd_views.h"
#include "scenarios/code/experiments/crowd_walks.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/runs/progress.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

struct CrowdsOptions {
  int pairs = 5;
  int walk = 12;
  double people = 15;
  double standing = 0;
  std::vector<std::string> scene;
  std::vector<std::string> detector;
  uint64_t seed = 1;
};

template <class Visitor>
void VisitFields(Visitor& visit, CrowdsOptions& o) {
  visit("pairs", o.pairs, Between(1, 1000), "of views, in each scene, with the camera still and moving");
  visit("walk", o.walk, Between(3, 1000), "views of a walk in each scene");
  visit("people", o.people, Between(0, 30), "per 100 square metres");
  visit("standing", o.standing, Between(0, 1), "share of the people who stand still over both views");
  visit("scene", o.scene, Nested(), "only this scene (default: lab, corridor, hall)");
  visit("detector", o.detector, Nested(), "only this detector (default: fast, harris, surf, sift, orb, mobif)");
  visit("seed", o.seed, Between(0, 1e15), "of scenes, people, places and ICGM's starts");
}

constexpr double kRate_deg_s = 40;  // of each of the camera's axes where it moves: a brisk walk's
constexpr int kLeastMatches = 20, kLeastRight = 10;
constexpr int kDraws = 3;  // of random starts, where F1 is compared

/// One scene, with the camera still or moving while it exposes.
struct CrowdSequence {
  std::string scene;
  bool moving = false;
  std::vector<JudgedMatches> judged;
  std::vector<cv::Mat> a, b;   ///< Views by pair.
  std::vector<double> people;  ///< By pair, the share of the first view that they fill.
};

std::string Quartiles(const std::vector<double>& values, double factor) {
  if (values.empty()) return "-";
  return fmt::format("{:.1f} ({:.1f} to {:.1f})", factor * MedianOf(values), factor * QuantileOf(values, 0.25),
                     factor * QuantileOf(values, 0.75));
}

class Crowds : public ExperimentOf<CrowdsOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    command_ = setup.command;
    if (options_.scene.empty()) options_.scene = {"lab", "corridor", "hall"};
    if (options_.detector.empty()) options_.detector = {"fast", "harris", "surf", "sift", "orb", "mobif"};
    for (const std::string& detector : options_.detector) MakeFeature2d(detector);  // refuses unknown ones
    for (const std::string& scene : options_.scene) ReadScene(scene, ModelsFolder());
    for (const std::string& scene : options_.scene)
      for (const bool moving : {false, true}) sequences_.push_back({scene, moving, {}, {}, {}, {}});
    Progress progress("pairs", int64_t(sequences_.size()) * options_.pairs, setup.quiet);
    // All on this thread: where two others had drawn (llvmpipe), the process ended with a broken heap.
    for (CrowdSequence& sequence : sequences_) Film(sequence, setup.jobs, progress);
    progress.Finish();
    FilmWalks();
    WritePictures(setup.table);
    table_ = Introduction() + FilterTable() + ThresholdTable() + CurveTable() + WalkTable(walks_, options_.walk) +
             PictureText();
  }

  std::string Table() const override { return table_; }

 private:
  CrowdOptions StageOptions(const std::string& scene, bool moving) const {
    CrowdOptions options;
    options.scene = scene;
    options.people_per_100_m2 = options_.people;
    options.standing = options_.standing;
    options.rate_deg_s = moving ? kRate_deg_s : 0;
    return options;
  }

  void Film(CrowdSequence& sequence, int jobs, Progress& progress) {
    CrowdStage stage(StageOptions(sequence.scene, sequence.moving), options_.seed);
    for (int i = 0; i < options_.pairs; ++i) {
      const CrowdPair pair = stage.Film(i);
      std::vector<JudgedMatches> judged(options_.detector.size());
      InParallel(int(judged.size()), jobs,
                 [&](int d) { judged[size_t(d)] = MatchViews(pair, options_.detector[size_t(d)]); });
      for (JudgedMatches& of_detector : judged) {
        of_detector.scene = sequence.scene;
        of_detector.moving = sequence.moving;
        of_detector.seed = options_.seed;
        of_detector.pair = i;
        sequence.judged.push_back(std::move(of_detector));
      }
      sequence.a.push_back(pair.a.grey);
      sequence.b.push_back(pair.b.grey);
      sequence.people.push_back(double(cv::countNonZero(pair.a.on_people)) / double(pair.a.on_people.total()));
      progress.Update(++filmed_);
    }
  }

  static bool IsScored(const JudgedMatches& judged) {
    return int(judged.matches.size()) >= kLeastMatches && judged.CountRight() >= kLeastRight;
  }

  /// Those of a detector that are scored. @param scene empty: of all.
  std::vector<const JudgedMatches*> Scored(const std::string& detector, bool moving,
                                           const std::string& scene = "") const {
    std::vector<const JudgedMatches*> scored;
    for (const CrowdSequence& sequence : sequences_) {
      if (sequence.moving != moving || (!scene.empty() && sequence.scene != scene)) continue;
      for (const JudgedMatches& judged : sequence.judged)
        if (judged.detector == detector && IsScored(judged)) scored.push_back(&judged);
    }
    return scored;
  }

  std::string Introduction() const {
    const CrowdOptions defaults;
    return fmt::format(
        "# Matches in crowds\n\nMade by `{}`. Source: Hua, sections 4.1 and 5.1.\n\nTwo views {} s apart, {} x {} "
        "px, {} degrees wide, exposed for {} ms, with a sensor's noise. Between them the camera goes {} to {} m and "
        "turns by {} degrees (standard deviation; {} about the other axes), people walk on ({} per 100 m2, {:.0f} % "
        "of them stand still), and {} boxes with pictures are put elsewhere. Places are drawn; those are left out "
        "from which half of the picture shows what is nearer than 1.5 m. *moving*: the camera turns at {} degrees/s "
        "(standard deviation, each axis) while it exposes.\n\nMatches: each other's nearest, ratio 0.8. *Right*: on "
        "something static, and within 3 px of where the renderer's depth puts the point. *Mover*: one end on a "
        "person, walking or not, or on a box that was moved; never right. Precision: right over kept. Recall: right "
        "and kept over right before the filter. A pair counts that has {} matches and {} right ones. The thresholds "
        "and the consensus were chosen on seed 901.\n\n",
        command_, defaults.interval_s, defaults.width_px, defaults.height_px, defaults.hfov_deg, defaults.exposure_ms,
        defaults.least_step_m, defaults.most_step_m, defaults.turn_deg, defaults.tilt_deg, options_.people,
        100 * options_.standing, defaults.things, kRate_deg_s, kLeastMatches, kLeastRight);
  }

  std::string FilterTable() const {
    std::string text =
        "## What filters keep\n\nPer cent, medians (quartiles) over the pairs. *Worst tenth*: the precision that a "
        "tenth of the pairs does not reach. *All pairs*: the precision of all kept matches together. *6 px*: the "
        "same, with 6 px for 3. *Movers*: their share in all kept. *Five points*: RANSAC with the true calibration, "
        "1.5 px.\n\n| camera | detector | pairs | filter | kept | precision | recall | worst tenth | all pairs | 6 "
        "px | movers |\n|---|---|---:|---|---:|---|---|---:|---:|---:|---:|\n";
    for (const bool moving : {false, true})
      for (const std::string& detector : options_.detector) {
        const auto scored = Scored(detector, moving);
        for (const MatchJudge& filter : CrowdFilters()) text += FilterRow(scored, filter, detector, moving);
      }
    return text + "\n";
  }

  static std::string FilterRow(const std::vector<const JudgedMatches*>& scored, const MatchJudge& filter,
                               const std::string& detector, bool moving) {
    std::vector<double> kept, precision, recall;
    FilterScore sum;
    for (const JudgedMatches* judged : scored) {
      const FilterScore score = ScoreOf(*judged, filter.keep(*judged));
      kept.push_back(score.kept);
      recall.push_back(score.Recall());
      if (score.kept > 0) precision.push_back(score.Precision());
      sum.kept += score.kept;
      sum.right += score.right;
      sum.near += score.near;
      sum.movers += score.movers;
    }
    const std::string pairs = precision.size() == scored.size()
                                  ? std::to_string(scored.size())
                                  : fmt::format("{}, none kept in {}", scored.size(), scored.size() - precision.size());
    return fmt::format("| {} | {} | {} | {} | {:.0f} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} |\n",
                       moving ? "moving" : "still", detector, pairs, filter.name, MedianOf(kept),
                       Quartiles(precision, 100), Quartiles(recall, 100), 100 * QuantileOf(precision, 0.1),
                       100 * sum.Precision(), 100 * sum.NearPrecision(),
                       100 * double(sum.movers) / std::max(1, sum.kept));
  }

  /// Mean over pairs and draws.
  static double MeanF1(const std::vector<const JudgedMatches*>& scored, const IcgmOptions& options) {
    const int draws = options.start == IcgmStart::kRandomPair ? kDraws : 1;
    double sum = 0;
    for (const JudgedMatches* judged : scored)
      for (int draw = 0; draw < draws; ++draw) sum += ScoreOf(*judged, KeepByIcgm(*judged, options, draw)).F1();
    return scored.empty() ? kNaN : sum / double(draws * int(scored.size()));
  }

  std::string ThresholdTable() const {
    std::string text =
        "## The threshold by itself\n\nF1 in per cent, mean over the pairs of a sequence (a random start is drawn "
        "three times). *best*: the fixed threshold that is best for this sequence, known only afterwards. The "
        "others: what is lost to it, in points.\n\n| scene | camera | detector | pairs | ICGM best | at | automatic "
        "| 0.08 | 0.2 | consensus best | at | automatic | 0.12 "
        "|\n|---|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n";
    std::vector<double> lost_faithful, lost_ours;
    for (const CrowdSequence& sequence : sequences_)
      for (const std::string& detector : options_.detector) {
        const auto scored = Scored(detector, sequence.moving, sequence.scene);
        if (scored.empty()) continue;
        text += fmt::format("| {} | {} | {} | {} |", sequence.scene, sequence.moving ? "moving" : "still", detector,
                            scored.size());
        lost_faithful.push_back(AddThresholds(scored, {}, {0.08, 0.2}, text));
        lost_ours.push_back(AddThresholds(scored, IcgmOptions::Consensus(), {0.12}, text));
        text += "\n";
      }
    const auto within = [](const std::vector<double>& lost) {
      return std::count_if(lost.begin(), lost.end(), [](double points) { return points <= 2; });
    };
    return text +
           fmt::format(
               "\nThe automatic threshold is within 2 points of the best fixed one on {} of {} sequences for ICGM, "
               "on {} for the consensus; at worst it loses {:.1f} and {:.1f}.\n\n",
               within(lost_faithful), lost_faithful.size(), within(lost_ours), QuantileOf(lost_faithful, 1),
               QuantileOf(lost_ours, 1));
  }

  /// Adds columns to a row. @returns how many points the automatic threshold loses.
  static double AddThresholds(const std::vector<const JudgedMatches*>& scored, IcgmOptions options,
                              const std::vector<double>& fixed, std::string& row) {
    double best = 0, at = 0;
    for (const double threshold : FixedThresholds()) {
      options.threshold = threshold;
      const double f1 = MeanF1(scored, options);
      if (f1 > best) at = threshold;
      best = std::max(best, f1);
    }
    options.automatic = true;
    const double lost = 100 * (best - MeanF1(scored, options));
    row += fmt::format(" {:.1f} | {:.2f} | {:.1f} |", 100 * best, at, lost);
    options.automatic = false;
    for (const double threshold : fixed) {
      options.threshold = threshold;
      row += fmt::format(" {:.1f} |", 100 * (best - MeanF1(scored, options)));
    }
    return lost;
  }

  /// Medians over the pairs of all scenes, the camera still, by Hua's ICGM.
  struct Medians {
    double kept, precision, recall;
  };
  Medians MediansAt(const std::string& detector, double threshold) const {
    std::vector<double> kept, precision, recall;
    IcgmOptions options;
    options.threshold = threshold;
    for (const JudgedMatches* judged : Scored(detector, false)) {
      const FilterScore score = ScoreOf(*judged, KeepByIcgm(*judged, options));
      kept.push_back(score.kept);
      recall.push_back(score.Recall());
      if (score.kept > 0) precision.push_back(score.Precision());
    }
    return {MedianOf(kept), MedianOf(precision), MedianOf(recall)};
  }

  std::string CurveTable() const {
    std::string text =
        "## Matches over 1 / threshold\n\nHua's ICGM, camera still, medians over the pairs (his Fig. 5.1 has one "
        "pair: 374 of 975 kept at 12.5, none at 31.4).\n\n| detector | 1 / threshold | kept | precision | recall "
        "|\n|---|---:|---:|---:|---:|\n";
    for (const std::string& detector : options_.detector)
      for (const double inverse : {2.5, 5.0, 8.0, 12.5, 20.0, 31.4}) {
        const Medians m = MediansAt(detector, 1 / inverse);
        text += fmt::format("| {} | {:.1f} | {:.0f} | {:.1f} | {:.1f} |\n", detector, inverse, m.kept,
                            100 * m.precision, 100 * m.recall);
      }
    return text + fmt::format("\n![Numbers, precision and recall over 1 / threshold]({})\n\n", curves_name_);
  }

  void FilmWalks() {
    std::vector<CrowdWalk> films;
    for (const std::string& scene : options_.scene)
      films.push_back({scene, CrowdStage(StageOptions(scene, false), options_.seed).FilmWalk(0, options_.walk)});
    walks_ = CountWalks(films, options_.detector, options_.seed);
  }

  /// The pair with the most of the view on people, among those with matches enough for a picture.
  const JudgedMatches* Crowded() const {
    constexpr int kEnough = 100;
    const JudgedMatches* crowded = nullptr;
    double most = -1;
    for (const CrowdSequence& sequence : sequences_)
      for (const JudgedMatches& judged : sequence.judged) {
        const double share = sequence.people[size_t(judged.pair)];
        if (sequence.moving || judged.detector != options_.detector.back() || judged.CountRight() < kEnough ||
            share <= most)
          continue;
        most = share;
        crowded = &judged;
      }
    return crowded;
  }

  void WritePictures(const fs::path& table) {
    const std::string stem = table.stem().string();
    curves_name_ = stem + ".png";
    matches_name_ = stem + "_matches.png";
    const std::vector<double> thresholds = FixedThresholds();
    std::vector<ThresholdPanel> panels{{"kept matches", 1, {}}, {"precision", 1, {}}, {"recall", 1, {}}};
    const cv::Scalar colours[] = {{120, 120, 120}, {0, 190, 190}, {40, 40, 200},
                                  {40, 140, 40},   {200, 120, 0}, {160, 0, 160}};
    for (size_t d = 0; d < options_.detector.size(); ++d) {
      for (ThresholdPanel& panel : panels) panel.curves.push_back({options_.detector[d], colours[d % 6], {}});
      for (const double threshold : thresholds) {
        const Medians m = MediansAt(options_.detector[d], threshold);
        panels[0].curves[d].values.push_back(m.kept);
        panels[1].curves[d].values.push_back(m.precision);
        panels[2].curves[d].values.push_back(m.recall);
        if (m.kept > panels[0].most) panels[0].most = 50 * std::ceil(m.kept / 50);
      }
    }
    Write(table.parent_path() / curves_name_, DrawThresholds(thresholds, panels));
    const JudgedMatches* crowded = Crowded();
    if (!crowded) return;
    const auto filmed = std::find_if(sequences_.begin(), sequences_.end(), [&](const CrowdSequence& sequence) {
      return sequence.scene == crowded->scene && !sequence.moving;
    });
    Write(table.parent_path() / matches_name_,
          DrawMatches(filmed->a[size_t(crowded->pair)], filmed->b[size_t(crowded->pair)], crowded->matches,
                      KeepByIcgm(*crowded, IcgmOptions::Consensus())));
  }

  static void Write(const fs::path& file, const cv::Mat& picture) {
    if (!cv::imwrite(file.string(), picture)) throw MissingResource(file.string() + ": cannot be written");
  }

  std::string PictureText() const {
    const JudgedMatches* crowded = Crowded();
    if (!crowded) return "";
    const FilterScore score = ScoreOf(*crowded, KeepByIcgm(*crowded, IcgmOptions::Consensus()));
    return fmt::format(
        "## One pair\n\nThe pair with 100 right matches or more whose first view shows the most of people: {} "
        "matches of {} in {}, {} right. The consensus keeps (green) {}, {} of them right and {} on movers. Not all "
        "lines are drawn.\n\n![Matches kept and dropped]({})\n",
        crowded->matches.size(), crowded->detector, crowded->scene, crowded->CountRight(), score.kept, score.right,
        score.movers, matches_name_);
  }

  std::string command_, curves_name_, matches_name_, table_;
  int64_t filmed_ = 0;
  std::vector<CrowdSequence> sequences_;
  std::vector<WalkCount> walks_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakeCrowds() { return std::make_unique<Crowds>(); }

}  // namespace gaitcam
