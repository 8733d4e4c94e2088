#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "algorithms/core/errors.h"
#include "scenarios/code/systems/frame_protocol.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

size_t ColourBytes(const CameraModel& camera) { return 3 * size_t(camera.width_px) * size_t(camera.height_px); }

size_t BytesOf(const Calibration& calibration) {
  return ColourBytes(calibration.camera) + (calibration.right ? ColourBytes(*calibration.right) : 0) +
         (calibration.has_depth ? sizeof(float) * ColourBytes(calibration.camera) / 3 : 0);
}

[[noreturn]] void FailOn(const fs::path& file) { throw MissingResource(file.string() + ": " + std::strerror(errno)); }

}  // namespace

SharedFrames::SharedFrames(const fs::path& file, const Calibration& calibration)
    : file_(file), size_(BytesOf(calibration)) {
  const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (descriptor < 0) FailOn(file);
  if (posix_fallocate(descriptor, 0, off_t(size_)) != 0) {
    close(descriptor);
    throw MissingResource(file.string() + ": no room for a frame");
  }
  Map(descriptor, true);
}

SharedFrames::SharedFrames(const fs::path& file) : file_(file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) FailOn(file);
  struct stat status = {};
  fstat(descriptor, &status);
  size_ = size_t(status.st_size);
  Map(descriptor, false);
}

void SharedFrames::Map(int descriptor, bool writes) {
  void* const data = mmap(nullptr, size_, writes ? PROT_READ | PROT_WRITE : PROT_READ, MAP_SHARED, descriptor, 0);
  close(descriptor);
  if (data == MAP_FAILED) FailOn(file_);
  data_ = static_cast<uint8_t*>(data);
}

SharedFrames::~SharedFrames() { munmap(data_, size_); }

}  // namespace gaitcam
