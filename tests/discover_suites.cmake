# Writes ctest's list of a GoogleTest program: an entry per test suite, so that what the tests of a suite share (a
# recording, a cluster, the libraries that a process loads) is made once. A failure names the single test all the same.
# Runs after the program is linked. Variables: PROGRAM, ROOM, LABEL, FILE.
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "(^|\n)[^ \n]+\\." suites "${listed}")
if(NOT suites)
  message(FATAL_ERROR "${PROGRAM} lists no tests")
endif()
set(script "")
foreach(suite ${suites})
  string(REGEX REPLACE "^\n|\\.$" "" suite ${suite})
  string(APPEND script "add_test([=[${ROOM}.${suite}]=] [=[${PROGRAM}]=] [=[--gtest_filter=${suite}.*]=])\n"
                       "set_tests_properties([=[${ROOM}.${suite}]=] PROPERTIES LABELS ${LABEL} TIMEOUT 900)\n")
endforeach()
file(WRITE ${FILE} "${script}")
