# Writes version.cpp anew where the commit has changed; run at every build.
find_package(Git QUIET)
set(ERTBENCH_COMMIT "unknown")
if(GIT_FOUND)
  execute_process(COMMAND ${GIT_EXECUTABLE} -C ${ERTBENCH_FOLDER} describe --always --dirty --abbrev=12
    OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(NOT failed)
    set(ERTBENCH_COMMIT "${described}")
  endif()
endif()
configure_file(${ERTBENCH_FOLDER}/bench/record/version.cpp.in ${OUTPUT} @ONLY)
