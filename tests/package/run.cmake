# Installs a build of softcd into a fresh folder and builds and runs consumers against it: a CMake project, and programs
# compiled with what pkg-config says. Checks that the libraries show what they should, and that mixing versions, or
# Bullet's precisions where both are there, fails with a sentence that says why.
#
#   cmake -D BUILD_DIR=... -D WORK_DIR=... -D GENERATOR=... -D CXX=... -D NM=... -D CTEST=... -D ARGUMENTS=...
#         -P run.cmake

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Fails unless the command fails and its output, line breaks taken for spaces, holds every one of `sentences`.
function(run_to_fail sentences)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(result EQUAL 0)
    message(FATAL_ERROR "should have failed: ${ARGN}\n${output}")
  endif()
  string(REGEX REPLACE "[ \n]+" " " text "${output}")
  foreach(sentence IN LISTS sentences)
    string(FIND "${text}" "${sentence}" position)
    if(position EQUAL -1)
      message(FATAL_ERROR "failed without saying '${sentence}': ${ARGN}\n${output}")
    endif()
  endforeach()
endfunction()

set(settings -G "${GENERATOR}" "-DCMAKE_CXX_COMPILER=${CXX}" "-DCMAKE_PREFIX_PATH=${WORK_DIR}/install"
             -DCMAKE_BUILD_TYPE=Release ${ARGUMENTS})

file(REMOVE_RECURSE "${WORK_DIR}")
run("${CMAKE_COMMAND}" --install "${BUILD_DIR}" --prefix "${WORK_DIR}/install")
run("${CMAKE_COMMAND}" -S "${CMAKE_CURRENT_LIST_DIR}" -B "${WORK_DIR}/build" ${settings})
run("${CMAKE_COMMAND}" --build "${WORK_DIR}/build")
run("${CTEST}" --test-dir "${WORK_DIR}/build" --output-on-failure --no-tests=error)

include("${CMAKE_CURRENT_LIST_DIR}/pkg_config.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/versions.cmake")

file(GLOB_RECURSE float_library "${WORK_DIR}/install/*softcd_bullet.*")
file(GLOB_RECURSE double_library "${WORK_DIR}/install/*softcd_bullet-float64.*")
if(NOT float_library OR NOT double_library)
  return()
endif()

set(precision_project "${CMAKE_CURRENT_LIST_DIR}/precision")
set(precision_build "${WORK_DIR}/precision")
set(says_either "SOFTCD_LINK_EITHER_softcd::bullet_OR_softcd::bullet-float64 already determined for \"app_of_both\"")
run_to_fail("${says_either}" "${CMAKE_COMMAND}" -S "${precision_project}" -B "${precision_build}-both" -DBOTH=ON
            ${settings})

run("${CMAKE_COMMAND}" -S "${precision_project}" -B "${precision_build}" ${settings})
function(link_to_fail target sentence)
  run_to_fail("${sentence}" "${CMAKE_COMMAND}" --build "${precision_build}" --target ${target})
endfunction()
link_to_fail(double_app_with_float_library compiled_with_bt_use_double_precision_so_link_softcd_bullet_float64)
link_to_fail(float_app_with_double_library compiled_without_bt_use_double_precision_so_link_softcd_bullet)
if(float_library MATCHES "\\.a$")  # shared libraries may define the same name
  link_to_fail(double_app_with_float_part one_program_cannot_link_both_softcd_bullet_and_softcd_bullet_float64)
endif()
