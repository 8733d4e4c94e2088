/// Files and folders that appear whole or not at all: they are written beside the wanted name, under one of this
/// process's own, and then renamed.

#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace gaitcam {

/// What the names of everything unfinished begin with that is to become `wanted`: ".NAME.part-".
std::string UnfinishedPrefix(const std::filesystem::path& wanted);

/// Where this process writes what is to become `wanted`: beside it.
std::filesystem::path UnfinishedNameFor(const std::filesystem::path& wanted);

/// "MACHINE-NUMBER" of this process, for names of what is its own for a while.
std::string NameOfProcess();

/// Removes the files and folders in `folder` whose names are `prefix`, the name of a process of this machine that is no
/// more, and perhaps "-" and something behind it.
void RemoveAbandoned(const std::filesystem::path& folder, const std::string& prefix);

/// Whether there is one of those.
bool HoldsAbandoned(const std::filesystem::path& folder, const std::string& prefix);

/// Those that were to become `wanted`.
void RemoveAbandoned(const std::filesystem::path& wanted);

/// Writes a file, in place of an older one if there is one. A symbolic link stays: the file that it names is replaced.
/// A device or a pipe, as /dev/stdout, is written to and never replaced.
/// @throws BadInput if the name is a folder's; MissingResource if the file cannot be written whole, the older one is
/// then untouched.
void WriteWholeFile(const std::filesystem::path& file, std::string_view content);

/// @param error of errno
/// @throws MissingResource, "FILE: cannot write this file: No space left on device".
[[noreturn]] void FailToWrite(const std::filesystem::path& file, int error);

/// What WriteWholeFile would throw for want of a folder, of permission or of another name; for what takes long before
/// it writes. Nothing stays behind.
void CheckWritable(const std::filesystem::path& file);

}  // namespace gaitcam
