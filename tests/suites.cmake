# Writes a file for ctest with one test for each suite of a googletest program:
#   cmake -DPROGRAM=... -DPREFIX=... -DOUTPUT=... -P suites.cmake
execute_process(COMMAND ${PROGRAM} --gtest_list_tests
  OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
# Suites stand at the left margin and end in a dot; their tests are indented. What follows a "#" are
# parameters, which may hold any character that means something in a list of CMake's.
string(REGEX REPLACE "#[^\n]*" "" listed "${listed}")
string(REGEX MATCHALL "(^|\n)[A-Za-z0-9_/]+\\.[ ]*(\n|$)" suites "${listed}")
set(written "")
foreach(suite IN LISTS suites)
  string(REGEX REPLACE "[\n .]" "" suite "${suite}")
  string(APPEND written
    "add_test([=[${PREFIX}${suite}]=] [=[${PROGRAM}]=] [=[--gtest_filter=${suite}.*]=])\n"
    "set_tests_properties([=[${PREFIX}${suite}]=] PROPERTIES TIMEOUT 1800 ENVIRONMENT OMP_NUM_THREADS=1)\n")
endforeach()
if(written STREQUAL "")
  message(FATAL_ERROR "${PROGRAM} lists no suites of tests")
endif()
file(WRITE ${OUTPUT} "${written}")
