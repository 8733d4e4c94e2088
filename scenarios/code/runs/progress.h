/// How far a long job is: a bar with rate and time left on a terminal, a plain line now and then otherwise.

#pragma once

#include <chrono>
#include <string>

namespace gaitcam {

class Progress {
 public:
  /// @param total expected count, or 0 if unknown. `quiet` says nothing at all. Writes to standard error.
  Progress(std::string label, int64_t total, bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Update(int64_t done);
  /// For those who learn on the way how much there is to do.
  void Update(int64_t done, int64_t total);
  /// Ends the bar's line; later updates say nothing.
  void Finish();

 private:
  using Clock = std::chrono::steady_clock;
  std::string Line(int64_t done, double elapsed_s) const;

  const std::string label_;
  int64_t total_;
  const bool on_terminal_;
  bool silent_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;
  int64_t done_ = 0;
};

}  // namespace gaitcam
