# What both wheels have in common. Adds softcd's own build, and has functions for a wheel's files.

set(SOFTCD_WHEEL_LIBRARIES "" CACHE PATH "What packaging/wheel_libraries.sh has built: the module holds these, and libstdc++")
list(PREPEND CMAKE_PREFIX_PATH ${SOFTCD_WHEEL_LIBRARIES})
find_package(Threads REQUIRED)  # a static oneTBB's
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(hwy REQUIRED)
find_package(Boost REQUIRED)

set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(softcd_dir "${CMAKE_CURRENT_LIST_DIR}/..")
set(CMAKE_UNITY_BUILD ON)  # a wheel is built from nothing
add_subdirectory("${softcd_dir}" softcd EXCLUDE_FROM_ALL)
unset(CMAKE_UNITY_BUILD)

# Installs a module, and the shared libraries that it needs beside it: a wheel has all it needs.
function(softcd_wheel_module target)
  if(SOFTCD_WHEEL_LIBRARIES AND UNIX AND NOT APPLE)
    # Functions that nothing calls may need a newer glibc.
    target_link_options(${target} PRIVATE -static-libstdc++ LINKER:--gc-sections)
  endif()
  install(TARGETS ${target} LIBRARY DESTINATION . COMPONENT python)
  foreach(library IN ITEMS TBB::tbb fmt::fmt hwy::hwy)
    get_target_property(type ${library} TYPE)
    if(type STREQUAL "SHARED_LIBRARY")
      install(FILES "$<TARGET_FILE:${library}>" DESTINATION . COMPONENT python
              RENAME "$<TARGET_SONAME_FILE_NAME:${library}>")
    endif()
  endforeach()
endfunction()

# Licences of all that is in a wheel, with its metadata, where softcd's own is. Arguments: headers that are compiled in.
set(licence_dir "${SKBUILD_METADATA_DIR}/licenses")
function(softcd_install_licences)
  # The CUDA runtime and templates of CCCL's are compiled in.
  get_directory_property(has_cuda DIRECTORY "${softcd_dir}" DEFINITION SOFTCD_HAS_CUDA)
  if(has_cuda)
    get_directory_property(toolkit DIRECTORY "${softcd_dir}" DEFINITION CUDAToolkit_LIBRARY_ROOT)
    file(REAL_PATH "${toolkit}" toolkit)
    file(GLOB cuda_licences "${toolkit}/EULA.txt" "${toolkit}/dist-info/nvidia_cuda_runtime-*/licenses/License.txt"
         "${toolkit}/../../nvidia_cuda_runtime-*/licenses/License.txt")
    if(NOT cuda_licences)
      message(WARNING "${toolkit} has no text of CUDA's licence. Add it before you pass the wheel on.")
    endif()
    install(FILES ${cuda_licences} DESTINATION "${licence_dir}/cuda" COMPONENT python)
  endif()
  if(SOFTCD_WHEEL_LIBRARIES)
    install(DIRECTORY "${SOFTCD_WHEEL_LIBRARIES}/share/doc/" DESTINATION "${licence_dir}" COMPONENT python)
    return()
  endif()
  set(compiled_in "$<TARGET_FILE:TBB::tbb>" "$<TARGET_FILE:fmt::fmt>" "$<TARGET_FILE:hwy::hwy>")
  foreach(header IN LISTS ARGN)
    find_file(header_file ${header} NO_CACHE)
    list(APPEND compiled_in "${header_file}")
    unset(header_file)
  endforeach()
  foreach(file IN LISTS compiled_in)
    install(CODE "set(LIBRARY \"${file}\")\nset(FOLDER \"${licence_dir}\")" COMPONENT python)
    install(SCRIPT "${softcd_dir}/python/licences.cmake" COMPONENT python)
  endforeach()
endfunction()
