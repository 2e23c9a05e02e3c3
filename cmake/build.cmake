# Writes build.cpp anew where the sources or their commit have changed; run at every build.
# Takes ERTBENCH_FOLDER, OUTPUT and FLAGS, the compiler and its flags.

# What the program is made of. A commit that changes nothing here, of results or pages say, leaves
# the program as it is.
set(sources core forward solvers models bench cmake CMakeLists.txt CMakePresets.json)

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

# Parts of core/ that no number depends on: they keep files, run processes and write text.
set(no_numbers atomic_file build build_stamp checksum csv_field file_lock hdf5_checksum hdf5_guard
  hdf5_handle html json_checksum nearest_word process process_tree progress regular_file replace_file supervisor
  temporary_folder text text_stream)
# Those that only what is said of scores depends on.
set(of_scores bootstrap interval median_interval paired_bootstrap student_t wilson_interval)

# hash_sources(VARIABLE WHAT...): over the contents of the sources in folders or files.
function(hash_sources variable)
  set(all "${FLAGS}")
  foreach(what ${ARGN})
    if(IS_DIRECTORY ${ERTBENCH_FOLDER}/${what})
      file(GLOB_RECURSE files RELATIVE ${ERTBENCH_FOLDER}
        ${ERTBENCH_FOLDER}/${what}/*.h ${ERTBENCH_FOLDER}/${what}/*.cpp)
    else()
      set(files ${what})
    endif()
    list(FILTER files EXCLUDE REGEX "/benchmarks/")
    foreach(name ${no_numbers} ${left_out})
      list(REMOVE_ITEM files core/${name}.h core/${name}.cpp)
    endforeach()
    list(SORT files)
    foreach(file ${files})
      file(SHA256 ${ERTBENCH_FOLDER}/${file} hash)
      string(APPEND all " ${file} ${hash}")
    endforeach()
  endforeach()
  string(SHA256 hash "${all}")
  string(SUBSTRING ${hash} 0 32 hash)
  set(${variable} ${hash} PARENT_SCOPE)
endfunction()

set(data core forward/sheet forward/fem forward/border forward/touch forward/data)
set(record core forward solvers models bench/contacts bench/experiment bench/record bench/run bench/score)
set(left_out ${of_scores})
hash_sources(ERTBENCH_DATA_CODE ${data})

file(GLOB of_all_solvers RELATIVE ${ERTBENCH_FOLDER}
  ${ERTBENCH_FOLDER}/solvers/*.h ${ERTBENCH_FOLDER}/solvers/*.cpp)
list(APPEND of_all_solvers solvers/check bench/experiment/fit_recipe.cpp
  bench/run/fitted_solver.cpp)
file(STRINGS ${ERTBENCH_FOLDER}/cmake/same_fits.txt same_fits REGEX "^[^#]")
# One line of C++ for each room of solvers: {"solvers/linear", "solvers/linear <hash>"},
set(ERTBENCH_FIT_CODES "")
file(STRINGS ${ERTBENCH_FOLDER}/cmake/fit_rooms.txt lines REGEX "^[^#].*:")
foreach(line ${lines})
  string(REGEX MATCHALL "[a-z_/]+" rooms "${line}")
  list(GET rooms 0 room)
  list(REMOVE_ITEM rooms solvers)  # its own files are among those of all
  hash_sources(code ${data} ${of_all_solvers} ${rooms})
  string(REGEX MATCH "(^|;)${room} ${code} ([0-9a-f]+)(;|$)" same "${same_fits}")
  if(same)
    set(code ${CMAKE_MATCH_2})
  endif()
  string(APPEND ERTBENCH_FIT_CODES "{\"${room}\", \"${room} ${code}\"}, ")
endforeach()

# Of limits: what samples posteriors and scores estimates, not what tells of them.
file(GLOB limit RELATIVE ${ERTBENCH_FOLDER}
  ${ERTBENCH_FOLDER}/bench/limit/*.h ${ERTBENCH_FOLDER}/bench/limit/*.cpp)
list(FILTER limit EXCLUDE REGEX "/(bound_map|limit_json|rank_figure)[.]")
hash_sources(ERTBENCH_LIMIT_CODE core forward bench/contacts bench/score ${limit})

set(left_out)
hash_sources(ERTBENCH_RECORD_CODE ${record})
configure_file(${ERTBENCH_FOLDER}/core/build.cpp.in ${OUTPUT} @ONLY)
