# Incompatible versions do not link, and libraries show the names of theirs. A part of run.cmake.

file(GLOB_RECURSE version_header "${WORK_DIR}/install/version.hpp")
file(READ "${version_header}" version_text)
string(REGEX MATCH "#define SOFTCD_VERSION_NAMESPACE ([a-z0-9_]+)" definition "${version_text}")
set(version_namespace "${CMAKE_MATCH_1}")
string(REGEX REPLACE "^v([0-9]+)_" "\\1." abi_version "${version_namespace}")

# An application that was compiled with the headers of another version.
string(REPLACE "${definition}" "#define SOFTCD_VERSION_NAMESPACE another_version" other_text "${version_text}")
file(WRITE "${WORK_DIR}/another_version/softcd/version.hpp" "${other_text}")
run_to_fail("softcd::another_version::Query::detect(softcd::another_version::Pairs)" "${CXX}" "-I${WORK_DIR}/another_version"
            "${CMAKE_CURRENT_LIST_DIR}/detector.cpp" -o "${WORK_DIR}/mixed" ${detector_flags})

# A program that holds two static libraries: what is not public has the same names in both.
if(NOT is_shared)
  set(sentence one_program_cannot_link_two_versions_of_softcd)
  file(WRITE "${WORK_DIR}/another_version/library.cpp" "extern \"C\" void ${sentence}() {}\n")
  run_to_fail("${sentence}" "${CXX}" "${CMAKE_CURRENT_LIST_DIR}/detector.cpp"
              "${WORK_DIR}/another_version/library.cpp" -o "${WORK_DIR}/mixed" ${detector_flags})
endif()

# Fails unless the library defines `wanted`, and no name of softcd's without its version where it is shared.
function(check_symbols library wanted)
  set(which --defined-only --extern-only)
  if(is_shared)
    list(APPEND which --dynamic)
  endif()
  execute_process(COMMAND "${NM}" --demangle ${which} "${library}" OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  string(FIND "${symbols}" " T ${wanted}" position)
  if(position EQUAL -1)
    message(FATAL_ERROR "${library} does not define ${wanted}")
  endif()
  if(is_shared)
    string(REGEX MATCHALL "[^\n]*softcd[^\n]*" symbols "${symbols}")
    list(FILTER symbols EXCLUDE REGEX "softcd::(bullet::)?${version_namespace}::| softcd_[a-z0-9_]+@@SOFTCD_${abi_version}$")
    if(symbols)
      message(FATAL_ERROR "${library} shows names without their version: ${symbols}")
    endif()
  endif()
endfunction()

function(check_library name wanted)
  file(GLOB library "${library_dir}/lib${name}.a" "${library_dir}/lib${name}.so")
  if(library)
    check_symbols("${library}" "${wanted}")
  endif()
endfunction()

check_library(softcd "softcd::${version_namespace}::Query::detect(softcd::${version_namespace}::Pairs)")
check_library(softcd "softcd_query_detect")
check_library(softcd_bullet "softcd::bullet::${version_namespace}::give_face_tree(btSoftBody&)")
check_library(softcd_bullet-float64 "softcd::bullet::${version_namespace}::give_face_tree(btSoftBody&)")
