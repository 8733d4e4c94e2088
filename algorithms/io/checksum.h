/// SHA-256 of texts and files, as `sha256sum` prints it.

#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace gaitcam {

/// 64 hexadecimal digits.
std::string Sha256(std::string_view bytes);

/// Reads the file piece by piece. @throws BadInput if it cannot be read.
std::string Sha256OfFile(const std::filesystem::path& file);

}  // namespace gaitcam
