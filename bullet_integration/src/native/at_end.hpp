#pragma once

#include <utility>

namespace softcd::bullet {

/// Calls a function at the end of a scope, also if an exception leaves it.
template <class Function>
class AtEnd {
 public:
  explicit AtEnd(Function function) : function_(std::move(function)) {}
  ~AtEnd() { function_(); }
  AtEnd(const AtEnd&) = delete;
  AtEnd& operator=(const AtEnd&) = delete;

 private:
  Function function_;
};

}  // namespace softcd::bullet
