# Installs the build BUILD into WORK, builds the project CONSUMER of the solver SOLVER against it, and
# runs an experiment with that solver by the installed program.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "${ARGN}\nfailed (${failed}):\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${WORK}/build -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_PREFIX_PATH=${WORK}/prefix -DSOLVER=${SOLVER})
run(${CMAKE_COMMAND} --build ${WORK}/build)
file(COPY ${WORK}/build/libmy_solver.so ${CONSUMER}/experiment.json DESTINATION ${WORK})
run(${CMAKE_COMMAND} -E env ERTBENCH_CACHE=${WORK}/cache
    ${WORK}/prefix/bin/ertbench run ${WORK}/experiment.json --out ${WORK}/results --jobs 1)
file(READ ${WORK}/results/summary.json summary)
string(JSON count LENGTH ${summary} rows)
math(EXPR last "${count} - 1")
string(JSON type GET ${summary} rows ${last} type)
string(JSON status GET ${summary} rows ${last} status)
string(JSON error GET ${summary} rows ${last} metrics relative_error mean)
if(NOT type STREQUAL "back-projection" OR NOT status STREQUAL "ok" OR NOT error LESS 1)
  message(FATAL_ERROR "the row of the solver is ${type}, ${status}, relative error ${error}")
endif()
