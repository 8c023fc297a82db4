#include "video.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace softcd::demo {
namespace {

bool is_installed(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (access((std::filesystem::path(folder) / program).c_str(), X_OK) == 0) return true;
  }
  return false;
}

std::string as_shell_word(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

}  // namespace

Video::Video(std::string file, int frames_per_second) : file_(std::move(file)), frames_per_second_(frames_per_second) {
  if (!is_installed("ffmpeg")) {
    throw std::runtime_error(fmt::format(
        "{}: videos are written by the program ffmpeg, which is not installed (--record DIR writes pictures)", file_));
  }
  // If ffmpeg ends early, writing to it fails instead of ending this program.
  std::signal(SIGPIPE, SIG_IGN);
}

Video::~Video() {
  if (pipe_ != nullptr) pclose(pipe_);
}

void Video::add(const Image& frame) {
  if (pipe_ == nullptr) {
    const std::string command = fmt::format(
        "ffmpeg -y -loglevel error -f rawvideo -pixel_format rgb24 -video_size {}x{} -framerate {} -i - "
        "-pix_fmt yuv420p file:{}",
        frame.width, frame.height, frames_per_second_, as_shell_word(file_));
    pipe_ = popen(command.c_str(), "w");
  }
  if (pipe_ == nullptr || std::fwrite(frame.rgb.data(), 1, frame.rgb.size(), pipe_) != frame.rgb.size()) {
    throw std::runtime_error(fmt::format("{}: ffmpeg takes no more frames", file_));
  }
}

void Video::finish() {
  if (pipe_ == nullptr) return;
  const int status = pclose(std::exchange(pipe_, nullptr));
  if (status != 0) throw std::runtime_error(fmt::format("{}: ffmpeg could not write it", file_));
}

}  // namespace softcd::demo
