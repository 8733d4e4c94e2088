/// What a program of ours ends with: one line on standard error and the exit code that belongs to it.

#pragma once

#include <functional>
#include <string>

namespace gaitcam {

/// Prints "gaitcam: LINE" on standard error, after what standard output still holds: a failure is the last line.
/// @returns `code`.
int Fail(int code, const std::string& line);

/// The exit code of `work`, or of what it throws: 2 for BadInput, 3 for TooLittleData, 4 for MissingResource, for
/// files that cannot be read or written and for memory that is not there, 70 for anything else.
int WithExitCode(const std::function<int()>& work);

}  // namespace gaitcam
