#include <fmt/format.h>

#include "scenarios/code/commands/commands.h"
#include "scenarios/code/commands/schema.h"

namespace gaitcam {

int SchemaCommand(const SchemaArguments& arguments) {
  fmt::print("{}\n", FileSchema(arguments.kind).dump(1));
  return 0;
}

}  // namespace gaitcam
