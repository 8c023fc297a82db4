# Builds programs by the compiler alone, with the flags that pkg-config gives, and runs them. A part of run.cmake.
# Sets detector_flags.

find_program(PKG_CONFIG NAMES pkg-config pkgconf REQUIRED)
file(GLOB_RECURSE pc_file "${WORK_DIR}/install/softcd.pc")
cmake_path(GET pc_file PARENT_PATH pc_dir)
cmake_path(GET pc_dir PARENT_PATH library_dir)
set(ENV{PKG_CONFIG_PATH} "${pc_dir}:$ENV{PKG_CONFIG_PATH}")
set(is_shared OFF)
if(EXISTS "${library_dir}/libsoftcd.so")
  set(is_shared ON)
endif()

function(pkg_config out)
  execute_process(COMMAND "${PKG_CONFIG}" ${ARGN} OUTPUT_VARIABLE output COMMAND_ERROR_IS_FATAL ANY
                  OUTPUT_STRIP_TRAILING_WHITESPACE)
  separate_arguments(output UNIX_COMMAND "${output}")
  set(${out} ${output} PARENT_SCOPE)
endfunction()

# The compiler's arguments for `sources` with the package `name`.
function(consumer_flags out name)
  if(is_shared)
    pkg_config(flags --cflags --libs ${name})
    list(APPEND flags "-Wl,-rpath,${library_dir}")
  else()
    pkg_config(flags --static --cflags --libs ${name})
  endif()
  set(${out} -std=c++17 -fvisibility=hidden ${flags} PARENT_SCOPE)
endfunction()

consumer_flags(detector_flags softcd)
pkg_config(version --modversion softcd)
run("${CXX}" "${CMAKE_CURRENT_LIST_DIR}/detector.cpp" -o "${WORK_DIR}/detector" ${detector_flags})
run("${WORK_DIR}/detector" "${version}")
foreach(name IN ITEMS softcd-bullet softcd-bullet-float64)
  if(EXISTS "${pc_dir}/${name}.pc")
    consumer_flags(flags ${name})
    run("${CXX}" "${CMAKE_CURRENT_LIST_DIR}/one_line_app.cpp" -o "${WORK_DIR}/${name}" ${flags})
    run("${WORK_DIR}/${name}")
  endif()
endforeach()
