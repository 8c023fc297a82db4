# The options of the build. Extras are on only when softcd is the project that is being built.

set(SOFTCD_CUDA AUTO CACHE STRING
    "CUDA backend: AUTO builds it where a CUDA compiler (12 or newer) is found, ON requires one, OFF leaves it out")
set_property(CACHE SOFTCD_CUDA PROPERTY STRINGS AUTO ON OFF)
option(SOFTCD_THREADS "Run loops on several threads, with oneTBB" ON)
option(SOFTCD_BULLET "Build softcd::bullet, the integration with Bullet's soft bodies" ${PROJECT_IS_TOP_LEVEL})
option(SOFTCD_BULLET_FLOAT64 "Build softcd::bullet-float64 too, where Bullet's double-precision libraries are" ON)
set(SOFTCD_PYBULLET_SOURCE "" CACHE PATH
    "Sources of the PyBullet that a plugin for it is built for (docs/use/pybullet.md); empty builds none")
option(SOFTCD_DEMOS "Build the programs softcd-detect, softcd-certify and softcd-demo" ${PROJECT_IS_TOP_LEVEL})
option(SOFTCD_TESTS "Build the tests" ${PROJECT_IS_TOP_LEVEL})
option(SOFTCD_BENCHMARKS "Build the benchmarks" ${PROJECT_IS_TOP_LEVEL})
option(SOFTCD_QUICK_PROGRAMS "Compile programs, but not the scenes, without optimization: only what they do is looked at" OFF)
option(SOFTCD_INSTALL "Generate the install rules" ${PROJECT_IS_TOP_LEVEL})
set(softcd_data_dir "${PROJECT_SOURCE_DIR}/../shared/data")
if(NOT EXISTS "${softcd_data_dir}")
  set(softcd_data_dir "${PROJECT_SOURCE_DIR}/build/data")
endif()
set(SOFTCD_DATA_DIR "${softcd_data_dir}" CACHE PATH
    "Recorded steps and queries (tests/fetch_data.sh); tests that need them are skipped where the folder is absent")

if(PROJECT_IS_TOP_LEVEL)
  option(BUILD_SHARED_LIBS "Build softcd::softcd and softcd::bullet as shared libraries" OFF)
  set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
  if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
    set(CMAKE_BUILD_TYPE Release CACHE STRING "Debug, Release, RelWithDebInfo or MinSizeRel" FORCE)
  endif()
endif()
if(WIN32 AND BUILD_SHARED_LIBS AND SOFTCD_BULLET)
  message(FATAL_ERROR "On Windows, Bullet exports nothing from shared libraries, and so does softcd::bullet. Set "
                      "SOFTCD_BULLET=OFF or BUILD_SHARED_LIBS=OFF.")
endif()
if(BUILD_SHARED_LIBS AND SOFTCD_BENCHMARKS)
  message(STATUS "softcd: no benchmarks, which look inside the library, with BUILD_SHARED_LIBS")
  set(SOFTCD_BENCHMARKS OFF)
endif()
