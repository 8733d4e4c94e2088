/// The command line: parses verbs and options, maps exceptions to exit codes.

#pragma once

namespace gaitcam {

/// Exit codes: 0 done; 2 bad input; 3 too little was covered to score; 4 the machine lacks something; 130 interrupted.
int CommandLine(int argc, char** argv);

}  // namespace gaitcam
