#pragma once

#include <cstdio>
#include <string>

#include "viewer/image.hpp"

namespace softcd::demo {

/// Encodes a video with the program ffmpeg as frames are added. All frames must have one size.
class Video {
 public:
  /// Throws std::runtime_error when ffmpeg is not installed.
  Video(std::string file, int frames_per_second);
  ~Video();
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;

  void add(const Image& frame);
  /// Ends the video. Call it after the last frame. Throws std::runtime_error when ffmpeg has failed; ffmpeg has then
  /// printed the reason.
  void finish();

 private:
  std::string file_;
  int frames_per_second_;
  std::FILE* pipe_ = nullptr;  ///< to ffmpeg, from the first frame on
};

}  // namespace softcd::demo
