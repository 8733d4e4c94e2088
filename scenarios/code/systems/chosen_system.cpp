#include "scenarios/code/systems/chosen_system.h"

#include "scenarios/code/systems/command_system.h"
#include "scenarios/code/systems/process_system.h"
#include "scenarios/code/systems/sandbox.h"
#include "scenarios/code/systems/served_system.h"

namespace gaitcam {
namespace fs = std::filesystem;

namespace {

ProcessOptions OptionsOf(const SystemChoice& choice) {
  ProcessOptions options;
  options.readable = FilesOf(choice);
  if (choice.plugin) {
    options.command = WordsToServe(choice.plugin->plugin);
    options.frame_limit_s = choice.plugin->frame_limit_s;
    options.finish_limit_s = choice.plugin->finish_limit_s;
    options.memory_mb = choice.plugin->memory_mb;
  } else {
    options.command = choice.process->process;
    options.start_limit_s = choice.process->start_limit_s;
    options.frame_limit_s = choice.process->frame_limit_s;
    options.finish_limit_s = choice.process->finish_limit_s;
    options.memory_mb = choice.process->memory_mb;
  }
  return options;
}

}  // namespace

SystemInfo InfoOf(const SystemChoice& choice) {
  if (choice.command) return {choice.name, "somebody's program on a written dataset", {}, {}, false};
  if (choice.process) {
    return {choice.name, "somebody's program, frame by frame", {}, choice.process->needs, choice.process->acts};
  }
  if (!choice.plugin) return InfoOfSystem(choice.name);
  SystemInfo info = AskPluginInfo(choice.plugin->plugin, FilesOf(choice));
  info.name = choice.name;
  return info;
}

std::unique_ptr<System> MakeSystem(const SystemChoice& choice, const SystemSetup& setup, const fs::path& folder) {
  const fs::path log = folder / "system.log";
  if (choice.command) return std::make_unique<CommandSystem>(*choice.command, FilesOf(choice), setup, log);
  if (!choice.IsForeign()) return MakeSystem(choice.name, setup);
  SystemSetup told = setup;
  if (choice.process) told.settings = choice.process->settings;
  return std::make_unique<ProcessSystem>(OptionsOf(choice), told, log);
}

void CheckSettings(const SystemChoice& choice, const Calibration& calibration,
                   const std::shared_ptr<const RouteMap>& map) {
  const SystemSetup setup{calibration, 1, choice.settings, map};
  if (!choice.IsForeign()) MakeSystem(choice.name, setup);
  if (choice.plugin) ProcessSystem(OptionsOf(choice), setup, "/dev/null");
}

std::string SandboxOf(const SystemChoice& choice) {
  if (!choice.IsForeign()) return "";
  return WhyNoSandbox().empty() ? "bubblewrap" : "none: " + WhyNoSandbox();
}

}  // namespace gaitcam
