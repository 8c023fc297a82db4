#pragma once

// Starts other programs, which each system does in its own way.

#if !defined(_WIN32)
#include <unistd.h>
#endif

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>

namespace softcd::demo {

/// Returns whether a folder of the PATH has the program.
inline bool is_installed(const std::string& program) {
#if defined(_WIN32)
  constexpr char kSeparator = ';';
  const auto can_run = [](std::filesystem::path file) { return std::filesystem::exists(file += ".exe"); };
#else
  constexpr char kSeparator = ':';
  const auto can_run = [](const std::filesystem::path& file) { return access(file.c_str(), X_OK) == 0; };
#endif
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, kSeparator);) {
    if (can_run(std::filesystem::path(folder) / program)) return true;
  }
  return false;
}

/// Quotes a word for the shell that open_pipe_to() uses.
inline std::string as_shell_word(const std::string& word) {
#if defined(_WIN32)
  return '"' + word + '"';  // a file's name has no quotation marks there
#else
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
#endif
}

/// From now on, writing to a program that has ended fails instead of ending this one.
inline void ignore_closed_pipes() {
#if !defined(_WIN32)
  std::signal(SIGPIPE, SIG_IGN);
#endif
}

/// Starts a command that reads what is written into the pipe. Returns null where it cannot start.
inline std::FILE* open_pipe_to(const std::string& command) {
#if defined(_WIN32)
  return _popen(command.c_str(), "wb");
#else
  return popen(command.c_str(), "w");
#endif
}

/// Waits for the command to end, and returns its status.
inline int close_pipe(std::FILE* pipe) {
#if defined(_WIN32)
  return _pclose(pipe);
#else
  return pclose(pipe);
#endif
}

}  // namespace softcd::demo
