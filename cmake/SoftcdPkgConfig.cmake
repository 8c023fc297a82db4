# Files for pkg-config with the results of find_package(softcd): softcd.pc, softcd-bullet.pc and
# softcd-bullet-float64.pc. Further libraries that static ones need are private there, so that `pkg-config --static`
# names them.

set(softcd_pc_dir "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
# They find what lies beside them, wherever they are installed.
set(softcd_pc_prefix "${CMAKE_INSTALL_PREFIX}")
if(NOT IS_ABSOLUTE "${softcd_pc_dir}")
  file(RELATIVE_PATH softcd_pc_way_up "/${softcd_pc_dir}" "/")
  set(softcd_pc_prefix "\${pcfiledir}/${softcd_pc_way_up}")
  string(REGEX REPLACE "/$" "" softcd_pc_prefix "${softcd_pc_prefix}")
endif()
set(softcd_pc_includedir "\${prefix}")
cmake_path(APPEND softcd_pc_includedir "${CMAKE_INSTALL_INCLUDEDIR}")
set(softcd_pc_libdir "\${prefix}")
cmake_path(APPEND softcd_pc_libdir "${CMAKE_INSTALL_LIBDIR}")

set(softcd_pc_requires "")
set(softcd_pc_bullet_requires "")
set(softcd_pc_libs "")
if(NOT softcd_is_shared)
  set(softcd_pc_requires "fmt, libhwy")
  if(SOFTCD_THREADS)
    string(APPEND softcd_pc_requires ", tbb")
    set(softcd_pc_bullet_requires "tbb")
  endif()
  set(softcd_pc_libs "-pthread -lstdc++ -lm")  # C programs ask for neither of the last two
  if(SOFTCD_HAS_CUDA)
    string(PREPEND softcd_pc_libs "${CUDA_cudart_static_LIBRARY} -ldl -lrt ")
  endif()
endif()

set(softcd_pc_cflags "")
if(MINGW AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(softcd_pc_cflags " -fno-ipa-ra")  # see SOFTCD_MINGW_OPTIONS
endif()

configure_file("${PROJECT_SOURCE_DIR}/cmake/softcd.pc.in" "${PROJECT_BINARY_DIR}/softcd.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/softcd.pc" DESTINATION "${softcd_pc_dir}" COMPONENT development)

# Flags and libraries of Bullet's are those of its imported target.
function(softcd_install_bullet_pc target name bullet scalar)
  if(NOT TARGET ${target})
    return()
  endif()
  get_target_property(include_dir ${bullet} INTERFACE_INCLUDE_DIRECTORIES)
  get_target_property(definitions ${bullet} INTERFACE_COMPILE_DEFINITIONS)
  get_target_property(libraries ${bullet} INTERFACE_LINK_LIBRARIES)
  set(bullet_cflags "-I${include_dir}")
  if(definitions)
    list(TRANSFORM definitions PREPEND "-D")
    list(JOIN definitions " " definitions)
    string(APPEND bullet_cflags " ${definitions}")
  endif()
  list(JOIN libraries " " bullet_libs)
  configure_file("${PROJECT_SOURCE_DIR}/cmake/softcd-bullet.pc.in" "${PROJECT_BINARY_DIR}/${name}.pc" @ONLY)
  install(FILES "${PROJECT_BINARY_DIR}/${name}.pc" DESTINATION "${softcd_pc_dir}" COMPONENT development)
endfunction()

softcd_install_bullet_pc(softcd_bullet softcd-bullet softcd_bullet_float float)
softcd_install_bullet_pc(softcd_bullet-float64 softcd-bullet-float64 softcd_bullet_float64 double)
