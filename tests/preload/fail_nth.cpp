// A library to preload into a program: the n-th call of one kind fails, as on a full disk, without descriptors, without
// memory. Told by the environment:
//   GAITCAM_FAIL=KIND:N[:all|:kill]   KIND is open, read, write, rename, mkdir or mmap; all: every call from the n-th
//                                     on; kill: instead of the call the program is killed
//   GAITCAM_FAIL_HIT=FILE       made when a call has failed
// Only what the program and its libraries call by name is seen, not what the C library calls within itself, and only
// from main() on.

#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

struct Plan {
  char kind[16] = "";
  long nth = 0;
  bool all = false, kills = false;
  const char* hit = nullptr;

  Plan() {
    const char* text = std::getenv("GAITCAM_FAIL");
    if (text == nullptr) return;
    char more[8] = "";
    std::sscanf(text, "%15[a-z]:%ld:%7[a-z]", kind, &nth, more);
    all = std::strcmp(more, "all") == 0;
    kills = std::strcmp(more, "kill") == 0;
    hit = std::getenv("GAITCAM_FAIL_HIT");
  }
};

std::atomic<long> calls{0};
std::atomic<bool> is_in_main{false};
int (*real_main)(int, char**, char**) = nullptr;

int Main(int count, char** words, char** environment) {
  is_in_main = true;
  return real_main(count, words, environment);
}

/// Whether this call is to fail.
bool Fails(const char* kind, int error) {
  if (!is_in_main) return false;
  static const Plan plan;
  if (std::strcmp(plan.kind, kind) != 0) return false;
  const long call = ++calls;
  if (call != plan.nth && !(plan.all && call > plan.nth)) return false;
  if (plan.hit != nullptr) {
    const long file = syscall(SYS_openat, AT_FDCWD, plan.hit, O_CREAT | O_WRONLY, 0600);
    if (file >= 0) syscall(SYS_close, file);
  }
  if (plan.kills) kill(getpid(), SIGKILL);
  errno = error;
  return true;
}

template <class Function>
Function* Next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

/// @param list what follows the flags: the mode, where a file may be made
int Open(const char* path, int flags, va_list list) {
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
  return Fails("open", EMFILE) ? -1 : int(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

}  // namespace

extern "C" {

int __libc_start_main(int (*main)(int, char**, char**), int count, char** words, void (*init)(), void (*fini)(),
                      void (*linker_fini)(), void* stack_end) {
  real_main = main;
  return Next<decltype(__libc_start_main)>("__libc_start_main")(Main, count, words, init, fini, linker_fini, stack_end);
}

int open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const int file = Open(path, flags, list);
  va_end(list);
  return file;
}

int open64(const char* path, int flags, ...) __attribute__((alias("open")));

FILE* fopen(const char* path, const char* mode) {
  static auto* const next = Next<FILE*(const char*, const char*)>("fopen");
  return Fails("open", EMFILE) ? nullptr : next(path, mode);
}

FILE* fopen64(const char* path, const char* mode) {
  static auto* const next = Next<FILE*(const char*, const char*)>("fopen64");
  return Fails("open", EMFILE) ? nullptr : next(path, mode);
}

ssize_t read(int file, void* to, size_t size) {
  static auto* const next = Next<ssize_t(int, void*, size_t)>("read");
  return Fails("read", EIO) ? -1 : next(file, to, size);
}

ssize_t write(int file, const void* from, size_t size) {
  static auto* const next = Next<ssize_t(int, const void*, size_t)>("write");
  return Fails("write", ENOSPC) ? -1 : next(file, from, size);
}

ssize_t writev(int file, const iovec* from, int count) {
  static auto* const next = Next<ssize_t(int, const iovec*, int)>("writev");
  return Fails("write", ENOSPC) ? -1 : next(file, from, count);
}

size_t fwrite(const void* from, size_t size, size_t count, FILE* file) {
  static auto* const next = Next<size_t(const void*, size_t, size_t, FILE*)>("fwrite");
  return file != stderr && Fails("write", ENOSPC) ? 0 : next(from, size, count, file);
}

int rename(const char* from, const char* to) {
  static auto* const next = Next<int(const char*, const char*)>("rename");
  return Fails("rename", EACCES) ? -1 : next(from, to);
}

int mkdir(const char* path, mode_t mode) {
  static auto* const next = Next<int(const char*, mode_t)>("mkdir");
  return Fails("mkdir", ENOSPC) ? -1 : next(path, mode);
}

void* mmap(void* at, size_t size, int protection, int flags, int file, off_t offset) {
  static auto* const next = Next<void*(void*, size_t, int, int, int, off_t)>("mmap");
  return Fails("mmap", ENOMEM) ? MAP_FAILED : next(at, size, protection, flags, file, offset);
}

}  // extern "C"
