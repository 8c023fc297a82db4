# Debian's Emscripten, and node for what is run. SOFTCD_CROSS_PREFIX has the libraries.
include(/usr/share/emscripten/cmake/Modules/Platform/Emscripten.cmake)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SOFTCD_CROSS_PREFIX)
list(APPEND CMAKE_FIND_ROOT_PATH "${SOFTCD_CROSS_PREFIX}")
# Emscripten 3.1.6 does not know that node itself has fetch, which reads no files. libc++ 13 lacks some of C++20.
set(CMAKE_CROSSCOMPILING_EMULATOR "node;--no-experimental-fetch")
set(CMAKE_CXX_FLAGS_INIT "-msimd128 -fwasm-exceptions -w -Wno-c++11-narrowing -isystem ${CMAKE_CURRENT_LIST_DIR}/web -include ${CMAKE_CURRENT_LIST_DIR}/web/libcxx_13.hpp")
set(CMAKE_C_FLAGS_INIT "-msimd128 -fwasm-exceptions")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-sALLOW_MEMORY_GROWTH=1 -sEXIT_RUNTIME=1 -L${SOFTCD_CROSS_PREFIX}/lib")
