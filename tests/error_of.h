/// What an error says.

#pragma once

#include <gtest/gtest.h>

#include <string>

#include "algorithms/core/errors.h"

namespace gaitcam {

/// The message of the Exception that `act` throws; it is a failure of the test if it throws none.
template <class Exception = BadInput, class Act>
std::string ErrorOf(Act act) {
  try {
    act();
  } catch (const Exception& e) {
    return e.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

}  // namespace gaitcam
