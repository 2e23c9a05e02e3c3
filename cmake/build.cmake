# Writes build.cpp anew where the sources or their commit have changed; run at every build.
# Takes ERTBENCH_FOLDER and OUTPUT.

# What the program is made of. A commit that changes nothing here, of results or pages say, leaves
# the program as it is.
set(sources core forward solvers models frames limit live bench cmake CMakeLists.txt CMakePresets.json)

string(REPLACE ";" " " ERTBENCH_SOURCES "${sources}")

set(ERTBENCH_COMMIT "unknown")
set(ERTBENCH_DIRTY false)
find_package(Git QUIET)
if(GIT_FOUND)
  execute_process(COMMAND ${GIT_EXECUTABLE} -C ${ERTBENCH_FOLDER} log -1 --format=%H -- ${sources}
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(NOT failed AND commit)
    string(SUBSTRING "${commit}" 0 12 ERTBENCH_COMMIT)
  endif()
  execute_process(COMMAND ${GIT_EXECUTABLE} -C ${ERTBENCH_FOLDER} status --porcelain -- ${sources}
    OUTPUT_VARIABLE changes ERROR_QUIET RESULT_VARIABLE failed)
  if(NOT failed AND changes)
    set(ERTBENCH_DIRTY true)
  endif()
endif()

file(READ ${ERTBENCH_FOLDER}/core/release_probes.json ERTBENCH_RELEASE_PROBES)

configure_file(${ERTBENCH_FOLDER}/core/build.cpp.in ${OUTPUT} @ONLY)
