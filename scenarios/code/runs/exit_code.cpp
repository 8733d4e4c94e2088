#include "scenarios/code/runs/exit_code.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>
#include <system_error>

#include "algorithms/core/errors.h"
#include "scenarios/code/runs/terminal_text.h"

namespace gaitcam {

int Fail(int code, const std::string& line) {
  std::fflush(stdout);
  std::fprintf(stderr, "%s %s\n", Red("gaitcam:", stderr).c_str(), line.c_str());
  return code;
}

int WithExitCode(const std::function<int()>& work) {
  try {
    const int code = work();
    if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return code;
    throw MissingResource(std::string("standard output: cannot write to it: ") + std::strerror(errno));
  } catch (const BadInput& e) {
    return Fail(2, e.what());
  } catch (const TooLittleData& e) {
    return Fail(3, e.what());
  } catch (const MissingResource& e) {
    return Fail(4, e.what());
  } catch (const std::system_error& e) {
    return Fail(4, e.what());  // disk full, no permission, no more threads
  } catch (const std::bad_alloc&) {
    return Fail(4, "the machine has not enough memory for this");
  } catch (const std::exception& e) {
    return Fail(70, std::string("internal error, please report it: ") + e.what());
  }
}

}  // namespace gaitcam
