# Installing, and the CMake package with which a solver of one's own is built outside this tree:
#
#     find_package(ertbench REQUIRED)
#     add_library(my_solver MODULE my_solver.cpp)
#     target_link_libraries(my_solver PRIVATE ertbench::solvers)
include(CMakePackageConfigHelpers)

set(libraries ertbench_abi ertbench_core ertbench_forward ertbench_solvers)
foreach(name core forward solvers)
  set_target_properties(ertbench_${name} PROPERTIES EXPORT_NAME ${name})
  add_library(ertbench::${name} ALIAS ertbench_${name})
endforeach()
install(TARGETS ${libraries} EXPORT ertbench_targets)
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
set(loaded ertbench_limit ertbench_live ertbench_studies ertbench_tools)
if(TARGET ertbench_models)
  list(APPEND loaded ertbench_models)
endif()
set_target_properties(${loaded} PROPERTIES BUILD_WITH_INSTALL_RPATH ON
  INSTALL_RPATH "$ORIGIN/..;$ORIGIN;${built_tree}")
install(TARGETS ${loaded} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/ertbench)

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/ertbench)
install(EXPORT ertbench_targets NAMESPACE ertbench:: DESTINATION ${package}
  FILE ertbench-targets.cmake)
configure_package_config_file(cmake/ertbench-config.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/ertbench-config.cmake INSTALL_DESTINATION ${package})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/ertbench-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/ertbench-config.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/ertbench-config-version.cmake DESTINATION ${package})
install(FILES LICENSE CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR})
