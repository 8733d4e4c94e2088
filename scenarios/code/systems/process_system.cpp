#include "scenarios/code/systems/process_system.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <limits>
#include <utility>

#include "algorithms/core/errors.h"
#include "scenarios/code/systems/foreign_words.h"
#include "scenarios/code/systems/frame_protocol.h"
#include "scenarios/code/systems/private_folder.h"
#include "scenarios/code/systems/sandbox.h"
#include "scenarios/code/systems/subprocess.h"

namespace gaitcam {
namespace fs = std::filesystem;

namespace {

/// What went wrong between us and the program, as a failure of the program.
class Breakdown : public std::exception {
 public:
  explicit Breakdown(std::string what) : what_(std::move(what)) {}
  const char* what() const noexcept override { return what_.c_str(); }

 private:
  std::string what_;
};

/// An open file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { Close(); }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  void Close() {
    if (number_ >= 0) close(std::exchange(number_, -1));
  }
  int number() const { return number_; }

 private:
  int number_;
};

/// The time by which something has to be done, whatever else comes in meanwhile.
class Deadline {
 public:
  explicit Deadline(double limit_s)
      : limit_s_(limit_s),
        end_(Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limit_s))) {}

  /// Waits until `descriptor` is ready for `events`. @returns false when the time is up.
  bool Wait(int descriptor, short events) const {
    for (;;) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(end_ - Clock::now()).count();
      if (left <= 0) return false;
      pollfd ready = {descriptor, events, 0};
      const int n = poll(&ready, 1, int(std::min<int64_t>(left, std::numeric_limits<int>::max())));
      if (n > 0) return true;
      if (n < 0 && errno != EINTR) return true;  // what is wrong with it comes out when it is used
    }
  }
  std::string Words() const { return fmt::format(" within {:g} s", limit_s_); }

 private:
  using Clock = std::chrono::steady_clock;
  double limit_s_;
  Clock::time_point end_;
};

constexpr size_t kMaxShown = 60;

/// Both ends of a stream: ours, the program's.
std::pair<Descriptor, Descriptor> MakeStream() {
  std::array<int, 2> ends = {-1, -1};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw MissingResource(std::string("cannot make a stream to another process: ") + std::strerror(errno));
  }
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

}  // namespace

/// The program and the lines to and from it.
class ProcessSystem::Conversation {
 public:
  Conversation(const ProcessOptions& options, const Calibration& calibration, const fs::path& log)
      : frames_(folder_.path() / "frames", calibration), log_(log), to_(MakeStream()), from_(MakeStream()) {
    fs::create_directory(work());
    program_.emplace(Words(options), SubprocessStreams{.log = PrivateLog(),
                                                       .input = to_.second.number(),
                                                       .output = from_.second.number(),
                                                       .folder = work(),
                                                       .max_file_bytes = kMaxForeignFile_bytes,
                                                       .max_memory_mb = ForeignMemory_mb(options.memory_mb),
                                                       .max_processes = kMaxForeignProcesses,
                                                       .max_folder_bytes = kMaxForeignFolder_bytes,
                                                       .max_folder_files = kMaxForeignFiles});
    to_.second.Close();
    from_.second.Close();
  }

  ~Conversation() {
    program_.reset();
    std::error_code ignored;
    fs::copy_file(PrivateLog(), log_, fs::copy_options::overwrite_existing, ignored);
  }
  Conversation(const Conversation&) = delete;
  Conversation& operator=(const Conversation&) = delete;

  SharedFrames& frames() { return frames_; }

  /// Says a line and hears one. @throws Breakdown.
  std::string Ask(const std::string& line, double limit_s) {
    const Deadline deadline(limit_s);
    if (HasSaidMore()) throw Breakdown("said something that it was not asked: " + heard_.substr(0, kMaxShown));
    Send(line + "\n", deadline);
    return Hear(deadline);
  }

  /// After the last answer it may end by itself.
  void End() {
    to_.first.Close();
    constexpr double kGrace_s = 2;
    program_->Wait(kGrace_s);
  }

 private:
  fs::path work() const { return folder_.path() / "work"; }
  /// Not beside the truth: the program can see its name.
  fs::path PrivateLog() const { return folder_.path() / "log"; }

  std::vector<std::string> Words(const ProcessOptions& options) const {
    if (!WhyNoSandbox().empty()) return options.command;
    SandboxView view{options.readable, {work()}, work()};
    view.readable.push_back(frames_.file());
    return Sandboxed(options.command, view);
  }

  /// A line that nobody asked for would be taken for the answer to the next frame.
  bool HasSaidMore() {
    std::array<char, kMaxShown> bytes;
    const ssize_t n = heard_.empty() ? recv(from_.first.number(), bytes.data(), bytes.size(), MSG_DONTWAIT) : 0;
    if (n > 0) heard_.append(bytes.data(), size_t(n));
    return !heard_.empty();
  }

  /// What does not read must not hold us up.
  void Send(const std::string& text, const Deadline& deadline) {
    for (size_t sent = 0; sent < text.size();) {
      const ssize_t n = send(to_.first.number(), text.data() + sent, text.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (n >= 0) {
        sent += size_t(n);
      } else if (errno == EAGAIN) {
        if (!deadline.Wait(to_.first.number(), POLLOUT)) throw Breakdown("did not read" + deadline.Words());
      } else if (errno != EINTR) {
        throw Breakdown(HowItEnded());
      }
    }
  }

  std::string Hear(const Deadline& deadline) {
    constexpr size_t kMaxLine = 256 << 20;
    for (size_t searched = 0;;) {
      if (const size_t at = heard_.find('\n', searched); at != std::string::npos) {
        std::string line = heard_.substr(0, at);
        heard_.erase(0, at + 1);
        return line;
      }
      searched = heard_.size();
      if (searched > kMaxLine) throw Breakdown("answered with a line without an end");
      if (!deadline.Wait(from_.first.number(), POLLIN)) throw Breakdown("did not answer" + deadline.Words());
      Receive();
    }
  }

  void Receive() {
    std::array<char, 65536> bytes;
    const ssize_t n = recv(from_.first.number(), bytes.data(), bytes.size(), 0);
    if (n < 0 && errno == EINTR) return;
    if (n <= 0) throw Breakdown(HowItEnded());
    heard_.append(bytes.data(), size_t(n));
  }

  /// With its last words.
  std::string HowItEnded() {
    constexpr double kGrace_s = 2;
    const std::optional<Ending> ending = program_->Wait(kGrace_s);
    const std::string said = LastLine(PrivateLog());
    return (ending ? EndingIn(*ending).ToText() : "closed its output") + (said.empty() ? "" : ": " + said);
  }

  PrivateFolder folder_ = PrivateFolder::InMemory();
  SharedFrames frames_;
  fs::path log_;
  std::pair<Descriptor, Descriptor> to_, from_;
  std::optional<Subprocess> program_;
  std::string heard_;  ///< Not yet a whole line.
};

ProcessSystem::ProcessSystem(const ProcessOptions& options, const SystemSetup& setup, const fs::path& log)
    : options_(options) {
  conversation_ = std::make_unique<Conversation>(options, setup.calibration, log);
  std::string refusal;
  try {
    refusal =
        ReadReady(conversation_->Ask(StartMessage(setup, conversation_->frames().file()), options_.start_limit_s));
  } catch (const Breakdown& e) {
    Fail("at its start", e.what());
  } catch (const BadInput& e) {
    Fail("at its start", std::string("answered ") + e.what());
  }
  if (!refusal.empty()) throw BadInput(ForeignWords(refusal));
}

ProcessSystem::~ProcessSystem() = default;

void ProcessSystem::Fail(const std::string& when, const std::string& what) {
  failure_ = when + " it " + what;
  conversation_.reset();
  command_ = FollowPath();
}

FrameEstimate ProcessSystem::Track(const Observation& observation) {
  ++frames_;
  if (conversation_) {
    try {
      const std::string line =
          conversation_->Ask(FrameMessage(observation, conversation_->frames()), options_.frame_limit_s);
      FrameAnswer answer = ReadAnswer(line, observation.stamp_ns);
      command_ = answer.command;
      had_pose_ |= answer.frame.pose.has_value();
      return answer.frame;
    } catch (const Breakdown& e) {
      Fail(fmt::format("at frame {}", frames_), e.what());
    } catch (const BadInput& e) {
      Fail(fmt::format("at frame {}", frames_), std::string("answered ") + e.what());
    }
  }
  FrameEstimate none;
  none.stamp_ns = observation.stamp_ns;
  none.status = had_pose_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
  return none;
}

FinalEstimate ProcessSystem::Finish() {
  FinalEstimate answer;
  if (conversation_) {
    try {
      answer = ReadFinal(conversation_->Ask(FinishMessage(), options_.finish_limit_s));
      conversation_->End();
    } catch (const Breakdown& e) {
      Fail("at the end", e.what());
    } catch (const BadInput& e) {
      Fail("at the end", std::string("answered ") + e.what());
    }
    conversation_.reset();
  }
  if (!failure_.empty()) answer.failure = failure_;
  return answer;
}

}  // namespace gaitcam
