/// Ctrl-C asks a job to stop at the next whole piece, as does a terminal that is closed; a second one ends the program
/// at once.

#pragma once

namespace gaitcam {

/// Catches SIGINT, SIGTERM and, unless it is ignored, SIGHUP while it lives.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  bool Interrupted() const;
};

}  // namespace gaitcam
