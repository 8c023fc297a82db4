#include "bodies/guarded.hpp"

#include <array>
#include <cstdio>
#include <new>
#include <utility>

namespace softcd::bullet {

void DetectorRecord::set_detector(const Query* query, Explain explain) {
  if (query_ != nullptr) statistics_ = query_->statistics();
  query_ = query;
  explain_ = std::move(explain);
}

void Failures::note(const Settings& settings) {
  try {
    throw;
  } catch (const Error& error) {
    go_on(settings, error.what());
  } catch (const std::bad_alloc&) {
    go_on(settings, "out of memory");
  }
}

void Failures::go_on(const Settings& settings, const char* cause) {
  ++count_;
  if (settings.on_error == OnError::throw_error) throw;
  if (std::exchange(has_warned_, true) || !settings.log) return;
  // Allocates nothing, because memory may have run out.
  std::array<char, 512> text{};
  std::snprintf(text.data(), text.size(), "%s, because softcd failed (later failures are not logged): %s", outcome_,
                cause);
  settings.log(LogLevel::warning, text.data());
}

}  // namespace softcd::bullet
