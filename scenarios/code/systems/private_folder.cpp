#include "scenarios/code/systems/private_folder.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

#include "algorithms/core/errors.h"
#include "algorithms/io/remove_tree.h"
#include "algorithms/io/whole_file.h"

namespace gaitcam {
namespace fs = std::filesystem;

PrivateFolder::PrivateFolder(const fs::path& parent) {
  const std::string prefix = "gaitcam-";
  RemoveAbandoned(parent, prefix);
  std::string name = (parent / (prefix + NameOfProcess() + "-XXXXXX")).string();
  if (mkdtemp(name.data()) == nullptr)
    throw MissingResource("cannot make a folder " + name + ": " + std::strerror(errno));
  path_ = name;
}

PrivateFolder PrivateFolder::InMemory() {
  const fs::path memory = "/dev/shm";
  std::error_code ignored;
  return PrivateFolder(fs::is_directory(memory, ignored) ? memory : fs::temp_directory_path());
}

PrivateFolder::~PrivateFolder() { RemoveTree(path_); }

}  // namespace gaitcam
