#include <malloc.h>

#include "scenarios/code/commands/command_line.h"

int main(int argc, char** argv) {
  // Threads that each keep their own free memory keep a sixth of a run's. None allocates so often that one suffices
  // not.
  mallopt(M_ARENA_MAX, 1);
  // The next frame needs as much memory as the last one freed. Given back to the system and cleared anew in between, it
  // would cost a tenth of a run's processor time; to keep it costs a hundredth more memory.
  constexpr int kMiB = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMiB);  // the largest that there is
  mallopt(M_TRIM_THRESHOLD, 256 * kMiB);
  return gaitcam::CommandLine(argc, argv);
}
