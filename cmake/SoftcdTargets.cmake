# How every target of ours is compiled.

# Sanitizers reach every target, so that no part of a program is compiled without them.
set(SOFTCD_SANITIZE "" CACHE STRING "Sanitizers of the whole build, e.g. address,undefined or thread")
if(SOFTCD_SANITIZE)
  add_compile_options($<$<COMPILE_LANGUAGE:C,CXX>:-fsanitize=${SOFTCD_SANITIZE}>
                      $<$<COMPILE_LANGUAGE:C,CXX>:-fno-omit-frame-pointer>
                      $<$<COMPILE_LANGUAGE:C,CXX>:-fno-sanitize-recover=all>)
  add_link_options(-fsanitize=${SOFTCD_SANITIZE})
  # An index that is too large may stay within a vector's memory, where no sanitizer sees it.
  add_compile_definitions($<$<COMPILE_LANGUAGE:C,CXX>:_GLIBCXX_ASSERTIONS>)
endif()

# Only softcd/core/parallel.hpp knows the difference. Headers with parallel loops have to be compiled alike everywhere.
if(SOFTCD_THREADS)
  set(SOFTCD_TBB TBB::tbb)
else()
  set(SOFTCD_TBB "")
  add_compile_definitions(SOFTCD_SERIAL)
endif()

# Of the copies of an inline function, the linker keeps one. g++ for Windows takes that of the source it compiles for it,
# and expects registers that this copy leaves alone to survive a call.
set(SOFTCD_MINGW_OPTIONS $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-ipa-ra>)

# The standard, warnings, and contraction off on both sides (g++ and nvcc would otherwise fuse a * b + c, each
# where it likes), so that the CPU and CUDA compute the same bytes. MSVC fuses only if /fp:contract asks for it.
function(softcd_target_options target)
  target_compile_features(${target} PRIVATE cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON
                                             CXX_VISIBILITY_PRESET hidden CUDA_VISIBILITY_PRESET hidden
                                             VISIBILITY_INLINES_HIDDEN ON)
  # With CMAKE_UNITY_BUILD all sources of a target are compiled as one.
  set_target_properties(${target} PROPERTIES UNITY_BUILD_BATCH_SIZE 0 UNITY_BUILD_CODE_BEFORE_INCLUDE
                                             "// NOLINTNEXTLINE(bugprone-suspicious-include)")
  if(MSVC)
    # Without the last one, std::stable_sort refuses types that hold Bullet's vectors, which are aligned to 16 bytes.
    target_compile_definitions(${target} PRIVATE NOMINMAX _USE_MATH_DEFINES _CRT_SECURE_NO_WARNINGS
                                                 _ENABLE_EXTENDED_ALIGNED_STORAGE)
    target_compile_options(${target} PRIVATE
      $<$<COMPILE_LANGUAGE:CXX>:/fp:precise /permissive- /Zc:__cplusplus /utf-8 /bigobj /W3>)
    return()
  endif()
  if(MINGW)
    target_compile_options(${target} PRIVATE ${SOFTCD_MINGW_OPTIONS})
  endif()
  set(warnings -Wall -Wextra -Wshadow -Wconversion -Wnon-virtual-dtor -Woverloaded-virtual)
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-ffp-contract=off>
                                           $<$<COMPILE_LANGUAGE:CXX>:${warnings} -Wpedantic>)
  if(SOFTCD_HAS_CUDA)
    list(JOIN warnings "," host_warnings)
    # CMake 3.24 and 3.25 do not know that nvcc compiles C++20, hence no CUDA_STANDARD.
    target_compile_options(${target} PRIVATE
      $<$<COMPILE_LANGUAGE:CUDA>:-std=c++20 --fmad=false -Wno-deprecated-gpu-targets
                                 -Xcompiler=-ffp-contract=off,${host_warnings}>)
  endif()
endfunction()

# The folder of a program or library, to its dynamic loader. Windows looks there anyway.
set(SOFTCD_RPATH_ORIGIN "$ORIGIN" CACHE INTERNAL "")
if(APPLE)
  set(SOFTCD_RPATH_ORIGIN "@loader_path" CACHE INTERNAL "")
endif()

# Libraries that users link. Shared ones stand beside those of incompatible versions, and find each other.
function(softcd_library_options target)
  set_target_properties(${target} PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${SOFTCD_ABI_VERSION}
                                             INSTALL_RPATH "${SOFTCD_RPATH_ORIGIN}")
  if(MINGW)
    target_compile_options(${target} INTERFACE ${SOFTCD_MINGW_OPTIONS})
  endif()
endfunction()

# A module that another program loads. It finds libraries beside it, and exports only names that match `pattern`. Windows
# exports what is declared so.
function(softcd_module_options target pattern)
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "${SOFTCD_RPATH_ORIGIN}")
  if(APPLE)
    target_link_options(${target} PRIVATE "LINKER:-exported_symbol,_${pattern}")
  elseif(UNIX)
    set(version_script "${CMAKE_CURRENT_BINARY_DIR}/${target}.map")
    file(CONFIGURE OUTPUT "${version_script}" CONTENT "{ global: ${pattern}; local: *; };\n")
    target_link_options(${target} PRIVATE "LINKER:--version-script=${version_script}")
    set_target_properties(${target} PROPERTIES LINK_DEPENDS "${version_script}")
  endif()
endfunction()

# If Bullet's headers are precompiled, g++ warns of vectors that Bullet leaves uninitialized on purpose.
function(softcd_allow_uninitialized_vectors target)
  target_compile_options(${target} PRIVATE
    $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<CONFIG:Release>,$<CXX_COMPILER_ID:GNU>>:-Wno-maybe-uninitialized>)
endfunction()

# For tests: a Release that compiles in half the time of -O3. For nothing whose speed counts: of the library's templates
# a program gets one copy, which may be the one that was compiled quickly.
function(softcd_compile_quickly target)
  softcd_allow_uninitialized_vectors(${target})
  if(NOT MSVC)
    target_compile_options(${target} PRIVATE $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<CONFIG:Release>>:-O1>)
  endif()
endfunction()

# For precompiled headers.
set(SOFTCD_BULLET_HEADERS <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h> <BulletSoftBody/btSoftBodyHelpers.h>
                          <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
                          <BulletSoftBody/btSoftMultiBodyDynamicsWorld.h>)
