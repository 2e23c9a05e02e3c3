# Installs the build BUILD into WORK, builds the project CONSUMER of the solver SOLVER against it, and
# runs an experiment with that solver by the installed program. MODELS: the learned ones must be there.
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
execute_process(COMMAND ${WORK}/prefix/bin/ertbench list OUTPUT_VARIABLE solvers)
if(MODELS AND solvers MATCHES "not available")
  message(FATAL_ERROR "the installed program does not find the learned solvers:\n${solvers}")
endif()
file(READ ${WORK}/results/summary.json summary)
string(JSON count LENGTH ${summary} rows)
math(EXPR last "${count} - 1")
string(JSON type GET ${summary} rows ${last} type)
string(JSON status GET ${summary} rows ${last} status)
string(JSON error GET ${summary} rows ${last} metrics relative_error mean)
if(NOT type STREQUAL "back-projection" OR NOT status STREQUAL "ok" OR NOT error LESS 1)
  message(FATAL_ERROR "the row of the solver is ${type}, ${status}, relative error ${error}")
endif()

# The example of a robot's program, built against the installed runtime alone.
run(${CMAKE_COMMAND} -S ${ROBOT} -B ${WORK}/robot -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_PREFIX_PATH=${WORK}/prefix)
run(${CMAKE_COMMAND} --build ${WORK}/robot)
run(${WORK}/prefix/bin/ertbench export tsvd --to runtime --out ${WORK}/robot)
run(${WORK}/robot/latency ${WORK}/robot/tsvd.ert 2000)
run(python3 ${CONSUMER}/send_frames.py ${WORK}/robot/udp_contacts ${WORK}/robot/tsvd.ert)

# Built with another alignment of Eigen's it is refused by name, before anything of it runs.
run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${WORK}/other_build -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_PREFIX_PATH=${WORK}/prefix -DSOLVER=${SOLVER}
    -DCMAKE_CXX_FLAGS=-DEIGEN_MAX_ALIGN_BYTES=128)
run(${CMAKE_COMMAND} --build ${WORK}/other_build)
file(COPY ${WORK}/other_build/libmy_solver.so ${CONSUMER}/experiment.json DESTINATION ${WORK}/other)
execute_process(
  COMMAND ${CMAKE_COMMAND} -E env ERTBENCH_CACHE=${WORK}/cache
          ${WORK}/prefix/bin/ertbench run ${WORK}/other/experiment.json --out ${WORK}/other/results
  RESULT_VARIABLE code OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(NOT code EQUAL 2 OR NOT said MATCHES "alignment 128 bytes")
  message(FATAL_ERROR "a plugin of another alignment ended with ${code}:\n${said}")
endif()
