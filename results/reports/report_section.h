/// A part of a run's page that not every run has, such as that of a map.

#pragma once

#include <string>

namespace gaitcam {

/// HTML, all three may be empty.
struct ReportSection {
  std::string cards;  ///< <div> cards for the row of main figures.
  std::string body;   ///< Below the paths.
  std::string style;  ///< CSS that it needs.
};

}  // namespace gaitcam
