#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "algorithms/io/whole_file.h"
#include "scenarios/code/experiments/table_experiment.h"
#include "scenarios/code/runs/exit_code.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

/// Options of every experiment.
struct Call {
  fs::path table;
  int jobs = 0;
  bool quiet = false, list = false;
};

struct AddTo {
  CLI::App& verb;
  const ExperimentOption& option;
  void operator()(bool* value) const { verb.add_flag(option.Flag(), *value, option.meaning); }
  void operator()(InputPaths* value) const { verb.add_option(option.key, value->paths, option.meaning); }
  void operator()(std::vector<std::string>* value) const {
    verb.add_option(option.Flag(), *value, option.meaning + " (repeatable)")->allow_extra_args(false);
  }
  template <class T>
  void operator()(T* value) const {
    verb.add_option(option.Flag(), *value, option.meaning)->capture_default_str();
  }
};

void AddVerb(CLI::App& app, const ExperimentEntry& entry, TableExperiment& experiment, Call& call) {
  CLI::App* verb = app.add_subcommand(entry.name, entry.summary);
  for (const ExperimentOption& option : experiment.Options().options) std::visit(AddTo{*verb, option}, option.value);
  verb->add_option("--out", call.table, "Markdown file to write (default: " + entry.name + ".md)");
  verb->add_option("-j,--jobs", call.jobs, "runs or threads at once (default: one per core)")
      ->check(CLI::Range(0, 10000));
  verb->footer("Examples:\n" + entry.examples);
}

int Measure(const ExperimentEntry& entry, TableExperiment& experiment, const Call& call) {
  experiment.CheckOptions();
  ExperimentSetup setup;
  setup.table = call.table.empty() ? entry.name + ".md" : call.table.string();
  setup.command = ExperimentCommand(entry, experiment);
  if (!call.table.empty()) setup.command += " --out " + call.table.lexically_normal().string();
  setup.program = fs::read_symlink("/proc/self/exe").parent_path() / "gaitcam";
  setup.jobs = call.jobs;
  setup.quiet = call.quiet;
  if (setup.table.has_parent_path()) fs::create_directories(setup.table.parent_path());
  experiment.Run(setup);
  WriteWholeFile(setup.table, experiment.Table());
  if (!call.quiet) fmt::print("{}\ntable: {}\n", experiment.Table(), setup.table.string());
  return 0;
}

int Main(int argc, char** argv) {
  Call call;
  CLI::App app("Measurements behind the tables of results.", "gaitcam experiment");
  app.fallthrough();
  app.add_flag("--list", call.list, "name the experiments");
  app.add_flag("-q,--quiet", call.quiet, "no progress, no prose");
  app.footer("Example:\n  gaitcam experiment psf --frames 20 --out psf.md");
  std::vector<std::unique_ptr<TableExperiment>> experiments;
  for (const ExperimentEntry& entry : ListExperiments()) {
    experiments.push_back(entry.make());
    AddVerb(app, entry, *experiments.back(), call);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return app.exit(e);  // --help
  } catch (const CLI::ParseError& e) {
    return Fail(2, std::string(e.what()) + "; see gaitcam experiment --help");
  }
  if (call.list) {
    for (const ExperimentEntry& entry : ListExperiments()) fmt::print("{:<16} {}\n", entry.name, entry.summary);
    return 0;
  }
  for (size_t i = 0; i < experiments.size(); ++i) {
    const ExperimentEntry& entry = ListExperiments()[i];
    if (app.got_subcommand(entry.name)) return WithExitCode([&] { return Measure(entry, *experiments[i], call); });
  }
  return Fail(2, "which experiment? see gaitcam experiment --list");
}

}  // namespace
}  // namespace gaitcam

int main(int argc, char** argv) { return gaitcam::Main(argc, argv); }
