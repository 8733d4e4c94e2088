#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "algorithms/io/dataset_reader.h"
#include "algorithms/io/whole_file.h"
#include "results/scoring/study_table.h"
#include "scenarios/code/experiments/perturbed_stream.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/experiments/threshold_search.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/files/system_needs.h"
#include "scenarios/code/jobs/sequence_cache.h"
#include "scenarios/code/runs/progress.h"
#include "scenarios/code/runs/run_scores.h"
#include "scenarios/code/runs/tracking_thread.h"
#include "scenarios/code/systems/chosen_system.h"
#include "scenarios/code/systems/private_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

struct StressOptions {
  std::string recording;         ///< Empty: the quick start's first seconds.
  std::vector<std::string> set;  ///< KEY=VALUE of a scenario.
  std::vector<std::string> system;
  std::vector<std::string> kinds;  ///< Empty: all.
  int seeds = 3;
  int halvings = 5;
  std::string score = "ate_sim3_rmse_m";
  double factor = 2;
  double least_pct = 2;
  double coverage_pct = 50;
};

template <class Visitor>
void VisitFields(Visitor& visit, StressOptions& o) {
  visit("recording", o.recording, AnyText(),
        "a recorded folder, the truth beside it, or a scenario to be recorded (default: 6 s of quickstart at 15 Hz)");
  visit("set", o.set, Nested(), "set any key of the scenario, KEY=VALUE");
  visit("system", o.system, Nested(), "a system, by name or as in a scenario");
  visit("kinds", o.kinds, Nested(), "kinds of perturbation, by name, with commas between them (default: all)");
  visit("seeds", o.seeds, Between(1, 1000), "of perturbations and systems: 1, 2, ...");
  visit("halvings", o.halvings, Between(1, 20), "a threshold is found to the largest level / 2^halvings");
  visit("score", o.score, OneOf({"ate_sim3_rmse_m", "ate_rmse_m", "live_ate_sim3_rmse_m"}), "the error that is judged");
  visit("factor", o.factor, AtLeast(1), "failed: the error is more than so many times that of the clean run, ...");
  visit("least_pct", o.least_pct, Between(0, 100), "... and more than this part of the path walked");
  visit("coverage_pct", o.coverage_pct, Between(0, 100), "failed: less than this part of the clean run's coverage");
}

/// How a run ended; all but the first are failures.
enum class Ending { kHeld, kStopped, kUnscored, kLost, kStrayed };

char LetterOf(Ending ending) { return "-suce"[int(ending)]; }
std::string_view WordOf(Ending ending) {
  constexpr std::string_view kWords[] = {"held", "stopped", "unscored", "coverage", "error"};
  return kWords[int(ending)];
}

/// What a system made of a stream.
struct Measured {
  double coverage = kNaN, error_m = kNaN, path_m = kNaN;
  std::string stopped, unscored;  ///< Why; empty if it did not, if it was.
};

struct Judged : Measured {
  double level = 0;
  Ending ending = Ending::kHeld;
};

/// One system with one seed on the recording as it is.
struct CleanRun {
  size_t system = 0;
  uint64_t seed = 1;
  Measured measured;
};

/// One system, one kind of perturbation, one seed.
struct Search {
  size_t system = 0;
  PerturbationKind kind = PerturbationKind::kDropped;
  uint64_t seed = 1;
  bool has_stream = true, has_clean = true;
  Threshold threshold;
  std::vector<Judged> runs;  ///< In the order in which they were tried.

  /// Of the run at the threshold.
  Ending Cause() const {
    for (const Judged& run : runs)
      if (run.level == threshold.fails_at) return run.ending;
    return Ending::kHeld;
  }
  /// By which seeds are ordered: what never fails comes last.
  double Level() const { return threshold.fails_at.value_or(std::numeric_limits<double>::infinity()); }
};

RecordedStream ReadStream(const fs::path& sensors) {
  DatasetReader reader(sensors);
  RecordedStream stream{reader.calibration(), {}};
  while (std::optional<Observation> observation = reader.Next()) {
    const int64_t stamp_ns = observation->stamp_ns;
    stream.frames.push_back({std::move(*observation), stamp_ns});
  }
  return stream;
}

/// The answers as those to what the images show: at the instants when these were taken, in order; the others left out.
std::vector<FrameEstimate> AsShown(const std::vector<FrameEstimate>& answers, const RecordedStream& stream) {
  std::vector<FrameEstimate> shown;
  for (size_t i = 0; i < answers.size(); ++i) {
    GAITCAM_ASSERT(answers[i].stamp_ns == stream.frames[i].observation.stamp_ns);
    if (!stream.frames[i].shown_ns) continue;
    shown.push_back(answers[i]);
    shown.back().stamp_ns = *stream.frames[i].shown_ns;
  }
  const auto earlier = [](const FrameEstimate& a, const FrameEstimate& b) { return a.stamp_ns < b.stamp_ns; };
  std::sort(shown.begin(), shown.end(), earlier);
  return shown;
}

std::vector<PerturbationKind> KindsOf(const std::vector<std::string>& texts) {
  std::vector<PerturbationKind> kinds;
  for (const std::string& text : texts) {
    std::istringstream words(text);
    for (std::string word; std::getline(words, word, ',');) {
      if (word.empty()) continue;
      const auto kind = FromWord<PerturbationKind>(word);
      if (!kind) throw BadOption("--kinds: " + OneOf(EnumWords<PerturbationKind>::List()).Refusal(word));
      if (std::find(kinds.begin(), kinds.end(), *kind) == kinds.end()) kinds.push_back(*kind);
    }
  }
  if (!texts.empty() && kinds.empty()) throw BadOption("--kinds: names no kind of perturbation");
  if (texts.empty())
    for (const PerturbationInfo& info : ListPerturbations()) kinds.push_back(info.kind);
  return kinds;
}

/// Where systems fail as a recording is spoilt more and more.
class Stress : public ExperimentOf<StressOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    command_ = setup.command;
    kinds_ = KindsOf(options_.kinds);
    if (options_.system.empty()) throw BadInput("stress: name at least one --system");
    for (const std::string& text : options_.system) {
      systems_.push_back(ParseSystemChoice(text));
      InfoOf(systems_.back());  // now, not after a walk was recorded: is there such a system?
    }
    const bool is_recorded = fs::is_directory(options_.recording);
    const auto recorded = is_recorded ? std::nullopt : Record(setup);  // kept from being removed meanwhile
    sensors_ = is_recorded ? GivenFolder() : recorded->folders.sensors;
    stream_ = ReadStream(sensors_);
    for (const SystemChoice& system : systems_) {
      if (const auto lack = LackInDataset(InfoOf(system), stream_.calibration, sensors_)) throw BadInput(*lack);
      CheckSettings(system, stream_.calibration);
    }
    RunClean(setup);
    RunSearches(setup);
    WriteWholeFile(fs::path(setup.table).replace_extension(".csv"), Rows());
  }

  std::string Table() const override { return Introduction() + CleanTable() + ThresholdTable() + KindTable(); }

 private:
  /// A folder that is recorded already.
  fs::path GivenFolder() const {
    if (!options_.set.empty()) throw BadInput("--set: " + options_.recording + " is recorded already");
    fs::path sensors = FindDataset(options_.recording);
    if (!HasTruthBeside(sensors))
      throw BadInput(sensors.string() + ": the truth does not lie beside it; nothing can be scored");
    return sensors;
  }

  /// A scenario's walk.
  std::optional<CachedSequence> Record(const ExperimentSetup& setup) const {
    std::vector<std::string> sets = options_.set;
    std::string scenario = options_.recording;
    if (scenario.empty()) {
      scenario = (DataFolder() / "scenarios/quickstart.yaml").string();
      sets.insert(sets.begin(), {"duration_s=6", "camera.rate_hz=15"});
    }
    const ResolvedScenario resolved = ReadScenario(UsersOrShipped(scenario, {"scenarios"}), sets);
    return SequenceCache({}).Get(resolved, setup.quiet, [] { return false; });
  }

  /// Nothing, and why, if the system does not come to its end.
  std::optional<Estimate> Track(const RecordedStream& stream, size_t system, uint64_t seed, std::string& why) const {
    const SystemChoice& choice = systems_[system];
    try {
      const PrivateFolder folder;
      TrackingThread tracker(MakeSystem(choice, {stream.calibration, seed, choice.settings}, folder.path()));
      for (const HandedOver& frame : stream.frames) tracker.Push(frame.observation);
      return tracker.Finish();
    } catch (const MissingResource&) {  // the machine's fault
      throw;
    } catch (const std::exception& e) {  // one of ours that cannot bear it, or a stranger that refuses it
      why = e.what();
      return std::nullopt;
    }
  }

  Measured Measure(const RecordedStream& stream, size_t system, uint64_t seed) const {
    Measured measured;
    std::optional<Estimate> estimate = Track(stream, system, seed, measured.stopped);
    if (!estimate) return measured;
    measured.stopped = estimate->failure;
    estimate->frames = AsShown(estimate->frames, stream);
    if (!estimate->live.empty()) estimate->live = AsShown(estimate->live, stream);
    try {
      const Scores scores = ScoreAgainstTruthBeside(*estimate, sensors_, systems_[system].name);
      measured.coverage = scores.Value("coverage_ratio");
      measured.path_m = scores.Value("path_length_m");
      measured.error_m = scores.Value(options_.score);
    } catch (const TooLittleData& e) {
      measured.unscored = e.what();
    }
    return measured;
  }

  Ending Judge(const Measured& run, const Measured& clean) const {
    if (!run.stopped.empty()) return Ending::kStopped;
    if (!run.unscored.empty()) return Ending::kUnscored;
    if (run.coverage < 0.01 * options_.coverage_pct * clean.coverage) return Ending::kLost;
    const double most_m = std::max(options_.factor * clean.error_m, 0.01 * options_.least_pct * clean.path_m);
    return run.error_m <= most_m ? Ending::kHeld : Ending::kStrayed;  // no number: it strayed
  }

  void RunClean(const ExperimentSetup& setup) {
    for (size_t system = 0; system < systems_.size(); ++system)
      for (int seed = 1; seed <= options_.seeds; ++seed) clean_.push_back({system, uint64_t(seed), {}});
    InParallel(int(clean_.size()), setup.jobs, [&](int i) {
      CleanRun& run = clean_[size_t(i)];
      run.measured = Measure(stream_, run.system, run.seed);
    });
  }

  const Measured& CleanOf(size_t system, uint64_t seed) const {
    return clean_[system * size_t(options_.seeds) + size_t(seed - 1)].measured;
  }

  void RunSearches(const ExperimentSetup& setup) {
    for (size_t system = 0; system < systems_.size(); ++system)
      for (const PerturbationKind kind : kinds_)
        for (int seed = 1; seed <= options_.seeds; ++seed)
          searches_.push_back({system, kind, uint64_t(seed), HasStreamOf(kind, stream_), true, {}, {}});
    Progress progress("stress: thresholds", int64_t(searches_.size()), setup.quiet);
    std::mutex counting;
    int64_t done = 0;
    InParallel(int(searches_.size()), setup.jobs, [&](int i) {
      Conduct(searches_[size_t(i)]);
      const std::lock_guard lock(counting);
      progress.Update(++done);
    });
    progress.Finish();
  }

  void Conduct(Search& search) const {
    const Measured& clean = CleanOf(search.system, search.seed);
    search.has_clean = clean.stopped.empty() && std::isfinite(clean.error_m);
    if (!search.has_stream || !search.has_clean) return;
    const auto fails = [&](double level) {
      const RecordedStream stream = Perturbed(stream_, search.kind, level, search.seed);
      Judged run{Measure(stream, search.system, search.seed), level, Ending::kHeld};
      run.ending = Judge(run, clean);
      search.runs.push_back(run);
      return run.ending != Ending::kHeld;
    };
    search.threshold = FindThreshold(InfoOf(search.kind).largest, options_.halvings, fails);
  }

  std::string Introduction() const {
    return fmt::format(
        "# Where systems fail as a recording is spoilt\n\nMade by `{}`.\n\nEach kind of perturbation is turned up "
        "until "
        "the system fails on it; the threshold is the smallest level found to fail, by {} halvings of the interval "
        "from 0 to the largest level. Seeds draw what is perturbed, and are the systems' own.\n\n"
        "A run **fails** when the system stops (s), when too little is left to score (u: fewer than 10 poses or 10 % "
        "of "
        "the frames that count), when its coverage is below {:g} % of the clean run's (c), or when its error is more "
        "than {:g} times the clean run's and more than {:g} % of the path walked (e). Clean run: the same system and "
        "seed on the recording as it is. Error: `{}`. An answer is compared with where the camera was when the image "
        "was truly taken; black images and repeats do not count, neither for the error nor for the coverage.\n\n",
        command_, options_.halvings, options_.coverage_pct, options_.factor, options_.least_pct, options_.score);
  }

  std::string CleanTable() const {
    std::string text = fmt::format(
        "## Clean runs\n\n{} frames; median (smallest to largest) over {} seeds. Allowed: the error from which on a "
        "run "
        "fails.\n\n| system | coverage, % | error, mm | allowed, mm | path walked, m | remark |\n"
        "|---|---:|---:|---:|---:|---|\n",
        stream_.frames.size(), options_.seeds);
    for (size_t system = 0; system < systems_.size(); ++system) {
      std::vector<double> coverage, error, allowed, path;
      std::string remark;
      for (int seed = 1; seed <= options_.seeds; ++seed) {
        const Measured& run = CleanOf(system, uint64_t(seed));
        if (!run.stopped.empty() || !run.unscored.empty()) {
          remark = run.stopped.empty() ? run.unscored : run.stopped;
          continue;
        }
        coverage.push_back(100 * run.coverage);
        error.push_back(1000 * run.error_m);
        allowed.push_back(std::max(options_.factor * error.back(), 10 * options_.least_pct * run.path_m));
        path.push_back(run.path_m);
      }
      text += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", options_.system[system], MedianAndRange(coverage, 0),
                          MedianAndRange(error, 1), MedianAndRange(allowed, 1), MedianAndRange(path, 2), remark);
    }
    return text + "\n";
  }

  std::string ThresholdTable() const {
    std::string text = fmt::format(
        "## Thresholds\n\nMedian over {} seeds (of an even number the lower of the two in the middle), smallest to "
        "largest in brackets, and how the run at the median ended. `> x`: it holds at the largest level, x. `<= x`: it "
        "fails at the smallest level tried, x. `*`: of a seed, a level above the threshold holds, so that the "
        "threshold "
        "is not all there is to say.\n\n| perturbation | level |",
        options_.seeds);
    std::string rule = "|---|---|";
    for (const std::string& system : options_.system) {
      text += fmt::format(" `{}` |", system);
      rule += "---:|";
    }
    text += "\n" + rule + "\n";
    for (const PerturbationKind kind : kinds_) {
      text += fmt::format("| {} | {} |", ToWord(kind), InfoOf(kind).unit);
      for (size_t system = 0; system < systems_.size(); ++system) text += " " + Cell(system, kind) + " |";
      text += "\n";
    }
    return text + "\n";
  }

  std::string Cell(size_t system, PerturbationKind kind) const {
    std::vector<const Search*> found;
    bool is_monotone = true;
    for (const Search& search : searches_) {
      if (search.system != system || search.kind != kind) continue;
      if (!search.has_stream) return "no such stream";
      if (!search.has_clean) continue;
      found.push_back(&search);
      is_monotone = is_monotone && search.threshold.is_monotone;
    }
    if (found.empty()) return "-";
    const auto lower = [](const Search* a, const Search* b) { return a->Level() < b->Level(); };
    std::stable_sort(found.begin(), found.end(), lower);
    const Search& median = *found[(found.size() - 1) / 2];
    std::string text = LevelText(median);
    if (found.front()->Level() != found.back()->Level())
      text += fmt::format(" ({} to {})", LevelText(*found.front()), LevelText(*found.back()));
    if (median.threshold.fails_at) text += fmt::format(" {}", LetterOf(median.Cause()));
    return text + (is_monotone ? "" : " *");
  }

  static std::string LevelText(const Search& search) {
    const Threshold& threshold = search.threshold;
    if (!threshold.fails_at) return fmt::format("> {:.3g}", threshold.holds_at);
    return fmt::format("{}{:.3g}", threshold.holds_at == 0 ? "<= " : "", *threshold.fails_at);
  }

  std::string KindTable() const {
    std::string text = "What a level does:\n\n| perturbation | | largest level |\n|---|---|---:|\n";
    for (const PerturbationKind kind : kinds_) {
      const PerturbationInfo& info = InfoOf(kind);
      text += fmt::format("| {} | {} | {:g} {} |\n", ToWord(kind), info.meaning, info.largest, info.unit);
    }
    return text;
  }

  /// Every run, the clean ones as level 0 of "none".
  std::string Rows() const {
    std::string text = "system,perturbation,seed,level,ending,coverage_ratio,error_m,why\n";
    const auto add = [&](size_t system, std::string_view kind, uint64_t seed, const Judged& run) {
      text += fmt::format("{},{},{},{:g},{},{:.4f},{:.6g},{}\n", CsvField(options_.system[system]), kind, seed,
                          run.level, WordOf(run.ending), run.coverage, run.error_m,
                          CsvField(run.stopped.empty() ? run.unscored : run.stopped));
    };
    for (const CleanRun& clean : clean_) {
      const Judged run{clean.measured, 0, Judge(clean.measured, clean.measured)};
      add(clean.system, "none", clean.seed, run);
    }
    for (const Search& search : searches_)
      for (const Judged& run : search.runs) add(search.system, ToWord(search.kind), search.seed, run);
    return text;
  }

  std::string command_;
  std::vector<PerturbationKind> kinds_;
  std::vector<SystemChoice> systems_;
  fs::path sensors_;
  RecordedStream stream_;
  std::vector<CleanRun> clean_;  ///< By system, then seed.
  std::vector<Search> searches_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakeStress() { return std::make_unique<Stress>(); }

}  // namespace gaitcam
