#include <malloc.h>

#include "scenarios/code/commands/command_line.h"

int main(int argc, char** argv) {
  // Threads that each keep their own free memory keep a sixth of a run's. None allocates so often that one suffices
  // not.
  mallopt(M_ARENA_MAX, 1);
  return gaitcam::CommandLine(argc, argv);
}
