/// Ctrl-C asks a job to stop at the next whole piece; a second one ends the program at once.

#pragma once

namespace gaitcam {

/// Catches SIGINT and SIGTERM while it lives.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  bool Interrupted() const;
};

}  // namespace gaitcam
