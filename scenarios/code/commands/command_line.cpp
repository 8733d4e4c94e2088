#include "scenarios/code/commands/command_line.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "algorithms/core/errors.h"
#include "algorithms/io/dataset_layout.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/commands/completion.h"
#include "scenarios/code/commands/manual_page.h"
#include "scenarios/code/commands/parser_words.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/files/versions.h"
#include "scenarios/code/runs/exit_code.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

/// The parser by itself takes -1 for 2^64 - 1.
std::string RefuseSeed(const std::string& text) {
  return OptionValue(text).AsUnsigned() ? "" : text + " is not permitted; expected a whole number of at least 0";
}

void AddScenario(CLI::App& verb, ScenarioArguments& arguments) {
  verb.add_option("scenario", arguments.file, "scenario file (YAML), or the name of a shipped one")->required();
  verb.add_option("--set", arguments.sets, "set any key of the scenario, e.g. gait.period_s=0.3 (repeatable)")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  verb.add_option("--seed", arguments.seed, "seed of all randomness (default: the scenario's)")->check(RefuseSeed);
  verb.add_option("--system", arguments.system, "SLAM system (default: the scenario's)");
}

void AddAll(CLI::App& verb, bool& all) { verb.add_flag("--all", all, "print all scores, not only those that sum up"); }

void AddCache(CLI::App& verb, SequenceCacheOptions& arguments) {
  verb.add_option("--cache", arguments.folder, "folder of recorded walks (default: ~/.cache/gaitcam/sequences)");
  verb.add_option("--cache-gb", arguments.max_gb, "its largest size; what was used longest ago goes first")
      ->check([](const std::string& text) {
        const std::optional<double> number = OptionValue(text).AsNumber();
        return number && *number > 0 && *number <= 1e9
                   ? ""
                   : text + " is not permitted; expected a number of gigabytes above 0";
      })
      ->capture_default_str();
}

/// The options of all verbs.
struct Arguments {
  CommonOptions common;
  RunArguments run;
  RecordArguments record;
  FilmArguments film;
  TrackArguments track;
  ServeArguments serve;
  ScoreArguments score;
  ScenarioArguments validate;
  CheckArguments check;
  WorkArguments work;
  StudyArguments study;
  SchemaArguments schema;
  ListArguments list;
  std::string help_verb;  ///< Of which help is asked.
  bool manual = false;    ///< The manual page instead.
};

void AddRun(CLI::App& app, Arguments& a) {
  CLI::App* verb = app.add_subcommand("run", "walk, film, track, score, report");
  AddScenario(*verb, a.run.scenario);
  verb->add_option("--out", a.run.out, "folder of the results (default: runs/NAME-SYSTEM-seedN)");
  AddAll(*verb, a.run.all);
  verb->footer(
      "Examples:\n"
      "  gaitcam run scenarios/quickstart.yaml --all\n"
      "  gaitcam run scenarios/quickstart.yaml --seed 7 --set gait.preset=brisk --set camera.exposure_ms=33\n"
      "  gaitcam run my.yaml --set robot=my_robot.yaml --out runs/mine --json");
}

void AddRecord(CLI::App& app, Arguments& a) {
  CLI::App* verb = app.add_subcommand("record", "walk and film into a dataset folder, with ground truth beside it");
  AddScenario(*verb, a.record.scenario);
  verb->get_option("scenario")->description("scenario file, or a matrix of many (a file with the key `base`)");
  verb->add_option("--format", a.record.format, "layout: tum (RGB-D, the default), euroc (ASL) or vslamlab")
      ->check(CLI::IsMember(EnumWords<DatasetFormat>::List()));
  verb->add_option("--out", a.record.out, "folder to write (default: datasets/NAME-seedN; of a matrix datasets/NAME)");
  verb->add_flag("--truth-inside", a.record.truth_inside, "also put the ground truth inside the dataset folder");
  verb->add_option("--compression", a.record.compression,
                   "of images, all lossless: 0 none, which takes no time, 1 fast (the default) to 9 smallest")
      ->check(CLI::Range(0, 9));
  verb->add_flag("--pairs", a.record.pairs, "pairs of frames: blurred, sharp, blur vectors, floor homography, points");
  verb->add_flag("--preview", a.record.preview, "video and contact sheet also of a single scenario");
  verb->add_option("-j,--jobs", a.record.jobs, "sequences of a matrix at once (default: one per core)")
      ->check(CLI::Range(1, 10000));
  verb->add_flag("--yes", a.record.yes, "also for a matrix of more than 100000 sequences");
  verb->footer(
      "A matrix that was interrupted or killed goes on where it was when the same command is given again.\n"
      "Examples:\n"
      "  gaitcam record scenarios/quickstart.yaml --format tum --out datasets/walk --pairs\n"
      "  gaitcam record scenarios/quickstart.yaml --format euroc --set camera.stereo.baseline_m=0.06\n"
      "  gaitcam record scenarios/matrices/blur.yaml --out datasets/blur");
}

/// Hidden: what `record` starts for a matrix.
void AddFilm(CLI::App& app, Arguments& a) {
  CLI::App* verb = app.add_subcommand("film", "one sequence of a matrix")->group("");
  verb->add_option("dataset", a.film.dataset, "folder of the dataset")->required();
  verb->add_option("name", a.film.name, "of the sequence")->required();
}

void AddTrack(CLI::App& app, Arguments& a) {
  CLI::App* verb = app.add_subcommand("track", "run a SLAM system on a dataset folder, ours or anybody's");
  verb->add_option("dataset", a.track.dataset, "folder in TUM RGB-D, EuRoC ASL or VSLAM-LAB layout")->required();
  verb->add_option("--system", a.track.system,
                   "one of gaitcam list systems, a .so, a .yaml, or {process: [...]} and the like as in a scenario")
      ->capture_default_str();
  verb->add_option("--set", a.track.sets, "setting of the system, e.g. ratio=0.7 (repeatable)")
      ->allow_extra_args(false)
      ->type_name("NAME=VALUE");
  verb->add_option("--seed", a.track.seed, "seed of the system's randomness")->check(RefuseSeed)->capture_default_str();
  verb->add_option("--out", a.track.out, "trajectory file to write, TUM format (default: estimate-SYSTEM.txt)");
  AddAll(*verb, a.track.all);
  verb->footer(
      "Examples:\n"
      "  gaitcam track datasets/walk --system sift_vo --out estimate.txt\n"
      "  gaitcam track datasets/walk --system ./libmy_slam.so\n"
      "  gaitcam track datasets/walk --system '{process: [python3, my_slam.py]}'");
}

/// Hidden: what is started for a shared library.
void AddServe(CLI::App& app, Arguments& a) {
  CLI::App* verb = app.add_subcommand("serve", "a system that answers line by line")->group("");
  verb->add_option("system", a.serve.system, "one of ours");
  verb->add_option("--plugin", a.serve.plugin, "a shared library");
  verb->add_flag("--info", a.serve.info, "print what its system is");
}

void AddScore(CLI::App& app, Arguments& a) {
  CLI::App* verb = app.add_subcommand("score", "score one trajectory file against another (TUM, KITTI or EuRoC)");
  verb->add_option("estimate", a.score.estimate, "trajectory file")->required();
  verb->add_option("truth", a.score.truth, "trajectory file")->required();
  verb->add_option("--set", a.score.sets, "any key of a scenario's `score` section (repeatable)")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  verb->add_option("--out", a.score.out, "write the scores to this JSON file");
  verb->add_flag("--strict", a.score.strict,
                 "refuse stamps that do not increase (else rows are sorted, and of equal stamps the first is kept)");
  AddAll(*verb, a.score.all);
  verb->footer(
      "Examples:\n"
      "  gaitcam score estimate.txt groundtruth.txt --all\n"
      "  gaitcam score estimate.txt groundtruth.txt --set association.rule=nearest --set rpe_frames=10 --json");
}

/// `gaitcam experiment ...` is carried out by gaitcam_experiments, which is built on demand.
void AddExperiment(CLI::App& app) {
  const auto add = [&app](const std::string& name, const std::string& meaning) {
    CLI::App* verb = app.add_subcommand(name, meaning)->prefix_command()->fallthrough(false);
    verb->set_help_flag();
    return verb;
  };
  add("experiment", "measure what a table of results says; see gaitcam experiment --list");
  add("features", "now gaitcam experiment features")->group("");
}

/// @returns only if there is no such program.
int RunExperiment(std::vector<std::string> words) {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "gaitcam_experiments";
  words.insert(words.begin(), program.string());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  execv(pointers.front(), pointers.data());
  throw MissingResource(program.string() + ": not built; the launcher builds it: ./gaitcam experiment");
}

void AddCheck(CLI::App& app, Arguments& a) {
  CLI::App* verb = app.add_subcommand("check", "compare a suite's accuracy with its baseline; fail if it got worse");
  verb->add_option("suite", a.check.suite, "shipped suite (smoke, full), or a suite file (YAML)")->required();
  verb->add_flag("--update", a.check.update, "write a new baseline, and show what it changes");
  verb->add_option("--baseline", a.check.baseline, "baseline file (default: the suite's own)");
  verb->add_option("--junit", a.check.junit, "write the verdicts as JUnit XML");
  verb->add_option("--markdown", a.check.markdown, "write them as Markdown, as to $GITHUB_STEP_SUMMARY");
  verb->add_option("--out", a.check.out, "folder of the runs (default: runs/check-SUITE)");
  AddCache(*verb, a.check.cache);
  verb->add_option("-j,--jobs", a.check.jobs, "runs at once (default: one per core)")->check(CLI::Range(0, 10000));
  verb->add_flag("--self-test", a.check.self_test, "prove the gate: systems made worse on purpose must be caught");
  verb->add_option("--reruns", a.check.reruns, "... and so many re-runs with other randomness must pass")
      ->check(CLI::Range(0, 100000));
  verb->add_option("--record", a.check.record, "write the self-test's rates to this Markdown file");
  verb->footer(
      "Examples:\n"
      "  gaitcam check smoke\n"
      "  gaitcam check smoke --update\n"
      "  gaitcam check ci/my_suite.yaml --junit check.xml --markdown check.md\n"
      "Exit codes: 0 nothing got worse; 1 something did; 2 bad input, or a baseline of something else;\n"
      "3 nothing, or too little, could be judged; 4 the machine lacks something.");
}

/// Hidden: what `check` and `study` start.
void AddWork(CLI::App& app, Arguments& a) {
  CLI::App* verb = app.add_subcommand("work", "one run of a check or study")->group("");
  verb->add_option("runs", a.work.runs, "folder of the runs")->required();
  verb->add_option("hash", a.work.hash, "of the run's scenario")->required();
  AddCache(*verb, a.work.cache);
}

void AddStudy(CLI::App& app, Arguments& a) {
  CLI::App* verb = app.add_subcommand("study", "run a scenario over axes of values and seeds: what makes a difference");
  verb->add_option("study", a.study.file, "study file (YAML), or the name of a shipped one")->required();
  verb->add_option("--out", a.study.out, "folder of the results (default: studies/NAME)");
  verb->add_option("-j,--jobs", a.study.jobs, "runs at once (default: one per core)")->check(CLI::Range(1, 10000));
  AddCache(*verb, a.study.cache);
  verb->add_option("--executor", a.study.executor, "local, or slurm: runs as a job array")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
  verb->add_option("--sbatch", a.study.sbatch, "further option of sbatch, e.g. --sbatch=--partition=long (repeatable)")
      ->allow_extra_args(false);
  verb->add_flag("--yes", a.study.yes, "also for more than 100000 runs");
  verb->footer(
      "A study that was interrupted or killed goes on where it was when the same command is given again.\n"
      "Examples:\n"
      "  gaitcam study scenarios/studies/exposure.yaml\n"
      "  gaitcam study my_study.yaml --out studies/mine -j 8 --json\n"
      "  gaitcam study my_study.yaml --executor slurm --sbatch=--partition=long");
}

void AddSchema(CLI::App& app, Arguments& a) {
  CLI::App* verb = app.add_subcommand("schema", "print the JSON Schema of a kind of file, for editors");
  verb->add_option("kind", a.schema.kind, "scenario, study, suite or matrix")
      ->required()
      ->check(CLI::IsMember({"scenario", "study", "suite", "matrix"}));
  verb->footer(
      "Editors with a YAML language server check a file and complete its keys when its first line says\n"
      "  # yaml-language-server: $schema=study.schema.json\n"
      "Example:\n  gaitcam schema study >study.schema.json");
}

void AddValidate(CLI::App& app, Arguments& a) {
  CLI::App* verb = app.add_subcommand("validate", "say what is wrong with a scenario, or with a dataset");
  AddScenario(*verb, a.validate);
  verb->get_option("scenario")->description("scenario file, or the folder of a dataset or of one recording");
  verb->footer(
      "Examples:\n"
      "  gaitcam validate scenarios/quickstart.yaml --set gait.step_length_m=0.2\n"
      "  gaitcam validate datasets/blur");
}

void AddList(CLI::App& app, Arguments& a) {
  CLI::App* verb = app.add_subcommand("list", "name robots, scenes, systems and scenarios");
  verb->add_option("kind", a.list.kind, "robots, scenes, systems or scenarios (default: all)");
  verb->add_option("name", a.list.name, "one of them: gaits of a robot, options of a system");
  verb->footer(
      "Examples:\n"
      "  gaitcam list systems mobif_vo\n"
      "  gaitcam list robots khr1hv");
}

void AddHelp(CLI::App& app, Arguments& a) {
  CLI::App* verb = app.add_subcommand("help", "say what a verb does: gaitcam help run");
  verb->add_option("verb", a.help_verb, "the verb (default: all in a line each)");
  verb->add_flag("--man", a.manual, "the manual page, for man")->group("");
}

/// What `gaitcam VERB --help` prints, or `gaitcam --help`.
int HelpCommand(const CLI::App& app, const Arguments& a) {
  if (a.manual) {
    std::fputs(ManualPage(app, ProgramVersion()).c_str(), stdout);
    return 0;
  }
  if (a.help_verb == "experiment") return RunExperiment({"--help"});
  const CLI::App* verb = a.help_verb.empty() ? nullptr : FindVerb(app, a.help_verb);
  if (verb == nullptr && !a.help_verb.empty()) throw BadInput(NoSuchVerb(app, a.help_verb));
  const std::string help = verb != nullptr
                               ? verb->help(app.get_name())
                               : app.get_formatter()->make_help(&app, app.get_name(), CLI::AppFormatMode::Normal);
  std::fputs(help.c_str(), stdout);
  return 0;
}

/// What a shell asks for; never a word on standard error, which would spoil the line that is being typed.
int PrintCompletions(const CLI::App& app, const std::vector<std::string>& words) {
  try {
    for (const std::string& word : Completions(app, words)) std::puts(word.c_str());
  } catch (const std::exception&) {
    return 4;
  }
  return 0;
}

/// Shipped files that are named by their names become paths.
void FindFiles(Arguments& a) {
  const std::pair<const char*, fs::path*> files[] = {{"run", &a.run.scenario.file},
                                                     {"record", &a.record.scenario.file},
                                                     {"validate", &a.validate.file},
                                                     {"study", &a.study.file}};
  for (const auto& [verb, file] : files) *file = UsersOrShipped(*file, ShippedFoldersOf(verb));
}

/// Carries out the verb that was given.
int Dispatch(const CLI::App& app, Arguments& a) {
  FindFiles(a);
  if (app.got_subcommand("run")) return RunCommand(a.run, a.common);
  if (app.got_subcommand("record")) return RecordCommand(a.record, a.common);
  if (app.got_subcommand("film")) return FilmCommand(a.film, a.common);
  if (app.got_subcommand("track")) return TrackCommand(a.track, a.common);
  if (app.got_subcommand("serve")) return ServeCommand(a.serve);
  if (app.got_subcommand("score")) return ScoreCommand(a.score, a.common);
  if (app.got_subcommand("experiment")) return RunExperiment(app.get_subcommand("experiment")->remaining());
  if (app.got_subcommand("features")) throw BadInput("features: is now gaitcam experiment features");
  if (app.got_subcommand("validate")) return ValidateCommand(a.validate, a.common);
  if (app.got_subcommand("study")) return StudyCommand(a.study, a.common);
  if (app.got_subcommand("check")) return CheckCommand(a.check, a.common);
  if (app.got_subcommand("schema")) return SchemaCommand(a.schema);
  if (app.got_subcommand("work")) return WorkCommand(a.work, a.common);
  if (app.got_subcommand("list")) return ListCommand(a.list, a.common);
  if (app.got_subcommand("help")) return HelpCommand(app, a);
  return DoctorCommand(a.common);
}

void AddVerbs(CLI::App& app, Arguments& a) {
  app.require_subcommand(1);
  app.set_version_flag("--version", ProgramVersion());
  app.fallthrough();
  app.add_flag("-q,--quiet", a.common.quiet, "no progress, no prose");
  app.add_flag("--json", a.common.json, "the result as JSON on standard output");
  AddRun(app, a);
  AddRecord(app, a);
  AddFilm(app, a);
  AddTrack(app, a);
  AddServe(app, a);
  AddScore(app, a);
  AddExperiment(app);
  AddStudy(app, a);
  AddSchema(app, a);
  AddCheck(app, a);
  AddWork(app, a);
  AddValidate(app, a);
  AddList(app, a);
  app.add_subcommand("doctor", "print versions, EGL's devices, which one renders, and what is missing")
      ->footer(
          "Who renders is chosen by camera.renderer in a scenario, or by the environment variable GAITCAM_EGL "
          "instead:\n"
          "  auto      the first GPU that gives an OpenGL context, else software\n"
          "  gpu       fails without one (exit code 4)\n"
          "  software  Mesa on the CPU\n"
          "  device:N  the N-th EGL device of the list, from 0");
  AddHelp(app, a);
  app.footer(
      "Examples:\n"
      "  gaitcam run quickstart\n"
      "  gaitcam record scenarios/quickstart.yaml --format euroc --out datasets/walk\n"
      "Exit codes: 0 done; 2 bad input; 3 too little covered to score; 4 the machine lacks something;\n"
      "130 interrupted, what is finished is kept.");
}

}  // namespace

int CommandLine(int argc, char** argv) {
  Arguments a;
  CLI::App app("A humanoid walks, its camera films with a real exposure, visual SLAM tracks the film and is scored.",
               "gaitcam");
  AddVerbs(app, a);
  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (!words.empty() && words.front() == "complete") return PrintCompletions(app, {words.begin() + 1, words.end()});
  if (const auto unknown = UnknownVerb(app, words)) return Fail(2, NoSuchVerb(app, *unknown));
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return app.exit(e);  // --help, --version
  } catch (const CLI::ExtrasError&) {
    return Fail(2, UnexpectedWord(app));
  } catch (const CLI::ParseError& e) {
    return Fail(2, std::string(e.what()) + "; " + WhereToLook(app));
  }
  return WithExitCode([&] { return Dispatch(app, a); });
}

}  // namespace gaitcam
