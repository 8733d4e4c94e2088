/// Entries of the cache of recorded walks and of places: folders side by side, each with its lock beside it.

#pragma once

#include <cstdint>
#include <filesystem>

#include "scenarios/code/runs/output_folder.h"

namespace gaitcam {

/// In every entry, written last: an entry that has it is complete. Its time is when the entry was last used.
constexpr const char* kCacheEntryAbout = "sequence.json";

/// Beside the entry, so that it outlives the entry's removal.
std::filesystem::path CacheEntryLock(const std::filesystem::path& entry);

/// Notes in the entry how large it is; before kCacheEntryAbout is written. @throws MissingResource.
void NoteCacheEntrySize(const OutputFolder& entry);

/// In bytes, as noted; of an entry without a note, which an older program made, all of its files. Whoever records looks
/// at all entries: with files counted one by one, a study of thousands of walks came to do little else.
uintmax_t CacheEntrySize(const std::filesystem::path& entry);

}  // namespace gaitcam
