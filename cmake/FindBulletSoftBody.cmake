# Bullet with soft bodies, as imported targets:
#
#   softcd_bullet_float     btScalar is float
#   softcd_bullet_float64   btScalar is double (BT_USE_DOUBLE_PRECISION), where it is installed
#
# Bullet is looked for under BULLET_ROOT (CMake variable or environment) and CMAKE_PREFIX_PATH, then in the system's
# folders. Two layouts are known: Debian's, where the double libraries carry the suffix -float64, and Bullet's own
# `make install`, whose libraries have one precision and no suffix; which one, its BulletConfig.cmake says. That file's
# paths are relative to an unknown root in some packages, so nothing else is taken from it.

set(bullet_hints ${BULLET_ROOT} $ENV{BULLET_ROOT})

find_path(BulletSoftBody_INCLUDE_DIR NAMES BulletSoftBody/btSoftBody.h HINTS ${bullet_hints}
                                     PATH_SUFFIXES include/bullet bullet)

set(bullet_components BulletSoftBody BulletDynamics BulletCollision LinearMath)
foreach(component IN LISTS bullet_components)
  find_library(BulletSoftBody_${component}_LIBRARY NAMES ${component} HINTS ${bullet_hints} PATH_SUFFIXES lib)
  find_library(BulletSoftBody_${component}_float64_LIBRARY NAMES ${component}-float64 HINTS ${bullet_hints}
                                                                 PATH_SUFFIXES lib)
  mark_as_advanced(BulletSoftBody_${component}_LIBRARY BulletSoftBody_${component}_float64_LIBRARY)
endforeach()
mark_as_advanced(BulletSoftBody_INCLUDE_DIR)

# The precision of the libraries without a suffix.
set(bullet_plain_flavour float)
if(BulletSoftBody_LinearMath_LIBRARY)
  cmake_path(GET BulletSoftBody_LinearMath_LIBRARY PARENT_PATH bullet_library_dir)
  foreach(config IN ITEMS "${bullet_library_dir}/cmake/bullet/BulletConfig.cmake"
                          "${bullet_library_dir}/cmake/Bullet/BulletConfig.cmake")
    if(EXISTS "${config}")
      file(STRINGS "${config}" bullet_double_lines REGEX "BULLET_DEFINITIONS.*BT_USE_DOUBLE_PRECISION")
      if(bullet_double_lines)
        set(bullet_plain_flavour float64)
      endif()
    endif()
  endforeach()
endif()

if(BulletSoftBody_INCLUDE_DIR)
  set(bullet_version_header "${BulletSoftBody_INCLUDE_DIR}/LinearMath/btScalar.h")
  if(EXISTS "${bullet_version_header}")
    file(STRINGS "${bullet_version_header}" bullet_version_line REGEX "#define BT_BULLET_VERSION ")
    string(REGEX REPLACE ".*BT_BULLET_VERSION ([0-9])([0-9]+).*" "\\1.\\2" BulletSoftBody_VERSION
                         "${bullet_version_line}")
  endif()
endif()

# Defines softcd_bullet_<flavour> from the libraries found with `suffix` in their variables' names.
function(bullet_add_flavour flavour suffix)
  if(TARGET softcd_bullet_${flavour})
    return()
  endif()
  set(libraries "")
  foreach(component IN LISTS bullet_components)
    if(NOT BulletSoftBody_${component}${suffix}_LIBRARY)
      return()
    endif()
    list(APPEND libraries "${BulletSoftBody_${component}${suffix}_LIBRARY}")
  endforeach()
  add_library(softcd_bullet_${flavour} INTERFACE IMPORTED GLOBAL)
  target_include_directories(softcd_bullet_${flavour} SYSTEM INTERFACE "${BulletSoftBody_INCLUDE_DIR}")
  target_link_libraries(softcd_bullet_${flavour} INTERFACE ${libraries})
  if(flavour STREQUAL "float64")
    target_compile_definitions(softcd_bullet_${flavour} INTERFACE BT_USE_DOUBLE_PRECISION)
  endif()
endfunction()

if(BulletSoftBody_INCLUDE_DIR)
  bullet_add_flavour(${bullet_plain_flavour} "")
  bullet_add_flavour(float64 "_float64")
endif()
foreach(flavour IN ITEMS float float64)
  if(TARGET softcd_bullet_${flavour})
    set(BulletSoftBody_${flavour}_FOUND TRUE)
    list(APPEND bullet_flavours ${flavour})
  endif()
endforeach()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(
  BulletSoftBody
  REQUIRED_VARS BulletSoftBody_BulletSoftBody_LIBRARY BulletSoftBody_INCLUDE_DIR bullet_flavours
  VERSION_VAR BulletSoftBody_VERSION
  HANDLE_COMPONENTS
  REASON_FAILURE_MESSAGE "Install Bullet (Debian: libbullet-dev) or set BULLET_ROOT to where it is, e.g. /opt/bullet")
