# Install rules, so that find_package(softcd) gives softcd::softcd and softcd::bullet, and pkg-config the same. In three
# components, as packages have them: runtime, development and tools.

if(NOT SOFTCD_INSTALL)
  return()
endif()

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(softcd_package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/softcd")
set(softcd_is_shared OFF)
if(BUILD_SHARED_LIBS)
  set(softcd_is_shared ON)
endif()

function(softcd_install_library target export_name include_dir)
  if(NOT TARGET ${target})
    return()
  endif()
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${export_name})
  install(TARGETS ${target} EXPORT softcd_targets
          ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT development
          LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT runtime NAMELINK_COMPONENT development
          RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT runtime
          INCLUDES DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
  install(DIRECTORY "${include_dir}/softcd" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT development
          FILES_MATCHING REGEX "\\.h(pp)?$")
endfunction()

softcd_install_library(softcd softcd "${PROJECT_SOURCE_DIR}/plugin/include")
# Installs only the kernels' headers that public headers include.
set(softcd_kernel_include_dir "${PROJECT_SOURCE_DIR}/kernels/include")
file(GLOB_RECURSE softcd_kernel_headers RELATIVE "${softcd_kernel_include_dir}" "${softcd_kernel_include_dir}/*.hpp")
list(FILTER softcd_kernel_headers INCLUDE REGEX "${SOFTCD_PUBLIC_KERNEL_HEADERS}")
foreach(header IN LISTS softcd_kernel_headers)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES "${softcd_kernel_include_dir}/${header}" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/${folder}"
          COMPONENT development)
endforeach()
softcd_install_library(softcd_bullet bullet "${PROJECT_SOURCE_DIR}/bullet_integration/include")
softcd_install_library(softcd_bullet-float64 bullet-float64 "${PROJECT_SOURCE_DIR}/bullet_integration/include")

if(TARGET softcd)
  install(EXPORT softcd_targets NAMESPACE softcd:: DESTINATION "${softcd_package_dir}" COMPONENT development)
endif()
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/softcdConfig.cmake.in"
                              "${PROJECT_BINARY_DIR}/softcdConfig.cmake" INSTALL_DESTINATION "${softcd_package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/softcdConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/softcdConfig.cmake" "${PROJECT_BINARY_DIR}/softcdConfigVersion.cmake"
              "${PROJECT_SOURCE_DIR}/cmake/FindBulletSoftBody.cmake"
        DESTINATION "${softcd_package_dir}" COMPONENT development)
include(SoftcdPkgConfig)
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")
include(SoftcdPackages)
