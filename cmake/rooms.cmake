# How the rooms of a library are compiled.

# ertbench_rooms(TARGET ROOM+ROOM...): with ERTBENCH_UNITY a library is one translation unit, but for
# the rooms that are joined by "+" behind the target, each such group a unit of its own. Files of a unit
# share the reading of headers and the instances of templates, which are nine tenths of compiling them
# one by one. Without it, for work on single files, the headers that nearly every file reads are
# precompiled.
function(ertbench_rooms target)
  if(NOT ERTBENCH_UNITY)
    target_precompile_headers(${target} PRIVATE
      <Eigen/Dense> <nlohmann/json.hpp>
      <algorithm> <array> <cmath> <cstdint> <cstdio> <filesystem> <fstream> <functional> <map>
      <memory> <optional> <set> <span> <sstream> <stdexcept> <string> <string_view> <utility>
      <vector>)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  # Says of any type local to a file that it might be another in the next file.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  get_target_property(sources ${target} SOURCES)
  foreach(source ${sources})
    get_filename_component(path ${source} ABSOLUTE)
    get_filename_component(folder ${path} DIRECTORY)
    get_filename_component(room ${folder} NAME)
    set(unit all)
    foreach(rooms IN LISTS ARGN)
      string(REPLACE "+" ";" names ${rooms})
      if(room IN_LIST names)
        list(GET names 0 unit)
      endif()
    endforeach()
    set_source_files_properties(${path} PROPERTIES UNITY_GROUP ${unit})
  endforeach()
endfunction()

# For rooms that no time and no number depends on: -O1 in a release build.
function(ertbench_lightly_optimised target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>
    # A false alarm of GCC 12's in its own AVX-512 headers, at this level.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-uninitialized>)
endfunction()
