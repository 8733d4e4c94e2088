/// Style sheets and scripts of our pages: the files in results/reports/page, embedded when the program is built.

#pragma once

#include <string_view>

namespace gaitcam::internal {

/// @param name of a file in results/reports/page, such as "report.css". @pre it is there.
std::string_view PageFile(std::string_view name);

}  // namespace gaitcam::internal
