# Debian packages by `cpack` (packaging/debian.sh): shared libraries, what compiling against them needs, and the programs.

if(NOT PROJECT_IS_TOP_LEVEL)
  return()
endif()

set(softcd_runtime_package "libsoftcd${SOFTCD_ABI_VERSION}")  # incompatible versions can be installed side by side
set(softcd_development_package libsoftcd-dev)
set(softcd_tools_package softcd-tools)

# Licences where Debian looks for them: softcd's, and those of what is compiled into a package.
function(softcd_package_licences component)
  set(folder "${CMAKE_INSTALL_DATAROOTDIR}/doc/${softcd_${component}_package}")
  install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${folder}" RENAME copyright COMPONENT ${component}
          EXCLUDE_FROM_ALL)
  foreach(package IN LISTS ARGN)
    if(EXISTS "/usr/share/doc/${package}/copyright")
      install(FILES "/usr/share/doc/${package}/copyright" DESTINATION "${folder}" RENAME "copyright.${package}"
              COMPONENT ${component} EXCLUDE_FROM_ALL)
    endif()
  endforeach()
endfunction()
softcd_package_licences(runtime libhwy-dev)
softcd_package_licences(development)
softcd_package_licences(tools libcli11-dev nlohmann-json3-dev libimgui-dev libboost-dev libeigen3-dev)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "the softcd authors")
set(CPACK_PACKAGE_VENDOR "the softcd authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL runtime development tools)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_COMPONENT_DEVELOPMENT_DEPENDS runtime)
set(CPACK_COMPONENT_TOOLS_DEPENDS runtime)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
    "Contacts between deformable triangle meshes, discrete and continuous, alone or\nin worlds of Bullet's soft bodies: the shared libraries.")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
    "Contacts between deformable triangle meshes: headers, and what CMake and\npkg-config find the libraries by.")
set(CPACK_COMPONENT_TOOLS_DESCRIPTION
    "Contacts between deformable triangle meshes: softcd-detect for two frames of a\nmesh, softcd-certify for proofs that frames do not cross, and softcd-demo, scenes\nof Bullet's soft bodies.")

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${PROJECT_BINARY_DIR}/plugin"
                                                "${PROJECT_BINARY_DIR}/bullet_integration")
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME ${softcd_runtime_package})
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME ${softcd_development_package})
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS libbullet-dev)
set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME ${softcd_tools_package})
set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION math)
# OpenGL draws pictures and is loaded at run time.
set(CPACK_DEBIAN_TOOLS_PACKAGE_DEPENDS "libopengl0, libgl1-mesa-dri")
include(CPack)
