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
}

InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool InterruptGuard::Interrupted() const { return interrupted != 0; }

}  // namespace gaitcam
