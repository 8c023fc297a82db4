#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "softcd/softcd.hpp"

namespace softcd::python {

/// One value for each vertex.
using VertexBits = nb::ndarray<const std::uint32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

/// Pairs of bodies' numbers, as Python has them.
using NumberPairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

inline std::vector<BodyPair> body_pairs(const NumberPairs& numbers) {
  std::vector<BodyPair> pairs;
  pairs.reserve(numbers.size());
  for (const auto& [a, b] : numbers) pairs.push_back({{a}, {b}});
  return pairs;
}

/// Nothing, or one object, with what it takes to be discarded: letting go of it allocates nothing.
using Discardable = std::list<std::shared_ptr<const void>>;

/// What Python has let go of, in whatever thread, and what is given back in a scene's next call, as one thread at a
/// time may use it. What is still there when the last owner goes is given back then.
class Discarded {
 public:
  void add(Discardable& object) noexcept {
    const std::lock_guard lock(mutex_);
    objects_.splice(objects_.end(), object);
  }
  void give_back() {
    Discardable objects;
    const std::lock_guard lock(mutex_);
    objects.swap(objects_);
  }

 private:
  std::mutex mutex_;
  Discardable objects_;
};

/// Keeps contacts for as long as an array shows them.
class HeldContacts {
 public:
  HeldContacts(std::shared_ptr<const void> contacts, std::shared_ptr<Discarded> discarded)
      : contacts_(1), discarded_(std::move(discarded)) {
    contacts_.front() = std::move(contacts);
  }
  HeldContacts(HeldContacts&&) noexcept = default;
  HeldContacts& operator=(HeldContacts&&) = delete;
  ~HeldContacts() {
    if (discarded_ != nullptr) discarded_->add(contacts_);
  }

 private:
  Discardable contacts_;
  std::shared_ptr<Discarded> discarded_;
};

/// softcd::Scene for Python: calls from several threads wait for each other, without the interpreter's lock, and arrays
/// that were set stay alive until they have been read; those on a GPU until a detection has read others in their place.
class BoundScene {
 public:
  BoundScene(const SceneOptions& options, nb::object log);
  BoundScene(const BoundScene&) = delete;
  BoundScene& operator=(const BoundScene&) = delete;

  std::uint32_t add_body(nb::handle triangles, std::uint32_t vertex_count, nb::handle segments,
                         const BodySettings& settings);
  void update_body(std::uint32_t body, nb::handle triangles, std::uint32_t vertex_count, nb::handle segments,
                   nb::handle changed, const BodySettings& settings);
  void set_settings(std::uint32_t body, const BodySettings& settings);
  void remove_body(std::uint32_t body);
  bool has_body(std::uint32_t body);
  void set_positions(std::uint32_t body, nb::handle vertices_t0, nb::handle vertices_t1, bool check_finite);
  void set_ignored_pairs(const NumberPairs& pairs);
  void set_vertex_filters(std::uint32_t body, const std::optional<VertexBits>& groups,
                          const std::optional<VertexBits>& masks);
  void set_rest_positions(std::uint32_t body, nb::handle vertices);

  SceneOptions options();
  Backend backend();
  std::uint32_t body_count() const { return body_count_; }

  /// f(scene), alone, without the interpreter's lock. Throws Error in a callback that a call of the scene makes.
  template <class F>
  auto call(const F& f) {
    if (user_ == std::this_thread::get_id()) {
      throw Error("a pair filter or log callback must not call the scene or its queries.");
    }
    const nb::gil_scoped_release no_interpreter;
    const std::lock_guard alone(mutex_);
    const InUse use(user_);
    discarded_->give_back();
    return f(scene_);
  }
  /// The same where f reads what was set. When it throws, it may not have.
  template <class F>
  auto call_and_read(const F& f) {
    KeptArrays read;  // let go of with the interpreter's lock
    std::vector<Array> replaced;
    return call([&](Scene& scene) {
      auto result = f(scene);
      read.swap(kept_);
      replaced.swap(replaced_);
      return result;
    });
  }

  const std::shared_ptr<Discarded>& discarded() const { return discarded_; }

  int traverse(visitproc visit, void* arg);
  void clear();

 private:
  using KeptArrays = std::map<std::uint32_t, std::array<Array, 2>>;

  /// Says which thread uses the scene.
  class InUse {
   public:
    explicit InUse(std::atomic<std::thread::id>& user) : user_(user) { user_ = std::this_thread::get_id(); }
    ~InUse() { user_ = std::thread::id(); }
    InUse(const InUse&) = delete;
    InUse& operator=(const InUse&) = delete;

   private:
    std::atomic<std::thread::id>& user_;
  };

  void log(LogLevel level, std::string_view text);
  void replace_on_device(std::uint32_t body);

  std::mutex mutex_;
  std::atomic<std::thread::id> user_;
  nb::object log_;
  KeptArrays kept_;              ///< read by the next detection
  KeptArrays on_device_;         ///< read by any
  std::vector<Array> replaced_;  ///< that were on_device_, until the next detection
  std::shared_ptr<Discarded> discarded_ = std::make_shared<Discarded>();
  std::atomic<std::uint32_t> body_count_ = 0;
  Scene scene_;
};

}  // namespace softcd::python
