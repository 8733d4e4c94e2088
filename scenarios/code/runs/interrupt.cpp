#include "scenarios/code/runs/interrupt.h"

#include <csignal>

namespace gaitcam {
namespace {

volatile std::sig_atomic_t interrupted = 0;  // a signal handler can reach nothing else

void Note(int signal) {
  interrupted = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

InterruptGuard::InterruptGuard() {
  interrupted = 0;
  std::signal(SIGINT, Note);
  std::signal(SIGTERM, Note);
  if (std::signal(SIGHUP, Note) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // nohup: it is to go on
}

InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  if (std::signal(SIGHUP, SIG_DFL) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

bool InterruptGuard::Interrupted() const { return interrupted != 0; }

}  // namespace gaitcam
