# Packs the build BUILD as Debian packages (without errors of lintian, where that is), unpacks them under
# WORK/root, and runs a small form of the quick experiment by the program in it, in a home of its own; then
# the Python package, where it was built.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "${ARGN}\nfailed (${failed}):\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK})
run(cpack -G DEB --config ${BUILD}/CPackConfig.cmake -B ${WORK})
file(GLOB package ${WORK}/ertbench_*.deb)
run(dpkg-deb --field ${package})
foreach(needed "Section: science" "libhdf5" "libtorch" "liblapack3" "gnuplot-nox")
  if(NOT output MATCHES ${needed})
    message(FATAL_ERROR "the package says nothing of \"${needed}\":\n${output}")
  endif()
endforeach()
find_program(lintian lintian)
if(lintian)
  run(${lintian} --allow-root --fail-on error ${package})
endif()
run(dpkg-deb -x ${package} ${WORK}/root)

set(usr ${WORK}/root/usr)
set(program ${CMAKE_COMMAND} -E env --unset=ERTBENCH_CACHE --unset=ERTBENCH_LAUNCHER
  --unset=XDG_CACHE_HOME HOME=${WORK}/home ${usr}/bin/ertbench)
run(${program} run ${usr}/share/ertbench/experiments/quick.json --only tsvd,fcnn --out ${WORK}/results
  --set datasets.train.count=500 --set datasets.validation.count=40 --set datasets.test.count=40)
file(READ ${WORK}/results/summary.json summary)
foreach(row 0 1)
  string(JSON status GET "${summary}" rows ${row} status)
  if(NOT status STREQUAL "ok")
    message(FATAL_ERROR "row ${row} is ${status}:\n${summary}")
  endif()
endforeach()
if(NOT IS_DIRECTORY ${WORK}/home/.cache/ertbench/datasets)
  message(FATAL_ERROR "the datasets are not in the user's cache")
endif()
# A fitted solver by its name.
run(${program} generate ${usr}/share/ertbench/experiments/quick.json --dataset test --out ${WORK}/test.h5)
run(${program} reconstruct --solver lean-net-8 --input ${WORK}/test.h5 --output ${WORK}/images.h5)
# Each part is found; a command of every part says what it does.
foreach(command limit live check)
  run(${program} ${command} --help)
endforeach()
run(${program} list)
if(output MATCHES "not available")
  message(FATAL_ERROR "the installed program does not find the learned solvers:\n${output}")
endif()

file(GLOB package ${WORK}/python3-ertbench_*.deb)
if(NOT package)
  return()
endif()
run(dpkg-deb --field ${package})
foreach(needed "Section: python" "Depends: [^\n]*ertbench [(]= " "python3-numpy" "python3 [(]<< 3[.]" "libc6")
  if(NOT output MATCHES ${needed})
    message(FATAL_ERROR "the Python package says nothing of \"${needed}\":\n${output}")
  endif()
endforeach()
if(lintian)
  run(${lintian} --allow-root --fail-on error ${package})
endif()
run(dpkg-deb -x ${package} ${WORK}/root)
# Its libraries are those of the program's package.
file(WRITE ${WORK}/use.py "
import re
import ertbench as eb
sensor = eb.Sensor('d2s')
frame = eb.ForwardModel(sensor).voltages(eb.Disc((20, -30), radius=15, ratio=0.4))
assert eb.Solver('one-step-gn', regularisation=0.1).fit(sensor).reconstruct(frame)[1] == 0
loaded = set(re.findall(r'/.*libertbench_.*', open('/proc/self/maps').read()))
assert loaded and all(one.startswith('${usr}/lib/') for one in loaded), loaded
assert eb.__file__.startswith('${usr}/lib/python3/dist-packages'), eb.__file__
")
run(${CMAKE_COMMAND} -E env --unset=LD_LIBRARY_PATH PYTHONPATH=${usr}/lib/python3/dist-packages
  PYTHONDONTWRITEBYTECODE=1 HOME=${WORK}/home /usr/bin/python3 ${WORK}/use.py)
