#include "scenarios/commands.h"
#include "algorithms/core/errors.h"
namespace gaitcam {
int RecordCommand(const RecordArguments&, const CommonOptions&) { throw BadInput("record: being built"); }
int TrackCommand(const TrackArguments&, const CommonOptions&) { throw BadInput("track: being built"); }
}
