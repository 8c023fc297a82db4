# Install rules, so that find_package(softcd) gives softcd::softcd and softcd::bullet, and pkg-config the same.

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
          ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}"
          LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}"
          INCLUDES DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
  install(DIRECTORY "${include_dir}/softcd" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" FILES_MATCHING REGEX "\\.h(pp)?$")
endfunction()

softcd_install_library(softcd softcd "${PROJECT_SOURCE_DIR}/plugin/include")
# Of these only what the others include.
install(DIRECTORY "${PROJECT_SOURCE_DIR}/kernels/include/softcd" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}"
        FILES_MATCHING REGEX "${SOFTCD_PUBLIC_KERNEL_HEADERS}")
softcd_install_library(softcd_bullet bullet "${PROJECT_SOURCE_DIR}/bullet_integration/include")
softcd_install_library(softcd_bullet-float64 bullet-float64 "${PROJECT_SOURCE_DIR}/bullet_integration/include")

if(TARGET softcd)
  install(EXPORT softcd_targets NAMESPACE softcd:: DESTINATION "${softcd_package_dir}")
endif()
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/softcdConfig.cmake.in"
                              "${PROJECT_BINARY_DIR}/softcdConfig.cmake" INSTALL_DESTINATION "${softcd_package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/softcdConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/softcdConfig.cmake" "${PROJECT_BINARY_DIR}/softcdConfigVersion.cmake"
              "${PROJECT_SOURCE_DIR}/cmake/FindBulletSoftBody.cmake"
        DESTINATION "${softcd_package_dir}")
include(SoftcdPkgConfig)
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")
