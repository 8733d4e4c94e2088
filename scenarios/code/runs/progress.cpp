#include "scenarios/code/runs/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace gaitcam {
namespace {

std::string Duration(double seconds) {
  const int whole = int(seconds + 0.5);
  return whole < 60 ? fmt::format("{} s", whole) : fmt::format("{}:{:02d} min", whole / 60, whole % 60);
}

}  // namespace

Progress::Progress(std::string label, int64_t total, bool quiet)
    : label_(std::move(label)), total_(total), on_terminal_(isatty(STDERR_FILENO)), silent_(quiet) {}

Progress::~Progress() { Finish(); }

std::string Progress::Line(int64_t done, double elapsed_s) const {
  const double rate = elapsed_s > 0 ? double(done) / elapsed_s : 0;
  std::string line = fmt::format("{} {}", label_, done);
  if (total_ > 0) {
    const double part = std::min(1.0, double(done) / double(total_));
    if (on_terminal_) {
      const int filled = int(part * 24);
      line = fmt::format("{} [{:#<{}}{:.<{}}] {}/{}", label_, "", filled, "", 24 - filled, done, total_);
    } else {
      line += fmt::format("/{}", total_);
    }
  }
  return line + fmt::format("  {:.1f}/s", rate);
}

void Progress::Update(int64_t done) {
  done_ = done;
  if (silent_) return;
  const auto now = Clock::now();
  const double since_last = std::chrono::duration<double>(now - last_).count();
  if (since_last < (on_terminal_ ? 0.1 : 5.0)) return;
  last_ = now;
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  std::string line = Line(done, elapsed_s);
  if (total_ > done && done > 0)
    line += fmt::format("  {} left", Duration(double(total_ - done) / double(done) * elapsed_s));
  std::fprintf(stderr, on_terminal_ ? "\r\033[K%s" : "%s\n", line.c_str());
}

void Progress::Update(int64_t done, int64_t total) {
  total_ = total;
  Update(done);
}

void Progress::Finish() {
  if (silent_) return;
  silent_ = true;
  const double elapsed_s = std::chrono::duration<double>(Clock::now() - start_).count();
  std::fprintf(stderr, "%s%s in %s\n", on_terminal_ ? "\r\033[K" : "", Line(done_, elapsed_s).c_str(),
               Duration(elapsed_s).c_str());
}

}  // namespace gaitcam
