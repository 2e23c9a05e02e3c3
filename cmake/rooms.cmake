# How the rooms of a library are compiled.

# A room is one translation unit with ERTBENCH_UNITY: its files then share the reading of headers and
# the instances of templates, which are nine tenths of compiling them one by one. Without it, for work
# on single files, the headers that nearly every file reads are precompiled.
# Rooms that are named behind the target are one unit together.
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
    get_filename_component(source ${source} ABSOLUTE)
    get_filename_component(folder ${source} DIRECTORY)
    get_filename_component(room ${folder} NAME)
    if(room IN_LIST ARGN)
      set(room shared)
    endif()
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${room})
  endforeach()
endfunction()

# For rooms that no time and no number depends on: -O1 in a release build.
function(ertbench_lightly_optimised target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>
    # A false alarm of GCC 12's in its own AVX-512 headers, at this level.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-uninitialized>)
endfunction()
