// Public headers after Windows' own, which define min, max, near, far and many more as macros.

#include <windows.h>

#include "detector.cpp"
