#include "scenarios/code/commands/commands.h"
#include "scenarios/code/jobs/executor.h"

namespace gaitcam {

int WorkCommand(const WorkArguments& arguments, const CommonOptions&) {
  return WorkOn(arguments.runs, arguments.hash, arguments.cache);
}

}  // namespace gaitcam
