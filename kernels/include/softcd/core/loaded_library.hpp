#pragma once

#if defined(_WIN32)
#if !defined(NOMINMAX)
#define NOMINMAX
#endif
#include <windows.h>
#elif !defined(__EMSCRIPTEN__)
#include <dlfcn.h>
#endif

#include <string>

namespace softcd {

/// A library that the program loads while it runs, and keeps until it ends. An installed program needs no such library.
class LoadedLibrary {
 public:
  /// Loads `name`, unless the program has it already. Searches where the system searches for libraries.
  explicit LoadedLibrary(const char* name) : name_(name) {
#if defined(_WIN32)
    library_ = LoadLibraryA(name);
    if (library_ == nullptr) problem_ = name_ + " cannot be loaded: error " + std::to_string(GetLastError());
#elif defined(__EMSCRIPTEN__)
    problem_ = name_ + " cannot be loaded: WebAssembly loads no libraries";  // its dlopen() would end the program
#else
    library_ = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    if (library_ == nullptr) problem_ = dlerror();
#endif
  }

  /// Sets `function` to the library's function `name`, or to null where there is none.
  template <class Function>
  void find(const char* name, Function*& function) {
    function = nullptr;
    if (library_ == nullptr) return;
#if defined(_WIN32)
    function = reinterpret_cast<Function*>(reinterpret_cast<void*>(GetProcAddress(library_, name)));
#elif !defined(__EMSCRIPTEN__)
    function = reinterpret_cast<Function*>(dlsym(library_, name));
#endif
    if (function == nullptr) problem_ = name_ + " has no " + name;
  }

  /// Returns why the library or a function is missing, or an empty text.
  const std::string& problem() const {
    return problem_;
  }

 private:
  std::string name_, problem_;
#if defined(_WIN32)
  HMODULE library_ = nullptr;
#else
  void* library_ = nullptr;
#endif
};

}  // namespace softcd
