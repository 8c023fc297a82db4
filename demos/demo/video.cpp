#include "video.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "other_program.hpp"

namespace softcd::demo {

Video::Video(std::string file, int frames_per_second) : file_(std::move(file)), frames_per_second_(frames_per_second) {
  if (!is_installed("ffmpeg")) {
    throw std::runtime_error(fmt::format(
        "{}: videos are written by the program ffmpeg, which is not installed (--record DIR writes pictures)", file_));
  }
  ignore_closed_pipes();
}

Video::~Video() {
  if (pipe_ != nullptr) close_pipe(pipe_);
}

void Video::add(const Image& frame) {
  if (pipe_ == nullptr) {
    const std::string command = fmt::format(
        "ffmpeg -y -loglevel error -f rawvideo -pixel_format rgb24 -video_size {}x{} -framerate {} -i - "
        "-pix_fmt yuv420p file:{}",
        frame.width, frame.height, frames_per_second_, as_shell_word(file_));
    pipe_ = open_pipe_to(command);
  }
  if (pipe_ == nullptr || std::fwrite(frame.rgb.data(), 1, frame.rgb.size(), pipe_) != frame.rgb.size()) {
    throw std::runtime_error(fmt::format("{}: ffmpeg takes no more frames", file_));
  }
}

void Video::finish() {
  if (pipe_ == nullptr) return;
  const int status = close_pipe(std::exchange(pipe_, nullptr));
  if (status != 0) throw std::runtime_error(fmt::format("{}: ffmpeg could not write it", file_));
}

}  // namespace softcd::demo
