// A folder of its own for each test, gone afterwards.

#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/error_of.h"
#include "tests/temporary_folder.h"

namespace gaitcam {

class FileTest : public ::testing::Test {
 protected:
  std::filesystem::path Write(const std::string& name, const std::string& text) const {
    return temporary_.Write(name, text);
  }

  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

}  // namespace gaitcam
