#include <fmt/format.h>

#include "algorithms/core/errors.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/systems/served_system.h"

namespace gaitcam {

int ServeCommand(const ServeArguments& arguments) {
  if (arguments.plugin.empty()) {
    if (arguments.system.empty()) throw BadInput("serve: expected a system, or --plugin LIBRARY");
    const std::string name = arguments.system;
    const auto make = [name](const SystemSetup& setup) { return MakeSystem(name, setup); };
    return ServeSystem(make, InfoOfSystem(name).acts);
  }
  const SystemPlugin& plugin = LoadPlugin(arguments.plugin);
  if (arguments.info) {
    fmt::print("{}\n", PluginInfoText(plugin.info));
    return 0;
  }
  return ServeSystem(plugin.make, plugin.info.acts);
}

}  // namespace gaitcam
