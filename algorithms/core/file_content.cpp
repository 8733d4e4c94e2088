#include "algorithms/core/file_content.h"

#include <array>
#include <fstream>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace fs = std::filesystem;

std::string FileContent(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || fs::is_directory(file)) throw BadInput(file.string() + ": cannot read this file");
  std::string content;
  std::array<char, 1 << 16> piece;
  while (stream.read(piece.data(), piece.size()), stream.gcount() > 0)
    content.append(piece.data(), size_t(stream.gcount()));
  if (!stream.eof())
    throw BadInput(file.string() + ": reading broke off after " + std::to_string(content.size()) + " bytes");
  return content;
}

std::optional<std::string> FindFileContent(const fs::path& file) {
  try {
    return FileContent(file);
  } catch (const BadInput&) {
    std::error_code error;
    if (fs::status(file, error).type() == fs::file_type::not_found) return std::nullopt;  // perhaps only just
    throw;
  }
}

}  // namespace gaitcam
