#include <fmt/format.h>

#include <cstdlib>
#include <fstream>

#include "algorithms/core/errors.h"
#include "algorithms/io/whole_file.h"
#include "results/reports/check_report.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/jobs/check.h"
#include "scenarios/code/jobs/self_test.h"
#include "scenarios/code/jobs/suite.h"
#include "scenarios/code/runs/interrupt.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr int kInterrupted = 130;

ExecutorOptions ExecutorOptionsOf(const CheckArguments& arguments, const Suite& suite, const CommonOptions& common,
                                  const InterruptGuard& guard) {
  ExecutorOptions options;
  options.runs = arguments.out.empty() ? fs::path("runs/check-" + suite.options.name) : arguments.out;
  options.cache = arguments.cache;
  options.jobs = arguments.jobs;
  options.what = "checking " + suite.options.name;
  options.quiet = common.quiet;
  options.interrupted = [&guard] { return guard.Interrupted(); };
  return options;
}

int SayInterrupted() {
  fmt::print(stderr, "gaitcam: interrupted; the same command goes on from here\n");
  return kInterrupted;
}

/// Appended, as to the summary of a GitHub job, to which other steps may have written.
void AppendToStepSummary(const std::string& markdown) {
  const char* file = std::getenv("GITHUB_STEP_SUMMARY");
  if (file == nullptr || *file == '\0') return;
  std::ofstream stream(file, std::ios::app);
  stream << markdown << "\n";
  stream.close();
  if (!stream) throw MissingResource(std::string("cannot write ") + file + ", which GITHUB_STEP_SUMMARY names");
}

void WriteReports(const CheckArguments& arguments, const CheckReport& report) {
  if (!arguments.junit.empty()) WriteWholeFile(arguments.junit, CheckJUnit(report));
  if (!arguments.markdown.empty()) WriteWholeFile(arguments.markdown, CheckMarkdown(report));
  AppendToStepSummary(CheckMarkdown(report));
}

void Print(const CheckReport& report, const CommonOptions& common) {
  if (common.json) {
    fmt::print("{}", CheckJson(report));
  } else if (!common.quiet) {
    fmt::print("{}", CheckTable(report));
  }
}

int Compare(const CheckArguments& arguments, const CommonOptions& common, const Suite& suite, const fs::path& file,
            const ExecutorOptions& options) {
  const Baseline baseline = ReadBaseline(file);
  CheckComparable(suite, baseline, file);
  const SuiteMeasurement measured = MeasureSuite(suite, {{"", suite.entries}}, options);
  if (measured.interrupted) return SayInterrupted();
  CheckReport report{suite.options.name,
                     JudgeAgainst(suite, baseline, measured.variants.front().entries),
                     NotesOn(suite, baseline, measured.renderer),
                     measured.runs,
                     measured.reused,
                     measured.wall_s};
  WriteReports(arguments, report);
  Print(report, common);
  const int code = ExitCodeOf(report.entries);
  if (code != 0) fmt::print(stderr, "gaitcam: {}: {}\n", suite.options.name, CheckSummary(report));
  return code;
}

/// The baseline that will be replaced; nothing if there is none or it cannot be read.
std::optional<Baseline> Replaced(const fs::path& file) {
  try {
    return ReadBaseline(file);
  } catch (const BadInput&) {
    return std::nullopt;
  }
}

int Update(const CheckArguments& arguments, const CommonOptions& common, const Suite& suite, const fs::path& file,
           const ExecutorOptions& options) {
  const std::optional<Baseline> before = Replaced(file);
  constexpr uint64_t kOfHistory = 1'000'000;  // no re-run of a self-test has such a number
  std::vector<SuiteVariant> variants{{"", suite.entries}};
  for (int i = 1; i <= suite.options.gate.history; ++i) variants.push_back(RerunOf(suite, kOfHistory + uint64_t(i)));
  const SuiteMeasurement measured = MeasureSuite(suite, variants, options);
  if (measured.interrupted) return SayInterrupted();
  const Baseline baseline = MakeBaseline(suite, measured);
  std::error_code error;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), error);
  WriteWholeFile(file, BaselineToJson(baseline));
  CheckReport report{suite.options.name, {}, {}, measured.runs, measured.reused, measured.wall_s};
  report.entries = JudgeAgainst(suite, before ? *before : baseline, measured.variants.front().entries);
  if (before) {
    report.notes = NotesOn(suite, *before, measured.renderer);
    try {
      CheckComparable(suite, *before, file);
    } catch (const BadInput& e) {
      const std::string what = e.what();
      report.notes.push_back("the table compares what is not the same: " + what.substr(0, what.rfind("; --update")));
    }
  } else {
    report.notes.push_back("there was no baseline before; the table shows the new one against itself");
  }
  WriteReports(arguments, report);
  Print(report, common);
  if (!common.json && !common.quiet) fmt::print("wrote {}\n", file.string());
  return 0;
}

int SelfTest(const CheckArguments& arguments, const CommonOptions& common, const Suite& suite, const fs::path& file,
             const ExecutorOptions& options) {
  if (suite.options.self_test.empty())
    throw BadInput(suite.file.string() + ": has no `self_test`; name systems made worse on purpose there");
  const Baseline baseline = ReadBaseline(file);
  CheckComparable(suite, baseline, file);
  const SelfTestResult result = RunSelfTest(suite, baseline, arguments.reruns, options);
  if (result.interrupted) return SayInterrupted();
  if (!arguments.record.empty()) WriteWholeFile(arguments.record, SelfTestMarkdown(suite, result));
  if (common.json) {
    fmt::print("{}", SelfTestJson(result));
  } else if (!common.quiet) {
    fmt::print("{}", SelfTestText(suite, result));
  }
  return result.Passed() ? 0 : 1;
}

}  // namespace

int CheckCommand(const CheckArguments& arguments, const CommonOptions& common) {
  if (arguments.update && arguments.self_test) throw BadInput("--update and --self-test do not go together");
  if (!arguments.self_test && (arguments.reruns > 0 || !arguments.record.empty()))
    throw BadInput("--reruns and --record belong to --self-test");
  const Suite suite = ReadSuite(arguments.suite);
  const fs::path file =
      arguments.baseline.empty() ? BaselineFileOf(arguments.suite, suite) : fs::path(arguments.baseline);
  if (arguments.update && IsInstalled() && file.string().starts_with(DataFolder().string()))
    throw BadInput(file.string() + ": belongs to the installation; write a baseline of yours with --baseline FILE");
  const InterruptGuard guard;
  const ExecutorOptions options = ExecutorOptionsOf(arguments, suite, common, guard);
  if (arguments.update) return Update(arguments, common, suite, file, options);
  if (arguments.self_test) return SelfTest(arguments, common, suite, file, options);
  return Compare(arguments, common, suite, file, options);
}

}  // namespace gaitcam
