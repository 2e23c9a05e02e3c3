# Configures the sources SOURCE in two folders of WORK, one of which has rooms' names in its path. The
# commands that compile them must be the same but for the path: a checkout may lie anywhere.
function(compile_commands variable folder)
  file(COPY ${SOURCE}/core ${SOURCE}/forward ${SOURCE}/runtime ${SOURCE}/solvers ${SOURCE}/frames ${SOURCE}/limit
    ${SOURCE}/live ${SOURCE}/bench ${SOURCE}/python ${SOURCE}/cmake
    ${SOURCE}/CMakeLists.txt ${SOURCE}/CMakePresets.json ${SOURCE}/LICENSE ${SOURCE}/CITATION.cff ${SOURCE}/CHANGELOG.md
    DESTINATION ${folder})
  file(COPY ${SOURCE}/models/inference DESTINATION ${folder}/models)
  # Benchmarks, learned solvers and tests are found slowly, and lie in folders of their own.
  execute_process(
    COMMAND ${CMAKE_COMMAND} --preset release -DERTBENCH_BENCHMARKS=OFF -DERTBENCH_MODELS=OFF
            -DBUILD_TESTING=OFF
    WORKING_DIRECTORY ${folder}
    RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "in ${folder} the configuration failed (${failed}):\n${output}")
  endif()
  file(READ ${folder}/build/release/compile_commands.json commands)
  string(REPLACE ${folder} "" commands "${commands}")
  set(${variable} "${commands}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK})
compile_commands(plain ${WORK}/ertbench)
compile_commands(named ${WORK}/check/benchmarks/bench/charts/ertbench)
if(NOT plain MATCHES "/bench/CMakeFiles/ertbench_bench")
  message(FATAL_ERROR "no commands of bench/ among:\n${plain}")
endif()
if(NOT plain STREQUAL named)
  file(WRITE ${WORK}/plain.json "${plain}")
  file(WRITE ${WORK}/named.json "${named}")
  message(FATAL_ERROR "${WORK}/plain.json and ${WORK}/named.json differ")
endif()
