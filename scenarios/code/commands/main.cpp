#include "scenarios/code/commands/command_line.h"

int main(int argc, char** argv) { return gaitcam::CommandLine(argc, argv); }
