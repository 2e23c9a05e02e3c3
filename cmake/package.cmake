# Installing, and the CMake package with which a solver of one's own is built outside this tree:
#
#     find_package(ertbench REQUIRED)
#     add_library(my_solver MODULE my_solver.cpp)
#     target_link_libraries(my_solver PRIVATE ertbench::solvers)
#
# and the library that runs fitted solvers in a program of one's own, which needs nothing else:
#
#     find_package(ertbench REQUIRED COMPONENTS runtime)
#     target_link_libraries(robot PRIVATE ertbench::runtime)
include(CMakePackageConfigHelpers)
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME program)

set(libraries ertbench_abi ertbench_core ertbench_forward ertbench_solvers)
foreach(name core forward runtime solvers)
  set_target_properties(ertbench_${name} PROPERTIES EXPORT_NAME ${name})
  add_library(ertbench::${name} ALIAS ertbench_${name})
endforeach()
install(TARGETS ${libraries} EXPORT ertbench_targets)
install(TARGETS ertbench_runtime EXPORT ertbench_runtime_targets)
install(FILES runtime/runtime.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ertbench/runtime)
foreach(folder core forward solvers)
  install(DIRECTORY ${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ertbench
    FILES_MATCHING PATTERN "*.h")
endforeach()

# Libraries are looked for beside each other in the built tree and in the installed one alike. Where
# CMake changes the path at the installation it pads it with an empty entry, which stands for the
# working folder, where nothing must be looked for.
file(RELATIVE_PATH from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
set(built_tree "$ORIGIN/../bench;$ORIGIN/../solvers;$ORIGIN/../forward;$ORIGIN/../core")
set(programs ertbench ertbench_core ertbench_forward ertbench_solvers ertbench_bench)
set_target_properties(${programs} PROPERTIES BUILD_WITH_INSTALL_RPATH ON
  INSTALL_RPATH "$ORIGIN;${built_tree}")
set_target_properties(ertbench PROPERTIES INSTALL_RPATH "$ORIGIN/${from_bin};$ORIGIN;${built_tree}")
install(TARGETS ertbench ertbench_bench)
# The learned solvers and the parts, which the program loads (solvers/registry, bench/features).
set(loaded ertbench_ladders ertbench_limit ertbench_live ertbench_studies ertbench_tools)
if(TARGET ertbench_models)
  list(APPEND loaded ertbench_models)
endif()
set_target_properties(${loaded} PROPERTIES BUILD_WITH_INSTALL_RPATH ON
  INSTALL_RPATH "$ORIGIN/..;$ORIGIN;${built_tree}")
install(TARGETS ${loaded} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/ertbench)

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/ertbench)
install(EXPORT ertbench_targets NAMESPACE ertbench:: DESTINATION ${package}
  FILE ertbench-targets.cmake)
install(EXPORT ertbench_runtime_targets NAMESPACE ertbench:: DESTINATION ${package}
  FILE ertbench-runtime-targets.cmake)
configure_package_config_file(cmake/ertbench-config.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/ertbench-config.cmake INSTALL_DESTINATION ${package})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/ertbench-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/ertbench-config.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/ertbench-config-version.cmake DESTINATION ${package})
install(FILES CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR})
# Files that the installed program looks for (project_folder).
install(DIRECTORY sensors experiments DESTINATION ${CMAKE_INSTALL_DATADIR}/ertbench)
install(DIRECTORY results/networks DESTINATION ${CMAKE_INSTALL_DATADIR}/ertbench/results
  PATTERN make EXCLUDE)

# The Debian packages, by `cpack -G DEB` in a build folder: ertbench and, where it was built,
# python3-ertbench. Those of the preset `package` run on any x86-64 processor with AVX2, those of `release`
# on processors like the one that they were built on.
set(debian ${CMAKE_CURRENT_BINARY_DIR}/debian)
set(maintainer "The ertbench authors <ertbench@users.noreply.github.com>")
if(DEFINED ENV{DEBEMAIL})  # whoever packs it
  set(maintainer "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
endif()
file(WRITE ${debian}/changelog "ertbench (${PROJECT_VERSION}) unstable; urgency=medium

  * Release ${PROJECT_VERSION}; CHANGELOG.md of the sources tells what is new.

 -- ${maintainer}  Sat, 21 Nov 2026 12:00:00 +0000
")
execute_process(COMMAND gzip -9nf ${debian}/changelog)
file(WRITE ${debian}/triggers "activate-noawait ldconfig\n")
file(READ LICENSE license)
string(REGEX REPLACE "\n" "\n " license "${license}")
string(REPLACE "\n \n" "\n .\n" license "${license}")
file(WRITE ${debian}/copyright
  "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: ertbench

Files: *
Copyright: 2026, the ertbench authors
License: BSD-3-Clause
 ${license}")
install(FILES ${debian}/copyright ${debian}/changelog.gz DESTINATION ${CMAKE_INSTALL_DOCDIR})
set(CPACK_COMPONENTS_ALL program)
if(TARGET ertbench_core_module)
  list(APPEND CPACK_COMPONENTS_ALL python)
  math(EXPR next_minor "${python_minor} + 1")
  set(modules lib/python3/dist-packages/ertbench)
  file(RELATIVE_PATH from_modules ${CMAKE_INSTALL_PREFIX}/${modules} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_property(TARGET ertbench_core_module APPEND PROPERTY INSTALL_RPATH "$ORIGIN/${from_modules}")
  install(TARGETS ertbench_core_module LIBRARY DESTINATION ${modules} COMPONENT python)
  install(DIRECTORY python/ertbench/ DESTINATION ${modules} COMPONENT python
    PATTERN __pycache__ EXCLUDE)
  install(DIRECTORY sensors DESTINATION ${modules} COMPONENT python)
  install(FILES ${debian}/copyright ${debian}/changelog.gz COMPONENT python
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-ertbench)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME ertbench)
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-ertbench)
set(CPACK_PACKAGE_NAME ertbench)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "${maintainer}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "electrical resistance tomography of robot skins, for NumPy
The C++ library of ertbench as a Python package: the forward model, scenes, solvers,
frames of one's own and scores.")
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "reconstruction methods of tomographic tactile skins, compared
Datasets, reconstruction methods, accuracy and latency of electrical resistance
tomography for robotic skins, driven by JSON experiments. The package has the
program, its libraries and headers, sensors, experiments and fitted networks.")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_CONTROL_EXTRA ${debian}/triggers)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR}/core ${CMAKE_BINARY_DIR}/forward
  ${CMAKE_BINARY_DIR}/solvers ${CMAKE_BINARY_DIR}/bench)
# Programs and libraries that are looked for at run time. Without OpenBLAS libtorch is ten times slower.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "gnuplot-nox, fonts-dejavu-core, libopenblas0-openmp")
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "ertbench (= ${PROJECT_VERSION}), python3-numpy, \
python3 (>= 3.${python_minor}), python3 (<< 3.${next_minor})")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-matplotlib, python3-torch, python3-scipy")
include(CPack)
