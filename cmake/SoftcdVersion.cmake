# Reads softcd's version from the header that has it, into SOFTCD_VERSION, and that of its binary interface, which
# compatible versions share, into SOFTCD_ABI_VERSION. Refuses a header that contradicts itself.

set(softcd_version_header "${CMAKE_CURRENT_LIST_DIR}/../kernels/include/softcd/version.hpp")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${softcd_version_header}")
file(READ "${softcd_version_header}" softcd_version_text)
foreach(part IN ITEMS MAJOR MINOR PATCH STRING NAMESPACE)
  if(NOT softcd_version_text MATCHES "#define SOFTCD_VERSION_${part} \"?([^\n\"]+)")
    message(FATAL_ERROR "${softcd_version_header} does not define SOFTCD_VERSION_${part}.")
  endif()
  set(softcd_version_${part} "${CMAKE_MATCH_1}")
endforeach()

set(SOFTCD_VERSION "${softcd_version_MAJOR}.${softcd_version_MINOR}.${softcd_version_PATCH}")
set(SOFTCD_ABI_VERSION "${softcd_version_MAJOR}")
if(softcd_version_MAJOR EQUAL 0)
  set(SOFTCD_ABI_VERSION "0.${softcd_version_MINOR}")
endif()
string(REPLACE "." "_" softcd_version_namespace "v${SOFTCD_ABI_VERSION}")
if(NOT softcd_version_STRING STREQUAL SOFTCD_VERSION OR NOT softcd_version_NAMESPACE STREQUAL softcd_version_namespace)
  message(FATAL_ERROR "${softcd_version_header}: SOFTCD_VERSION_STRING must be \"${SOFTCD_VERSION}\" and "
                      "SOFTCD_VERSION_NAMESPACE ${softcd_version_namespace}, as the numbers say.")
endif()
