/// What can go wrong, as types: whose fault it is decides the exit code.

#pragma once

#include <stdexcept>
#include <string>

namespace gaitcam {

/// The user's input cannot be used. The text is one line naming file, line, key, value and what would be right; exit 2.
class BadInput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A field of an options struct is out of its permitted range. The text names field, value and range; exit 2.
class BadOption : public BadInput {
 public:
  using BadInput::BadInput;
};

/// Nothing was evaluated, or too little was covered for a score to mean anything; exit 3.
class TooLittleData : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The machine lacks something (an EGL device, a writable folder); exit 4.
class MissingResource : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

namespace internal {
[[noreturn]] void AssertionFailed(const char* condition, const char* file, int line);
}  // namespace internal

}  // namespace gaitcam

/// An assertion that stays on in release builds: a bug of ours, never the user's input. Throws std::logic_error.
#define GAITCAM_ASSERT(condition) \
  ((condition) ? void(0) : ::gaitcam::internal::AssertionFailed(#condition, __FILE__, __LINE__))
